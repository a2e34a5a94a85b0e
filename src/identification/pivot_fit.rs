//! The linear fit of the joint centre to platform poses: where the start-free solver begins.
//!
//! Every platform pose with rotation R and origin t says O - R C = t (see [`pivot`](crate::kinematics::pivot)). With
//! the means R̄, t̄ and r̄ of R, t and Rᵀt over the poses the normal equations of (O, C) are
//!
//! ```text
//! | 1   -R̄ | |O|   | t̄ |
//! | -R̄ᵀ  1 | |C| = |-r̄ |    so    (1 - R̄ᵀR̄) C = R̄ᵀt̄ - r̄,    O = t̄ + R̄ C
//! ```
//!
//! three unknowns instead of six, from fifteen sums.

use super::normal_equations::{Singular, smallest_pivot};
use super::observability::RotationSum;
use crate::calls::{self, accumulate};
use crate::kinematics::{Pivot, PlatformPose};
use crate::scalar::Real;
use crate::vector::{difference, dot, image, image_transposed, scaled, sum};
use nalgebra::Vector3;

/// The sums over the poses added so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PivotFit<T> {
    rotations: RotationSum<T>,
    /// Σ t, mm.
    origins: Vector3<T>,
    /// Σ Rᵀt, mm.
    turned_origins: Vector3<T>,
}

impl<T: Real> Default for PivotFit<T> {
    fn default() -> Self {
        Self { rotations: RotationSum::default(), origins: Vector3::zeros(), turned_origins: Vector3::zeros() }
    }
}

impl<T: Real> PivotFit<T> {
    /// Adds a platform pose.
    #[inline(never)]
    pub fn add(&mut self, pose: &PlatformPose<T>) {
        self.rotations.add(&pose.rotation);
        accumulate(self.origins.as_mut_slice(), pose.origin_mm.as_slice());
        let turned = calls::image_transposed(&pose.rotation, &pose.origin_mm);
        accumulate(self.turned_origins.as_mut_slice(), turned.as_slice());
    }

    /// The rotations of the poses.
    pub fn rotations(&self) -> &RotationSum<T> {
        &self.rotations
    }

    /// Puts the pivot where it fits the poses best.
    ///
    /// # Errors
    /// [`Singular`] when the poses leave some direction of it undetermined, as for the normal equations of all six.
    #[inline(never)]
    pub fn solve(&self, pivot: &mut Pivot<T>) -> Result<(), Singular> {
        let (poses, rotations) = (self.rotations.poses(), self.rotations.sum());
        // All of it times n²: the means are never formed.
        let right = difference(&image_transposed(rotations, &self.origins), &scaled(&self.turned_origins, poses));
        // n² - SᵀS, lower triangle, and its factors L D Lᵀ in words: half the time of a general routine. Each pivot began
        // as the n² on the diagonal.
        let [x, y, z] = &rotations.data.0.map(Vector3::from);
        let squared = poses * poses;
        let smallest = squared * smallest_pivot();
        let d1 = squared - dot(x, x);
        let (a21, a31) = (-dot(y, x), -dot(z, x));
        let (l21, l31) = (a21 / d1, a31 / d1);
        let d2 = squared - dot(y, y) - l21 * a21;
        let a32 = -dot(z, y) - l31 * a21;
        let l32 = a32 / d2;
        let d3 = squared - dot(z, z) - l31 * a31 - l32 * a32;
        // Also refuses NaN.
        if !(d1 > smallest && d2 > smallest && d3 > smallest) {
            return Err(Singular);
        }
        let u = right.x;
        let v = right.y - l21 * u;
        let w = (right.z - l31 * u - l32 * v) / d3;
        let v = v / d2 - l32 * w;
        let u = u / d1 - l21 * v - l31 * w;
        pivot.in_platform_mm = Vector3::new(u, v, w);
        pivot.in_base_mm = scaled(&sum(&self.origins, &image(rotations, &pivot.in_platform_mm)), T::one() / poses);
        Ok(())
    }
}
