//! Can these poses determine the centre at all? A question about their rotations alone.
//!
//! Every pose says δO = R δC (see [`pose_information`](super::pose_information)). The centre is free along `a` when
//! all poses agree on it: R_m a' = a for one a'. How well they agree is told by the mean rotation R̄ = Σ R_m / m: with
//! its singular values σ_i, the mean of |R_m a' - a|² over the poses is 2 (1 - σ_i) for the singular vectors a, a'.
//! So a largest singular value of one means a common axis, and its left singular vector is that axis in {B}.

use crate::scalar::Real;
use crate::vector::scaled_matrix;
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
    pub fn add(&mut self, rotation: &Matrix3<T>) {
        for (sum, entry) in self.sum.iter_mut().zip(rotation.iter()) {
            *sum += *entry;
        }
        self.poses += 1;
    }

    /// R̄, and the share of one pose in it; `None` without poses.
    pub fn mean(&self) -> Option<(Matrix3<T>, T)> {
        let share = T::one() / T::of_integer(self.poses as i32);
        (self.poses > 0).then(|| (scaled_matrix(&self.sum, share), share))
    }

    /// The sway of the poses added. All zero when there are none.
    pub fn sway(&self) -> Sway<T> {
        let Some((mean, _)) = self.mean() else {
            let zero = T::zero();
            return Sway { axis: Vector3::z(), axis_in_platform: Vector3::z(), least_rad: zero, second_rad: zero };
        };
        let (axes, squares) = eigen_of_symmetric(&(mean * mean.transpose()));
        let axis = axes[0];
        let image = mean.transpose() * axis;
        let norm = image.norm_squared().root();
        let moved = |square: T| {
            let singular = square.max(T::zero()).root();
            ((T::one() - singular).max(T::zero()) * T::of(2.0)).root()
        };
        Sway {
            axis,
            axis_in_platform: if norm > T::zero() { image / norm } else { image },
            least_rad: moved(squares[0]),
            second_rad: moved(squares[1]),
        }
    }
}

/// Eigenvectors and eigenvalues of a symmetric 3x3 matrix, largest first, by cyclic Jacobi rotations: no
/// trigonometric call, no failure, and accurate to the last digits that the sway hangs on.
fn eigen_of_symmetric<T: Real>(matrix: &Matrix3<T>) -> ([Vector3<T>; 3], [T; 3]) {
    let mut a = *matrix;
    let mut axes = Matrix3::identity();
    // Convergence is quadratic: four sweeps reach the last digit of a double.
    for _ in 0..5 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let off = a[(p, q)];
            if off == T::zero() {
                continue;
            }
            let theta = (a[(q, q)] - a[(p, p)]) / (off + off);
            let size = theta.abs() + (theta * theta + T::one()).root();
            let tan = if theta < T::zero() { -T::one() / size } else { T::one() / size };
            let cos = T::one() / (tan * tan + T::one()).root();
            let sin = tan * cos;
            let mut turn = Matrix3::identity();
            turn[(p, p)] = cos;
            turn[(q, q)] = cos;
            turn[(p, q)] = sin;
            turn[(q, p)] = -sin;
            a = turn.transpose() * a * turn;
            axes *= turn;
        }
    }
    let mut order = [0, 1, 2];
    order.sort_unstable_by(|&i, &j| a[(j, j)].partial_cmp(&a[(i, i)]).unwrap_or(core::cmp::Ordering::Equal));
    (order.map(|i| axes.column(i).into_owned()), order.map(|i| a[(i, i)]))
}
