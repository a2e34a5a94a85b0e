//! The inverse of a symmetric positive definite 3x3 matrix, and the solution with one: refused when a pivot vanishes.

use crate::scalar::Real;
use nalgebra::{Matrix3, Vector3};

/// The inverse, by the adjugate. `smallest`: the smallest pivot that counts as regular, as a share of the diagonal
/// entry that it came from; `None` below it and for NaN.
pub fn inverse_of_positive_definite<T: Real>(matrix: &Matrix3<T>, smallest: T) -> Option<Matrix3<T>> {
    inverse_of_eliminated(matrix, matrix, smallest)
}

/// The solution x of `matrix` x = `right`, refused as the inverse is.
#[cfg_attr(feature = "ccm", unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
pub fn solve_positive_definite<T: Real>(matrix: &Matrix3<T>, right: &Vector3<T>, smallest: T) -> Option<Vector3<T>> {
    let (adjugate, determinant) = regular_adjugate(matrix, matrix, smallest)?;
    Some(adjugate * right * (T::one() / determinant))
}

/// The same for a Schur complement: its pivots are compared with the diagonal of `original`, the matrix before the
/// elimination.
#[cfg_attr(feature = "ccm", unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
pub fn inverse_of_eliminated<T: Real>(matrix: &Matrix3<T>, original: &Matrix3<T>, smallest: T) -> Option<Matrix3<T>> {
    let (adjugate, determinant) = regular_adjugate(matrix, original, smallest)?;
    Some(adjugate * (T::one() / determinant))
}

/// The adjugate and the determinant of a matrix whose pivots are large enough.
// Inlined: its callers keep it in registers, 1 894 estimated cycles a followed sample otherwise, 1 752 with it (`cargo cycles`).
#[inline(always)]
fn regular_adjugate<T: Real>(matrix: &Matrix3<T>, original: &Matrix3<T>, smallest: T) -> Option<(Matrix3<T>, T)> {
    let m = matrix;
    let c11 = m.m22 * m.m33 - m.m32 * m.m32;
    let c21 = m.m31 * m.m32 - m.m21 * m.m33;
    let c31 = m.m21 * m.m32 - m.m31 * m.m22;
    let c22 = m.m11 * m.m33 - m.m31 * m.m31;
    let c32 = m.m21 * m.m31 - m.m11 * m.m32;
    let c33 = m.m11 * m.m22 - m.m21 * m.m21;
    let determinant = m.m11 * c11 + m.m21 * c21 + m.m31 * c31;
    // The pivots are quotients of the leading minors. Written as products, and so that NaN is refused.
    let regular = m.m11 > original.m11 * smallest
        && c33 > original.m22 * smallest * m.m11
        && determinant > original.m33 * smallest * c33;
    regular.then(|| (Matrix3::new(c11, c21, c31, c21, c22, c32, c31, c32, c33), determinant))
}
