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
use super::observability::{RotationSum, lacking};
use crate::calls::{difference, image, image_transposed, scaled};
use crate::kinematics::{Pivot, PlatformPose};
use crate::scalar::Real;
use crate::symmetric::Symmetric;
use crate::vector::{add_to, sum};
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
    pub fn add(&mut self, pose: &PlatformPose<T>) {
        self.rotations.add(&pose.rotation);
        add_to(&mut self.origins, &pose.origin_mm);
        add_to(&mut self.turned_origins, &image_transposed(&pose.rotation, &pose.origin_mm));
    }

    /// The rotations of the poses.
    pub fn rotations(&self) -> &RotationSum<T> {
        &self.rotations
    }

    /// Poses added.
    pub fn poses(&self) -> usize {
        self.rotations.count()
    }

    /// The pivot that fits the poses best.
    ///
    /// # Errors
    /// [`Singular`] when the poses leave some direction of it undetermined, as for the normal equations of all six.
    #[inline(never)]
    pub fn solve(&self) -> Result<Pivot<T>, Singular> {
        let (poses, rotations) = (self.rotations.poses(), self.rotations.sum());
        // All of it times n²: the means are never formed. Each pivot began as the n² on the diagonal.
        let right = difference(&image_transposed(rotations, &self.origins), &scaled(&self.turned_origins, poses));
        let squared = Symmetric::diagonal(poses * poses);
        let lacking = &lacking(rotations, poses);
        let Some(inverse) = &lacking.inverse(&squared, smallest_pivot()) else { return Err(Singular) };
        let in_platform_mm = inverse.image(&right);
        let in_base_mm = scaled(&sum(&self.origins, &image(rotations, &in_platform_mm)), T::one() / poses);
        Ok(Pivot { in_base_mm, in_platform_mm })
    }
}
