//! Can these poses determine the centre at all? A question about their rotations alone.
//!
//! Every pose says δO = R δC (see [`pose_information`](super::pose_information)). The centre is free along `a` when
//! all poses agree on it: R_m a' = a for one a'. How well they agree is told by the mean rotation R̄ = Σ R_m / m: with
//! its singular values σ_i, the mean of |R_m a' - a|² over the poses is 2 (1 - σ_i) for the singular vectors a, a'.
//! So a largest singular value of one means a common axis, and its left singular vector is that axis in {B}.

use crate::scalar::Real;
use crate::vector::{difference, image_transposed, product, scaled, scaled_matrix, square, sum, sum_of_matrices};
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
        self.sum = sum_of_matrices(&self.sum, rotation);
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
        let (axes, squares) = eigen_of_symmetric(&product(&mean, &mean.transpose()));
        let axis = axes[0];
        let image = image_transposed(&mean, &axis);
        let norm = square(&image).root();
        let moved = |square: T| {
            let singular = square.max(T::zero()).root();
            ((T::one() - singular).max(T::zero()) * T::of(2.0)).root()
        };
        Sway {
            axis,
            axis_in_platform: if norm > T::zero() { scaled(&image, T::one() / norm) } else { image },
            least_rad: moved(squares[0]),
            second_rad: moved(squares[1]),
        }
    }
}

/// Eigenvectors and eigenvalues of a symmetric 3x3 matrix, largest first, by cyclic Jacobi rotations: no
/// trigonometric call, no failure, and accurate to the last digits that the sway hangs on.
#[inline(never)]
fn eigen_of_symmetric<T: Real>(matrix: &Matrix3<T>) -> ([Vector3<T>; 3], [T; 3]) {
    let mut values = [matrix.m11, matrix.m22, matrix.m33];
    // off[k] couples the two others.
    let mut off = [matrix.m32, matrix.m31, matrix.m21];
    let zero = T::zero();
    let one = T::one();
    let mut axes = [Vector3::new(one, zero, zero), Vector3::new(zero, one, zero), Vector3::new(zero, zero, one)];
    // Convergence is quadratic: four sweeps reach the last digit of a double.
    for _ in 0..5 {
        for _ in 0..3 {
            // Turns p and q until nothing couples them; then the next pair comes to the front.
            let ([p, q, r], [to_q, to_p, between]) = (values, off);
            let (tan, cos, sin) = if between == zero {
                (zero, one, zero)
            } else {
                let theta = (q - p) / (between + between);
                let size = theta.abs() + (theta * theta + one).root();
                let tan = if theta < zero { -one / size } else { one / size };
                let cos = one / (tan * tan + one).root();
                (tan, cos, tan * cos)
            };
            let [x, y, z] = &axes;
            let turned_x = difference(&scaled(x, cos), &scaled(y, sin));
            let turned_y = sum(&scaled(x, sin), &scaled(y, cos));
            axes = [turned_y, *z, turned_x];
            values = [q + tan * between, r, p - tan * between];
            off = [to_p * cos - to_q * sin, zero, to_q * cos + to_p * sin];
        }
    }
    // Sorted by three exchanges of neighbours.
    let ([p, q, r], [x, y, z]) = (values, axes);
    let (mut first, mut second, mut third) = ((p, x), (q, y), (r, z));
    let sort = |larger: &mut (T, Vector3<T>), smaller: &mut (T, Vector3<T>)| {
        if smaller.0 > larger.0 {
            core::mem::swap(larger, smaller);
        }
    };
    sort(&mut first, &mut second);
    sort(&mut second, &mut third);
    sort(&mut first, &mut second);
    ([first.1, second.1, third.1], [first.0, second.0, third.0])
}
