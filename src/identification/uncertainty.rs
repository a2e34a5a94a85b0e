//! From the covariance of O and C to that of the paper's six unknowns, and to standard deviations.

use crate::kinematics::{Geometry, JointCentre};
use crate::linear_algebra::{largest_eigenpair, non_negative_root, packed_index, unit};
use crate::rig::Parameters;
use crate::scalar::Real;
use nalgebra::{Matrix3, Matrix6, SMatrix, Vector3};

/// x, y, z, p1, p2, p3.
pub const RESULT_UNKNOWNS: usize = 6;
/// Entries of their packed covariance.
pub const RESULT_PACKED: usize = 21;

/// Centre and radii of a joint centre, mm, and their covariance from that of O and C: dp_i = -(s_i - C)·dC / p_i, with
/// the end-points s_i taken as exact.
///
/// `covariance`: of O and C, mm². Returns that of x, y, z, p1, p2, p3, mm², packed lower triangle.
pub fn parameters_of<T: Real>(
    centre: &JointCentre<T>,
    covariance: &Matrix6<T>,
    geometry: &Geometry<T>,
) -> (Parameters<T>, [T; RESULT_PACKED]) {
    let mut jacobian = Matrix6::identity();
    let mut parameters = Parameters { centre_mm: centre.in_base_mm, radii_mm: [T::zero(); 3] };
    for (i, end_point) in geometry.end_points_mm().iter().enumerate() {
        let arm = centre.in_platform_mm - end_point;
        parameters.radii_mm[i] = arm.norm_squared().root();
        jacobian.fixed_view_mut::<1, 3>(3 + i, 3).copy_from(&unit(&arm).transpose());
    }
    (parameters, packed(&(jacobian * covariance * jacobian.transpose())))
}

/// The lower triangle, row by row.
pub fn packed<T: Real>(matrix: &Matrix6<T>) -> [T; RESULT_PACKED] {
    let mut packed = [T::zero(); RESULT_PACKED];
    for i in 0..RESULT_UNKNOWNS {
        for j in 0..=i {
            packed[packed_index(i, j)] = matrix[(i, j)];
        }
    }
    packed
}

/// The matrix of which `packed` is the lower triangle.
pub fn unpacked<T: Real, const N: usize>(packed: &[T]) -> SMatrix<T, N, N> {
    let entry = |i: usize, j: usize| packed.get(packed_index(i.max(j), i.min(j))).copied();
    SMatrix::from_fn(|i, j| entry(i, j).unwrap_or_else(T::zero))
}

/// 1σ of each unknown from a packed covariance.
pub fn sigmas<T: Real>(covariance: &[T; RESULT_PACKED]) -> [T; RESULT_UNKNOWNS] {
    core::array::from_fn(|k| non_negative_root(covariance[packed_index(k, k)]))
}

/// The direction of largest variance among all six unknowns, a unit vector, and its 1σ.
pub fn worst_direction<T: Real>(covariance: &[T; RESULT_PACKED]) -> ([T; RESULT_UNKNOWNS], T) {
    let (variance, direction) = largest_eigenpair(&unpacked::<T, RESULT_UNKNOWNS>(covariance));
    (direction.into(), non_negative_root(variance))
}

/// 1σ of the centre (first three unknowns) in its worst direction, and that direction as a unit vector in {B}.
pub fn worst_centre_direction<T: Real>(covariance: &[T; RESULT_PACKED]) -> (T, [T; 3]) {
    worst_direction_of_point(&unpacked::<T, 3>(covariance))
}

/// 1σ in the direction of largest variance of a point, and that direction.
pub fn worst_direction_of_point<T: Real>(covariance: &Matrix3<T>) -> (T, [T; 3]) {
    let (variance, direction): (T, Vector3<T>) = largest_eigenpair(covariance);
    (non_negative_root(variance), direction.into())
}
