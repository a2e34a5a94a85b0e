//! The held phase: poses in which the shoulder blade was held fix the joint centre in the platform.

use crate::identification::parameters::Equations;
use crate::linear_algebra::{inverse_of_positive_definite, rounding, solve_positive_definite};
use crate::scalar::Real;
use nalgebra::{Matrix3, Vector3};

/// A "held" shoulder blade still moves a little: the centre that a ball fit of such poses gives is off by two to four
/// times their scatter. Its standard deviation is so many times the scatter, across the arm and along it.
const ACROSS: f64 = 2.5;
const ALONG: f64 = 2.0;

/// Minimum number of poses of a held phase.
pub const MIN_HELD_POSES: usize = 8;

/// Squared Mahalanobis distance between the joint centres of held and free poses beyond which they belong to two
/// wearings: of one wearing at most 8 in 400.
const MAX_SQUARED_DISTANCE: f64 = 12.0;

/// The joint centre in the platform as the held phase gives it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldCentre<T> {
    /// C, mm.
    pub in_platform_mm: Vector3<T>,
    /// Its covariance, mm².
    pub covariance_mm2: Matrix3<T>,
}

impl<T: Real> HeldCentre<T> {
    /// From the ball fit of the held poses: C, its covariance by that fit, and the scatter of the poses' own centres
    /// along an axis, mm. The arm's direction is z of {P}.
    pub fn new(in_platform_mm: Vector3<T>, fit_mm2: &Matrix3<T>, scatter_mm: T) -> Self {
        let square = |times: f64| {
            let sigma = scatter_mm * T::of(times);
            sigma * sigma
        };
        let scatter = Matrix3::from_diagonal(&Vector3::new(square(ACROSS), square(ACROSS), square(ALONG)));
        Self { in_platform_mm, covariance_mm2: fit_mm2 + scatter }
    }

    /// Distance between the joint centres of held and free poses, mm, if it is too large for one wearing. `both`: the
    /// estimate from the free poses with the held phase as prior.
    ///
    /// With P the covariance of the held phase and Q that of both, an estimate from both lies d off the held phase with
    /// covariance P - Q, and the free poses alone would lie P (P - Q)⁻¹ d off.
    pub fn contradiction_mm(&self, both: &Self) -> Option<T> {
        let moved = self.in_platform_mm - both.in_platform_mm;
        let expected = self.covariance_mm2 - both.covariance_mm2;
        let weighted = solve_positive_definite(&expected, &moved, rounding())?;
        let too_far = moved.dot(&weighted) > T::of(MAX_SQUARED_DISTANCE);
        too_far.then(|| (self.covariance_mm2 * weighted).norm_squared().root())
    }

    /// Adds it as a prior on C, whose unknowns begin at `first`. `now_mm`: the present C, mm; `variance_mm2`: of the
    /// noise.
    pub fn add_prior(&self, equations: &mut Equations<T>, first: usize, now_mm: &Vector3<T>, variance_mm2: T) {
        let Some(precision) = inverse_of_positive_definite(&self.covariance_mm2, rounding()) else { return };
        let weight = precision * variance_mm2;
        let off = self.in_platform_mm - now_mm;
        let pull = weight * off;
        for i in 0..3 {
            for j in 0..=i {
                equations.add_to_entry(first + i, first + j, weight[(i, j)]);
            }
            equations.add_to_gradient(first + i, pull[i]);
        }
        equations.add_squares(off.dot(&pull));
    }
}
