//! Verification on a second set of poses, which did not identify: χ² of their residuals about the estimated centre
//! (step 4 of the paper's procedure, with the estimator's own model).

use super::joint::Joint;
use super::statistics::{FALSE_ALARM, chi_square_quantile};
use crate::linear_algebra::non_negative_root;
use crate::scalar::Real;
use nalgebra::{Matrix3, Vector3};

/// Residuals of a pose that was not used to identify, its rotation at its best.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VerifiedPose<T> {
    /// Sum of the squared length residuals, mm²: three degrees of freedom.
    pub squares_mm2: T,
    /// χ² of the same against the noise and the covariance of the estimate: three degrees of freedom.
    pub chi_square: T,
}

/// Where the joint centre is in one pose, in {B}.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CentrePrediction<T> {
    /// By the joint's model from the pose's rotation, mm.
    pub predicted_mm: Vector3<T>,
    /// Its covariance, mm².
    pub predicted_covariance_mm2: Matrix3<T>,
    /// From the pose's own six lengths, R C + t, mm.
    pub live_mm: Vector3<T>,
    /// Its covariance, mm².
    pub live_covariance_mm2: Matrix3<T>,
}

/// The root-mean-square residual at which `poses` poses with this χ² in all would be refused, mm: one false alarm in
/// 10 000 sound sets.
///
/// Of a ball all three residuals of a pose are independent. What the model of a moving centre leaves open it leaves to
/// neighbouring poses alike: only one of the three counts.
pub fn rms_limit_mm<T: Real>(rms_mm: T, chi_square: T, poses: usize, noise_mm: T, joint: &Joint<T>) -> T {
    let freedom = T::of_integer(3 * poses.max(1) as i32);
    let independent = match joint {
        Joint::Ball | Joint::Held(_) => freedom,
        Joint::Moving(_) => T::of_integer(poses.max(1) as i32),
    };
    let most = chi_square_quantile(independent, T::of(FALSE_ALARM)) * freedom / independent;
    if chi_square > T::zero() && rms_mm > T::zero() {
        rms_mm * non_negative_root(most / chi_square)
    } else {
        noise_mm * non_negative_root(most / freedom)
    }
}
