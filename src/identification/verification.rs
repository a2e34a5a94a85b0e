//! Verification on poses that identified nothing: their residuals about the estimated centre, by χ² (step 4 of the
//! paper's procedure, with the estimator's own model).

use super::statistics::{FALSE_ALARM, chi_square_quantile};
use crate::linear_algebra::non_negative_root;
use crate::scalar::Real;

/// What a pose that was not used to identify leaves, its rotation at its best.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VerifiedPose<T> {
    /// Sum of the squared length residuals, mm²: three degrees of freedom.
    pub squares_mm2: T,
    /// χ² of the same against the noise and the covariance of the estimate: three degrees of freedom.
    pub chi_square: T,
}

/// The root-mean-square residual at which `poses` poses with this χ² in all would be refused, mm: one false alarm in
/// 10 000 sound sets.
pub fn rms_limit_mm<T: Real>(rms_mm: T, chi_square: T, poses: usize, noise_mm: T) -> T {
    let freedom = T::of_integer(3 * poses.max(1) as i32);
    let most = chi_square_quantile(freedom, T::of(FALSE_ALARM));
    if chi_square > T::zero() && rms_mm > T::zero() {
        rms_mm * non_negative_root(most / chi_square)
    } else {
        noise_mm * non_negative_root(most / freedom)
    }
}
