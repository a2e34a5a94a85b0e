//! Operations on vectors as calls, for what runs a few times a run.
//!
//! Written out, the image of a vector takes 90 bytes of code wherever it stands; a call takes 16. The work on each pose
//! has its own, always inlined (see [`vector`]).

use crate::scalar::Real;
use crate::vector;
use nalgebra::{Matrix3, Vector3};

/// a · b.
#[inline(never)]
pub fn dot<T: Real>(a: &Vector3<T>, b: &Vector3<T>) -> T {
    vector::dot(a, b)
}

/// a / |a|, or a itself where it has no length.
#[inline(never)]
pub fn unit<T: Real>(a: &Vector3<T>) -> Vector3<T> {
    let norm = vector::square(a).root();
    if norm > T::zero() { vector::scaled(a, T::one() / norm) } else { *a }
}

/// a × b.
#[inline(never)]
fn cross<T: Real>(a: &Vector3<T>, b: &Vector3<T>) -> Vector3<T> {
    vector::cross(a, b)
}

/// a - b.
#[inline(never)]
pub fn difference<T: Real>(a: &Vector3<T>, b: &Vector3<T>) -> Vector3<T> {
    vector::difference(a, b)
}

/// a s.
#[inline(never)]
pub fn scaled<T: Real>(a: &Vector3<T>, s: T) -> Vector3<T> {
    vector::scaled(a, s)
}

/// M a.
#[inline(never)]
pub fn image<T: Real>(m: &Matrix3<T>, a: &Vector3<T>) -> Vector3<T> {
    core::array::from_fn(|k| m.data.0[0][k] * a.x + m.data.0[1][k] * a.y + m.data.0[2][k] * a.z).into()
}

/// Mᵀ a.
#[inline(never)]
pub fn image_transposed<T: Real>(m: &Matrix3<T>, a: &Vector3<T>) -> Vector3<T> {
    core::array::from_fn(|k| vector::dot(&Vector3::from(m.data.0[k]), a)).into()
}

/// Mᵀ.
#[inline(never)]
pub fn transposed<T: Real>(m: &Matrix3<T>) -> Matrix3<T> {
    m.transpose()
}

/// Adds a part to a sum, number by number: of vectors and matrices alike.
#[inline(never)]
pub fn accumulate<T: Real>(sum: &mut [T], part: &[T]) {
    sum.iter_mut().zip(part).for_each(|(sum, part)| *sum += *part);
}

/// Square root; zero of what rounding has made negative. NaN stays.
#[inline(never)]
pub fn root<T: Real>(x: T) -> T {
    if x < T::zero() { T::zero() } else { x.root() }
}

/// A B, column by column.
#[inline(always)]
pub fn product<T: Real>(a: &Matrix3<T>, b: &Matrix3<T>) -> Matrix3<T> {
    let mut product = *b;
    for column in &mut product.data.0 {
        *column = image(a, &Vector3::from(*column)).into();
    }
    product
}

/// Orthonormal axes from two vectors as columns: x along the first, z along their cross product. Two of them are zero
/// when the vectors are parallel, and none is finite when those are not.
#[inline(never)]
pub fn triad<T: Real>(first: &Vector3<T>, second: &Vector3<T>) -> Matrix3<T> {
    let x = unit(first);
    let z = unit(&cross(first, second));
    let y = cross(&z, &x);
    Matrix3::new(x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z)
}
