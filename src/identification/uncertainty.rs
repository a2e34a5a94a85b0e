//! From the covariance of O and C to that of the paper's six unknowns, and to standard deviations.

use crate::kinematics::{Geometry, JointCentre};
use crate::linear_algebra::{largest_eigenpair, non_negative_root, packed_index, unit};
use crate::rig::{POINTS, Parameters};
use crate::scalar::Real;
use nalgebra::{Matrix3, Matrix6, SMatrix, Vector3};

/// x, y, z, p1, p2, p3.
pub const RESULT_UNKNOWNS: usize = 6;
/// Entries of their packed covariance.
pub const RESULT_PACKED: usize = 21;

/// Centre and radii of a joint centre, mm, and their covariance from that of O and C: dp_i = -(s_i - C)·dC / p_i.
///
/// `covariance`: of O and C, mm². `of_shape`: what the platform's shape adds to that of centre and radii, mm² (see
/// [`ShapeShare`]). Returns the covariance of x, y, z, p1, p2, p3, mm², packed lower triangle.
pub fn parameters_of<T: Real>(
    centre: &JointCentre<T>,
    covariance: &Matrix6<T>,
    of_shape: &Matrix6<T>,
    geometry: &Geometry<T>,
) -> (Parameters<T>, [T; RESULT_PACKED]) {
    let mut jacobian = Matrix6::identity();
    let mut parameters = Parameters { centre_mm: centre.in_base_mm, radii_mm: [T::zero(); 3] };
    for (i, end_point) in geometry.end_points_mm().iter().enumerate() {
        let arm = centre.in_platform_mm - end_point;
        parameters.radii_mm[i] = arm.norm_squared().root();
        jacobian.fixed_view_mut::<1, 3>(3 + i, 3).copy_from(&unit(&arm).transpose());
    }
    (parameters, packed(&(jacobian * covariance * jacobian.transpose() + of_shape)))
}

/// What a platform of uncertain shape adds to the covariance of centre and radii, one parameter of the shape after the
/// other: the end-points s_i move with it, dp_i = u_i·(ds_i - dC) with u_i = (s_i - C) / p_i.
#[derive(Clone, Copy, Debug)]
pub struct ShapeShare<T> {
    /// The sum so far, mm².
    pub covariance_mm2: Matrix6<T>,
}

impl<T: Real> ShapeShare<T> {
    /// Of an exactly known platform.
    pub fn none() -> Self {
        Self { covariance_mm2: Matrix6::zeros() }
    }

    /// Adds a parameter of the shape.
    ///
    /// * `directions`: the unit vectors u_i.
    /// * `moved`: ds_i for the parameter, and `all_moved` for each parameter with its covariance with this one.
    /// * `with_centre`: covariance of the parameter with O and C.
    pub fn add(
        &mut self,
        directions: &[Vector3<T>; POINTS],
        moved: &[Vector3<T>; POINTS],
        all_moved: impl Iterator<Item = ([Vector3<T>; POINTS], T)>,
        with_centre: &[Vector3<T>; 2],
    ) {
        let radii = |motions: &[Vector3<T>; POINTS]| {
            let [a, b, c] = directions;
            let [p, q, r] = motions;
            Vector3::new(a.dot(p), b.dot(q), c.dot(r))
        };
        let grows = radii(moved);
        let [with_base, with_platform] = with_centre;
        let by_centre = radii(&[*with_platform; POINTS]);
        let by_shape =
            all_moved.fold(Vector3::zeros(), |sum, (motions, covariance)| sum + radii(&motions) * covariance);
        let mixed = with_base * grows.transpose();
        let of_radii = (by_shape - by_centre) * grows.transpose() - grows * by_centre.transpose();
        for i in 0..3 {
            for j in 0..3 {
                self.covariance_mm2[(i, 3 + j)] += mixed[(i, j)];
                self.covariance_mm2[(3 + j, i)] += mixed[(i, j)];
                self.covariance_mm2[(3 + i, 3 + j)] += of_radii[(i, j)];
            }
        }
    }
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
