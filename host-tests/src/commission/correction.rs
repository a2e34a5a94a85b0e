//! The rig as it was found: corrected geometry, offsets and scales, and the covariance that is left.

use super::constants::moved;
use glenoid::identification::Machine;
use glenoid::identification::machine::MachineEstimate;
use glenoid::identification::machine::MachineParameter;
use glenoid::kinematics::Geometry;
use glenoid::rig::{CABLES, CableEnds, Correction, Rig, RigError};
use nalgebra::{DMatrix, DVector, Vector3};

/// `rig` with its geometry, offsets and scales as estimated.
///
/// # Errors
/// [`RigError`] for a machine that cannot be.
pub fn corrected(rig: &Rig<f64>, estimate: &MachineEstimate<f64>) -> Result<Rig<f64>, RigError> {
    let geometry = estimate.geometry();
    let (drum, noise_mm, nominal) = (*rig.drum(), rig.length_noise_mm(), *rig.nominal());
    let bare = match rig.cables() {
        Some(cables) => {
            let ends = std::array::from_fn(|cable| CableEnds {
                base_mm: geometry.base_mm[cable],
                end_mm: geometry.end_mm[cable],
                pulley: cables[cable].pulley,
            });
            Rig::with_cables(ends, drum, noise_mm, nominal)?
        }
        None => {
            let [b1, b2, _, b3, ..] = geometry.base_mm;
            let [p1, p2, p3] = geometry.end_points_mm();
            let edges_mm = [(p2 - p1).norm(), (p3 - p2).norm(), (p1 - p3).norm()];
            Rig::new([b1, b2, b3], edges_mm, drum, noise_mm, nominal)?
        }
    };
    let bare = bare.with_noise(noise_mm, rig.sample_noise_mm())?.with_tolerance(*rig.tolerance())?;
    // What was taken off the readings before stays taken off: reading = home + k0 (x - home) + z0 with
    // x = home + k1 (L - home) + z1.
    let before = rig.correction().copied().unwrap_or(Correction { offset_mm: [0.0; CABLES], scale: [1.0; CABLES] });
    let (offsets, scales) = (estimate.offsets_mm(), estimate.scales());
    bare.with_correction(Correction {
        offset_mm: std::array::from_fn(|k| before.offset_mm[k] + before.scale[k] * offsets[k]),
        scale: std::array::from_fn(|k| before.scale[k] * (1.0 + scales[k])),
    })
}

/// The covariance in the parameters of the corrected machine: offsets and scales act after the correction, the modes of
/// the base are those of the corrected points. `homing_mm`: what homing anew adds to each offset, 1σ.
pub fn covariance(
    machine: &Machine<f64>,
    estimate: &MachineEstimate<f64>,
    corrected: &Machine<f64>,
    covariance: &DMatrix<f64>,
    homing_mm: f64,
) -> DMatrix<f64> {
    let count = machine.parameters();
    let scales = estimate.scales();
    let mut change = DMatrix::identity(count, count);
    let base: Vec<usize> =
        (0..count).filter(|index| matches!(machine.parameter(*index), MachineParameter::Base(_))).collect();
    let (old, new) = (base_modes(machine, &base), base_modes(corrected, &base));
    // Least squares: the old modes in terms of the new ones.
    if let Some(inverse) = new.tr_mul(&new).try_inverse() {
        let turned = inverse * new.tr_mul(&old);
        change.view_mut((0, 0), (base.len(), base.len())).copy_from(&turned);
    }
    for index in 0..count {
        if let MachineParameter::Offset(cable) | MachineParameter::Scale(cable) = machine.parameter(index) {
            change[(index, index)] = 1.0 / (1.0 + scales[cable]);
        }
    }
    let mut covariance = &change * covariance * change.transpose();
    for index in 0..count {
        if let MachineParameter::Offset(_) = machine.parameter(index) {
            covariance[(index, index)] += homing_mm * homing_mm;
        }
    }
    covariance
}

/// How the base's ends move with each mode: a column a mode.
fn base_modes(machine: &Machine<f64>, modes: &[usize]) -> DMatrix<f64> {
    let stated = MachineEstimate::new(machine);
    let flat = |geometry: &Geometry<f64>| {
        DVector::from_iterator(3 * CABLES, geometry.base_mm.iter().flat_map(Vector3::iter).copied())
    };
    let rest = flat(machine.geometry());
    let mut matrix = DMatrix::zeros(3 * CABLES, modes.len());
    for (column, index) in modes.iter().enumerate() {
        matrix.set_column(column, &(flat(&moved(machine, &stated, *index, 1.0)) - &rest));
    }
    matrix
}
