//! Can these poses determine the centre at all? A question about their rotations alone.
//!
//! Every pose says δO = R δC (see [`pose_information`](super::pose_information)). The centre is free along `a` when
//! all poses agree on it: R_m a' = a for one a'. How well they agree is told by the mean rotation R̄ = Σ R_m / m: with
//! its singular values σ_i, the mean of |R_m a' - a|² over the poses is 2 (1 - σ_i) for the singular vectors a, a'.
//! So a largest singular value of one means a common axis, and its left singular vector is that axis in {B}.

use crate::calls::{accumulate, dot, image, root, unit};
use crate::scalar::Real;
use crate::symmetric::Symmetric;
use nalgebra::{Matrix3, Vector3};

/// Sum of the rotations of a set of poses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotationSum<T> {
    sum: Matrix3<T>,
    poses: usize,
}

/// How far a set of poses is from turning about one common axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sway<T> {
    /// The axis in {B} that the poses move least, a unit vector.
    pub axis: Vector3<T>,
    /// The same axis in {P}.
    pub axis_in_platform: Vector3<T>,
    /// Root-mean-square length by which the poses move that axis; for small angles, the angle in rad. 0 = one axis.
    pub least_rad: T,
    /// The same for the axis that they move second least. 0 as well = the poses are all alike.
    pub second_rad: T,
}

impl<T: Real> Default for RotationSum<T> {
    fn default() -> Self {
        Self { sum: Matrix3::zeros(), poses: 0 }
    }
}

impl<T: Real> RotationSum<T> {
    /// Adds the rotation ({P} to {B}) of a pose.
    #[inline(never)]
    pub fn add(&mut self, rotation: &Matrix3<T>) {
        accumulate(self.sum.as_mut_slice(), rotation.as_slice());
        self.poses += 1;
    }

    /// The sum itself.
    pub fn sum(&self) -> &Matrix3<T> {
        &self.sum
    }

    /// Poses added.
    pub fn poses(&self) -> T {
        T::of_integer(self.poses as i32)
    }

    /// The sway of the poses added. All zero, the axes as well, when there are none.
    pub fn sway(&self) -> Sway<T> {
        // The 1 in all that follows; 0 without poses, so that nothing sways then.
        let whole = T::of_integer(i32::from(self.poses > 0));
        // R̄ is never formed: of it only the products are wanted, which are those of the sum times this.
        let share = T::one() / (self.poses() * self.poses()).max(T::one());
        // 1 - R̄ᵀR̄ has the eigenvalues 1 - σ². Its adjugate has the same axes and the products of the two others: the
        // largest of them belongs to the axis looked for, though that one's own eigenvalue may be zero.
        let mut lacking = Symmetric::diagonal(whole);
        lacking.add_product(&self.sum, &self.sum, -share);
        let adjugate = lacking.adjugate();
        let (_, axis_in_platform) = adjugate.largest();
        let image = image(&self.sum, &axis_in_platform);
        let least = whole - dot(&image, &image) * share;
        // The two others by their sum and their product; the smaller of them.
        let sum = lacking.trace() - least;
        let others = adjugate.trace() - least * sum;
        let apart = root(sum * sum - others * T::of(4.0));
        let second = if sum > T::zero() { (others + others) / (sum + apart) } else { T::zero() };
        Sway { axis: unit(&image), axis_in_platform, least_rad: moved(least), second_rad: moved(second) }
    }
}

/// By how much an axis is moved, rad: 2 (1 - σ) is its square, `lacking` is 1 - σ².
#[inline(never)]
fn moved<T: Real>(lacking: T) -> T {
    let singular = root(T::one() - lacking);
    root((T::one() - singular) * T::of(2.0))
}
