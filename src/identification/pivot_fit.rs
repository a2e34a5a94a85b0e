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

    /// The pivot that fits the poses best.
    ///
    /// # Errors
    /// [`Singular`] when the poses leave some direction of it undetermined, as for the normal equations of all six.
    #[inline(never)]
    pub fn solve(&self) -> Result<Pivot<T>, Singular> {
        let (mean, share) = self.rotations.mean().ok_or(Singular)?;
        let origin = scaled(&self.origins, share);
        let right = difference(&image_transposed(&mean, &origin), &scaled(&self.turned_origins, share));
        // Each pivot of 1 - R̄ᵀR̄ began as the 1 on the diagonal.
        let inverse = lacking(&mean).inverse(&Symmetric::diagonal(T::one()), smallest_pivot()).ok_or(Singular)?;
        let in_platform_mm = inverse.image(&right);
        Ok(Pivot { in_base_mm: sum(&origin, &image(&mean, &in_platform_mm)), in_platform_mm })
    }
}
