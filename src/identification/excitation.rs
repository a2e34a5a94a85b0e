//! Rotational excitation: can these poses determine the centre at all? A question about their rotations alone
//! (observability about the most common axis).
//!
//! Every pose says δO = R δC (see [`marginal_information`](super::marginal_information)). The centre is free along `a`
//! when all poses agree on it: R_m a' = a for one a'. How well they agree shows in the mean rotation R̄ = Σ R_m / m:
//! with its singular values σ_i, the mean of |R_m a' - a|² over the poses is 2 (1 - σ_i) for the singular vectors a,
//! a'. So a largest singular value of one means a common axis, and its left singular vector is that axis in {B}.

use crate::linear_algebra::{column, non_negative_root, symmetric_eigen, unit};
use crate::scalar::Real;
use nalgebra::{Matrix3, Vector3};

/// Sum of the rotations of a set of poses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeanRotation<T> {
    sum: Matrix3<T>,
    poses: usize,
}

/// How far a set of poses is from turning about one common axis: the two singular values of R̄ nearest to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Excitation<T> {
    /// The axis in {B} that the poses move least, a unit vector.
    pub axis: Vector3<T>,
    /// The same axis in {P}.
    pub axis_in_platform: Vector3<T>,
    /// Root-mean-square length by which the poses move that axis (a unit vector), 0 to 2; for small angles, the angle
    /// in rad. 0: all turn about it.
    pub least_rad: T,
    /// The same for the axis that they move second least. 0: the poses are all alike.
    pub second_rad: T,
}

impl<T: Real> Default for MeanRotation<T> {
    fn default() -> Self {
        Self { sum: Matrix3::zeros(), poses: 0 }
    }
}

impl<T: Real> MeanRotation<T> {
    /// Adds the rotation ({P} to {B}) of a pose.
    pub fn add(&mut self, rotation: &Matrix3<T>) {
        self.sum += rotation;
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

    /// The excitation of the poses added. All zero, the axes as well, when there are none.
    pub fn excitation(&self) -> Excitation<T> {
        if self.poses == 0 {
            let (none, zero) = (Vector3::zeros(), T::zero());
            return Excitation { axis: none, axis_in_platform: none, least_rad: zero, second_rad: zero };
        }
        let mean = self.sum * (T::one() / self.poses());
        // Its eigenvalues are 1 - s², s the singular values of R̄.
        let eigen = symmetric_eigen(&(Matrix3::identity() - mean.tr_mul(&mean)));
        let [x, y, z] = eigen.values.into();
        let [of_x, of_y, of_z] = [0, 1, 2].map(|i| column(&eigen.vectors, i));
        let mut axes = [(x, of_x), (y, of_y), (z, of_z)];
        // The axis that moved least comes first; NaN stays where it is.
        axes.sort_unstable_by(|(a, _), (b, _)| a.partial_cmp(b).unwrap_or(core::cmp::Ordering::Equal));
        let [(least, axis_in_platform), (second, _), _] = axes;
        Excitation {
            axis: unit(&(mean * axis_in_platform)),
            axis_in_platform,
            least_rad: moved(least),
            second_rad: moved(second),
        }
    }
}

/// By how much an axis is moved, rad: √(2 (1 - s)) from the eigenvalue 1 - s².
fn moved<T: Real>(eigenvalue: T) -> T {
    let singular = non_negative_root(T::one() - eigenvalue);
    non_negative_root((T::one() - singular) * T::of(2.0))
}
