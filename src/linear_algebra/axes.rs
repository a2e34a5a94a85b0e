//! Orthonormal axes from vectors.

use crate::scalar::Real;
use nalgebra::{Matrix3, Vector3};

/// Orthonormal axes from two vectors as columns: x along the first, z along their cross product. Not finite when the
/// vectors are parallel.
pub fn triad<T: Real>(first: &Vector3<T>, second: &Vector3<T>) -> Matrix3<T> {
    let x = unit(first);
    let z = unit(&first.cross(second));
    Matrix3::from_columns(&[x, z.cross(&x), z])
}

/// a / |a|; not finite where a has no length.
pub fn unit<T: Real>(a: &Vector3<T>) -> Vector3<T> {
    a * (T::one() / a.norm_squared().root())
}
