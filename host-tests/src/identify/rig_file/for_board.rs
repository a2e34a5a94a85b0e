//! A commissioned rig as a board can hold it: tolerances in the place of the covariance.
//!
//! A board has one tolerance for each kind of constant, and no correlations. Any tolerances D whose difference from the
//! covariance Σ is positive semidefinite keep the bar honest: with a gain K that is made for D, the real covariance (I - KH) Σ
//! (I - KH)ᵀ + K R Kᵀ is no larger than the reported one, which has D in the place of Σ. The price is a wider bar.

use super::RigFile;
use glenoid::identification::Machine;
use glenoid::identification::machine::{MachineParameter, SCALE_UNIT};
use glenoid::linear_algebra::packed_index;
use glenoid::rig::{Rig, RigError, Tolerance};
use nalgebra::{DMatrix, DVector};

/// Base, platform, offsets, drums.
const KINDS: usize = 4;

impl RigFile {
    /// The rig for a board: where there is a covariance, with the tolerances that cover it.
    ///
    /// # Errors
    /// [`RigError::ToleranceImpossible`] for a covariance beyond what a tolerance may be.
    pub fn for_board(&self) -> Result<Rig<f64>, RigError> {
        let Some(triangle) = &self.covariance else { return Ok(self.rig) };
        let machine = Machine::new(&self.rig);
        let count = machine.parameters();
        let covariance = DMatrix::from_fn(count, count, |i, j| triangle[packed_index(i.max(j), i.min(j))]);
        let kinds: Vec<usize> = (0..count).map(|index| kind(machine.parameter(index))).collect();
        let [base_mm, edges_mm, offset_mm, scale] = covering(&covariance, &kinds);
        self.rig.with_tolerance(Tolerance { base_mm, edges_mm, offset_mm, drum: scale * SCALE_UNIT })
    }
}

const fn kind(parameter: MachineParameter) -> usize {
    match parameter {
        MachineParameter::Base(_) => 0,
        MachineParameter::Ends(_) => 1,
        MachineParameter::Offset(_) => 2,
        MachineParameter::Scale(_) => 3,
    }
}

/// 1σ of each kind, so that independent parameters of these σ cover the covariance: those of the worst direction within each
/// kind, and all of them larger by what the correlations between kinds ask for.
fn covering(covariance: &DMatrix<f64>, kinds: &[usize]) -> [f64; KINDS] {
    let largest = |matrix: DMatrix<f64>| matrix.symmetric_eigenvalues().iter().copied().fold(0.0, f64::max);
    let of_kind: [f64; KINDS] = std::array::from_fn(|kind| {
        let own: Vec<usize> = (0..kinds.len()).filter(|index| kinds[*index] == kind).collect();
        if own.is_empty() { 0.0 } else { largest(covariance.select_rows(&own).select_columns(&own)).sqrt() }
    });
    if kinds.iter().any(|kind| of_kind[*kind] <= 0.0) {
        return of_kind;
    }
    let inverse = DMatrix::from_diagonal(&DVector::from_fn(kinds.len(), |index, _| 1.0 / of_kind[kinds[index]]));
    let times = largest(&inverse * covariance * &inverse).sqrt();
    of_kind.map(|sigma| sigma * times)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tolerances_cover_the_covariance_and_no_more() {
        // Two of one kind and one of another, strongly correlated.
        let covariance = DMatrix::from_row_slice(3, 3, &[4.0, 1.0, 1.5, 1.0, 2.0, 0.5, 1.5, 0.5, 1.0]);
        let kinds = [0, 0, 2];
        let [first, none, second, _] = covering(&covariance, &kinds);
        assert_eq!(none, 0.0);
        let diagonal = DMatrix::from_diagonal(&DVector::from_vec(vec![first * first, first * first, second * second]));
        let spare = (diagonal - &covariance).symmetric_eigenvalues();
        assert!(spare.min().abs() < 1e-12, "{spare}");
        // Their own worst directions alone would not do: the correlation between them counts.
        let alone = DMatrix::from_row_slice(3, 3, &[4.4142, 0.0, 0.0, 0.0, 4.4142, 0.0, 0.0, 0.0, 1.0]);
        assert!((alone - covariance).symmetric_eigenvalues().min() < -0.1);
    }
}
