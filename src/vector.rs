//! The few operations on 3-vectors and 3x3 matrices that the work on each pose consists of, always inlined.
//!
//! The firmware is compiled for size, and there nalgebra's operators become calls: of a product of two numbers most
//! would be moving them about (the paper's iteration takes three times as long). Written out here they keep their
//! numbers in the FPU's registers, and everything that runs once a pass or once a run stays small.

use crate::scalar::Real;
use nalgebra::{Matrix3, Vector3};

/// a · b.
#[inline(always)]
pub fn dot<T: Real>(a: &Vector3<T>, b: &Vector3<T>) -> T {
    a.x * b.x + a.y * b.y + a.z * b.z
}

/// |a|².
#[inline(always)]
pub fn square<T: Real>(a: &Vector3<T>) -> T {
    dot(a, a)
}

/// a × b.
#[inline(always)]
pub fn cross<T: Real>(a: &Vector3<T>, b: &Vector3<T>) -> Vector3<T> {
    Vector3::new(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)
}

/// a + b.
#[inline(always)]
pub fn sum<T: Real>(a: &Vector3<T>, b: &Vector3<T>) -> Vector3<T> {
    Vector3::new(a.x + b.x, a.y + b.y, a.z + b.z)
}

/// a - b.
#[inline(always)]
pub fn difference<T: Real>(a: &Vector3<T>, b: &Vector3<T>) -> Vector3<T> {
    Vector3::new(a.x - b.x, a.y - b.y, a.z - b.z)
}

/// a s.
#[inline(always)]
pub fn scaled<T: Real>(a: &Vector3<T>, s: T) -> Vector3<T> {
    Vector3::new(a.x * s, a.y * s, a.z * s)
}

/// a1 s1 + a2 s2 + a3 s3.
#[inline(always)]
pub fn combination<T: Real>([a1, a2, a3]: &[Vector3<T>; 3], [s1, s2, s3]: [T; 3]) -> Vector3<T> {
    Vector3::new(
        a1.x * s1 + a2.x * s2 + a3.x * s3,
        a1.y * s1 + a2.y * s2 + a3.y * s3,
        a1.z * s1 + a2.z * s2 + a3.z * s3,
    )
}

/// a += b.
#[inline(always)]
pub fn add_to<T: Real>(a: &mut Vector3<T>, b: &Vector3<T>) {
    a.x += b.x;
    a.y += b.y;
    a.z += b.z;
}

/// M a.
#[inline(always)]
pub fn image<T: Real>(m: &Matrix3<T>, a: &Vector3<T>) -> Vector3<T> {
    Vector3::new(
        m.m11 * a.x + m.m12 * a.y + m.m13 * a.z,
        m.m21 * a.x + m.m22 * a.y + m.m23 * a.z,
        m.m31 * a.x + m.m32 * a.y + m.m33 * a.z,
    )
}

/// Mᵀ a.
#[inline(always)]
pub fn image_transposed<T: Real>(m: &Matrix3<T>, a: &Vector3<T>) -> Vector3<T> {
    Vector3::new(
        m.m11 * a.x + m.m21 * a.y + m.m31 * a.z,
        m.m12 * a.x + m.m22 * a.y + m.m32 * a.z,
        m.m13 * a.x + m.m23 * a.y + m.m33 * a.z,
    )
}
