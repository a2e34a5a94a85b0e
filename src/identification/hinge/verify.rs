//! A pose that identified nothing, held against the identified hinge.

use super::estimator::HingeEstimator;
use super::pose::{AngleSearch, PoseAt};
use super::rig::MAX_CABLES;
use crate::linear_algebra::NormalEquations;
use crate::scalar::Real;

/// Gauss-Newton rounds for the angle.
const ROUNDS: usize = 8;
/// Entries of the packed covariance of a pose's residuals.
const PACKED: usize = MAX_CABLES * (MAX_CABLES + 1) / 2;

/// What a pose leaves, its angle at its best: one degree of freedom less than there are cables.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VerifiedAngle<T> {
    /// From the hinge's own zero, rad.
    pub angle_rad: T,
    /// Sum of the squared length residuals, mm².
    pub squares_mm2: T,
    /// χ² of the same against the noise and the covariance of the estimate.
    pub chi_square: T,
}

impl<T: Real> HingeEstimator<T> {
    /// Holds a pose with these lengths, mm, against the hinge: rᵀ (σ² + J Σ Jᵀ)⁻¹ r with residuals r and their derivatives J,
    /// the angle eliminated. `None` when they are no numbers. After [`run`](Self::run) has given a result.
    pub fn verify(&self, lengths_mm: &[T; MAX_CABLES]) -> Option<VerifiedAngle<T>> {
        let fit = &self.work.fit;
        let at = PoseAt::new(&fit.hinge, &fit.machine);
        let from =
            AngleSearch::new(&fit.hinge, &fit.machine, fit.range_rad()).nearest_rad(lengths_mm, fit.machine.cables());
        let (angle_rad, squares_mm2) = at.best_angle(lengths_mm, from, ROUNDS);
        let mut rows = at.rows(lengths_mm, angle_rad, fit.constants);
        let by_angle = rows.by_angle;
        rows.eliminate(&by_angle, fit.unknowns());
        rows.jacobian.iter_mut().for_each(|row| fit.equations.whiten(row));
        // In variances of the noise. What the angle explains is gone from both sides: its direction only needs to be regular.
        let mut covariance = NormalEquations::<T, MAX_CABLES, PACKED>::new(MAX_CABLES);
        for (i, a) in rows.jacobian.iter().enumerate() {
            covariance.add_to_entry(i, i, T::one());
            for (j, b) in rows.jacobian.iter().enumerate().take(i + 1) {
                covariance.add_to_entry(i, j, a.iter().zip(b).fold(T::zero(), |sum, (a, b)| sum + *a * *b));
            }
            covariance.add_to_gradient(i, rows.residual_mm.get(i).copied().unwrap_or_else(T::zero));
        }
        covariance.factor().ok()?;
        let weighted = covariance.step();
        let product = rows.residual_mm.iter().zip(&weighted).fold(T::zero(), |sum, (r, w)| sum + *r * *w);
        let noise_mm = self.work.found.noise_mm;
        let chi_square = product / (noise_mm * noise_mm);
        let is_sound = chi_square.is_a_number() && squares_mm2.is_a_number();
        is_sound.then_some(VerifiedAngle { angle_rad, squares_mm2, chi_square })
    }
}
