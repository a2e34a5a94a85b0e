//! The identification model of one pose: `Y = D X` (Eq. 13), as the Appendix writes it.

use super::tetrahedron::{apex, counter_clockwise};
use super::{Estimate, Failure, Lengths, Machine};
use nalgebra::{Matrix3, Matrix3x4, RealField, RowVector3, RowVector4, Vector3};

/// The model of one pose at one estimate.
#[derive(Clone, Copy, Debug)]
pub struct PoseModel<T: RealField + Copy> {
    /// `OP_1`, `OP_2`, `OP_3`, in mm, relative to O.
    pub end_points_mm: [Vector3<T>; 3],
    /// `p12`, `p23`, `p31` as computed from the estimate (Eq. 10-12), in mm.
    pub edges_mm: [T; 3],
    /// `Y`: the actual edges less the computed ones, in mm.
    pub y_mm: [T; 3],
    /// `D`: row `k` holds the derivatives of edge `k` by `x, y, z, p1, p2, p3`.
    pub d: [[T; 6]; 3],
}

/// Eq. 1-13 and A1-A13 for one pose.
///
/// # Errors
/// [`Failure::DoesNotClose`] and [`Failure::FlatTetrahedron`] with the first end-point they hold for; `pose` is the
/// number that goes into the failure.
pub fn pose_model<T: RealField + Copy>(
    machine: &Machine<T>,
    estimate: &Estimate<T>,
    lengths_mm: &Lengths<T>,
    pose: usize,
) -> Result<PoseModel<T>, Failure> {
    let side = counter_clockwise(&machine.base_mm);
    let mut end_points_mm = [Vector3::zeros(); 3];
    for (end_point, found) in end_points_mm.iter_mut().enumerate() {
        let base = base_points(machine, end_point).map(|point| point - estimate.centre_mm);
        let cables = [lengths_mm[2 * end_point], lengths_mm[2 * end_point + 1]];
        *found =
            apex(base, estimate.radii_mm[end_point], cables, side).ok_or(Failure::DoesNotClose { pose, end_point })?;
    }

    // δOP_i = A_i⁻¹ B_i (δx, δy, δz, δp_i)ᵀ, Eq. A4-A6.
    let mut moves = [Matrix3x4::zeros(); 3];
    for (end_point, found) in moves.iter_mut().enumerate() {
        let base = base_points(machine, end_point);
        let p = end_points_mm[end_point];
        let a = matrix_a(estimate.centre_mm, base, p);
        let inverse = invert_3x3(&a).ok_or(Failure::FlatTetrahedron { pose, end_point })?;
        *found = inverse * matrix_b(estimate.centre_mm, base, p, estimate.radii_mm[end_point]);
    }

    let mut edges_mm = [T::zero(); 3];
    let mut y_mm = [T::zero(); 3];
    let mut d = [[T::zero(); 6]; 3];
    for edge in 0..3 {
        let (from, to) = (edge, (edge + 1) % 3);
        let difference = end_points_mm[from] - end_points_mm[to];
        let computed = difference.norm(); // Eq. 10-12
        let c: RowVector3<T> = difference.transpose(); // the Matrix C_k of A7-A9
        let d_1: RowVector4<T> = c * moves[from] / computed; // D_11, D_21, D_31
        let d_2: RowVector4<T> = c * moves[to] / computed; // D_12, D_22, D_32

        edges_mm[edge] = computed;
        y_mm[edge] = machine.edges_mm[edge] - computed;
        for axis in 0..3 {
            d[edge][axis] = d_1[axis] - d_2[axis];
        }
        d[edge][3 + from] = d_1[3];
        d[edge][3 + to] = -d_2[3];
    }
    Ok(PoseModel { end_points_mm, edges_mm, y_mm, d })
}

/// `δE` (Eq. 17): the root mean square of all residues, in mm.
///
/// The formula is printed as `sqrt(1 / 3m) (YᵀY)`; its text, its unit and Fig. 5 say `sqrt(YᵀY / 3m)`.
pub fn root_mean_square<T: RealField + Copy>(y_mm: &[T]) -> T {
    let mut sum = T::zero();
    let mut count = T::zero();
    for &y in y_mm {
        sum += y * y;
        count += T::one();
    }
    (sum / count).sqrt()
}

/// The two base points of an end-point in {B}, in the order of its cables.
fn base_points<T: RealField + Copy>(machine: &Machine<T>, end_point: usize) -> [Vector3<T>; 2] {
    [machine.base_mm[end_point], machine.base_mm[(end_point + 1) % 3]]
}

/// `A_i` of A4: the left-hand sides of the differentials of the two cables and of `p_i`.
#[rustfmt::skip] // the rows of the matrices
fn matrix_a<T: RealField + Copy>(o: Vector3<T>, [b_a, b_b]: [Vector3<T>; 2], p: Vector3<T>) -> Matrix3<T> {
    Matrix3::new(
        o.x - b_a.x + p.x, o.y - b_a.y + p.y, o.z - b_a.z + p.z,
        o.x - b_b.x + p.x, o.y - b_b.y + p.y, o.z - b_b.z + p.z,
        p.x,               p.y,               p.z,
    )
}

/// `B_i` of A4: the right-hand sides. Its third row is `0 0 0 p_i`.
#[rustfmt::skip] // the rows of the matrices
fn matrix_b<T: RealField + Copy>(
    o: Vector3<T>,
    [b_a, b_b]: [Vector3<T>; 2],
    p: Vector3<T>,
    radius: T,
) -> Matrix3x4<T> {
    let zero = T::zero();
    Matrix3x4::new(
        b_a.x - o.x - p.x, b_a.y - o.y - p.y, b_a.z - o.z - p.z, zero,
        b_b.x - o.x - p.x, b_b.y - o.y - p.y, b_b.z - o.z - p.z, zero,
        zero,              zero,              zero,              radius,
    )
}

/// The inverse of a 3x3 matrix by its adjugate; `None` when the determinant is zero or not finite.
#[rustfmt::skip] // the rows of the matrices
fn invert_3x3<T: RealField + Copy>(m: &Matrix3<T>) -> Option<Matrix3<T>> {
    let c00 = m.m22 * m.m33 - m.m23 * m.m32;
    let c01 = m.m23 * m.m31 - m.m21 * m.m33;
    let c02 = m.m21 * m.m32 - m.m22 * m.m31;
    let determinant = m.m11 * c00 + m.m12 * c01 + m.m13 * c02;
    if determinant == T::zero() || !determinant.is_finite() {
        return None;
    }
    let adjugate = Matrix3::new(
        c00, m.m13 * m.m32 - m.m12 * m.m33, m.m12 * m.m23 - m.m13 * m.m22,
        c01, m.m11 * m.m33 - m.m13 * m.m31, m.m13 * m.m21 - m.m11 * m.m23,
        c02, m.m12 * m.m31 - m.m11 * m.m32, m.m11 * m.m22 - m.m12 * m.m21,
    );
    Some(adjugate / determinant)
}
