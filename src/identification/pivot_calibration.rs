//! Pivot calibration: the joint centre that is fixed in both bodies, from platform poses alone (symmetrical centre of
//! rotation estimation, SCoRE; Ehrig et al. 2006). Where the estimator begins; it needs no start itself.
//!
//! Every platform pose with rotation R and origin t says O - R C = t (see
//! [`length_jacobian`](crate::kinematics::length_jacobian)). With the means R̄, t̄ and r̄ of R, t and Rᵀt over the
//! poses the normal equations of (O, C) are
//!
//! ```text
//! | 1   -R̄ | |O|   | t̄ |
//! | -R̄ᵀ  1 | |C| = |-r̄ |    so    (1 - R̄ᵀR̄) C = R̄ᵀt̄ - r̄,    O = t̄ + R̄ C
//! ```
//!
//! three unknowns instead of six, from fifteen sums.

use super::excitation::MeanRotation;
use crate::kinematics::{JointCentre, PlatformPose};
use crate::linear_algebra::normal_equations::smallest_pivot;
use crate::linear_algebra::{Singular, inverse_of_eliminated};
use crate::scalar::Real;
use nalgebra::{Matrix3, Vector3};

/// The sums over the poses added so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PivotCalibration<T> {
    rotations: MeanRotation<T>,
    /// Σ t, mm.
    origins: Vector3<T>,
    /// Σ Rᵀt, mm.
    turned_origins: Vector3<T>,
}

impl<T: Real> Default for PivotCalibration<T> {
    fn default() -> Self {
        Self { rotations: MeanRotation::default(), origins: Vector3::zeros(), turned_origins: Vector3::zeros() }
    }
}

impl<T: Real> PivotCalibration<T> {
    /// Adds a platform pose (mm, {P} to {B}).
    pub fn add(&mut self, pose: &PlatformPose<T>) {
        self.rotations.add(&pose.rotation);
        self.origins += pose.origin_mm;
        self.turned_origins += pose.rotation.tr_mul(&pose.origin_mm);
    }

    /// The rotations of the poses.
    pub fn rotations(&self) -> &MeanRotation<T> {
        &self.rotations
    }

    /// The joint centre in both bodies, mm: the least-squares solution over the poses added.
    ///
    /// # Errors
    /// [`Singular`] when the poses leave some direction of it undetermined.
    pub fn solve(&self) -> Result<JointCentre<T>, Singular> {
        let (poses, rotations) = (self.rotations.poses(), self.rotations.sum());
        // All of it times n²: the means are never formed.
        let right = rotations.tr_mul(&self.origins) - self.turned_origins * poses;
        let whole = Matrix3::from_diagonal_element(poses * poses);
        let matrix = whole - rotations.tr_mul(rotations);
        // Each pivot began as the n² on the diagonal.
        let inverse = inverse_of_eliminated(&matrix, &whole, smallest_pivot()).ok_or(Singular)?;
        let in_platform_mm = inverse * right;
        let in_base_mm = (self.origins + rotations * in_platform_mm) * (T::one() / poses);
        Ok(JointCentre { in_base_mm, in_platform_mm })
    }
}
