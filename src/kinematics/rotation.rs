//! Small rotations of a unit quaternion, and quaternions of matrices, without the panics and calls of the general ones.

use crate::scalar::Real;
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

/// `attitude` turned by the small rotation vector `turn` (rad, axes of {B}), to second order and normalised.
#[cfg_attr(feature = "ccm", unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
pub fn turned<T: Real>(attitude: &UnitQuaternion<T>, turn: &Vector3<T>) -> UnitQuaternion<T> {
    let half = turn * T::of(0.5);
    let (w, v) = (attitude.w, attitude.imag());
    normalised(Quaternion::from_parts(w - half.dot(&v), v + half * w + half.cross(&v)))
}

/// The rotation matrix of an attitude.
// Not inlined: 22 copies are 3 KB of flash (`cargo footprint --sections`).
#[inline(never)]
#[cfg_attr(feature = "ccm", unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
pub fn rotation_of<T: Real>(attitude: &UnitQuaternion<T>) -> Matrix3<T> {
    attitude.to_rotation_matrix().into_inner()
}

/// The attitude of a rotation matrix whose columns are orthonormal up to rounding: by one of the four components that
/// is not small (Shepperd 1978), so that nothing is divided by a small number.
pub fn nearest_attitude<T: Real>(m: &Matrix3<T>) -> UnitQuaternion<T> {
    let one = T::one();
    let (w, x) = (one + m.m11 + m.m22 + m.m33, one + m.m11 - m.m22 - m.m33);
    let (y, z) = (one - m.m11 + m.m22 - m.m33, one - m.m11 - m.m22 + m.m33);
    let (a, b, c) = (m.m32 - m.m23, m.m13 - m.m31, m.m21 - m.m12);
    let (d, e, f) = (m.m32 + m.m23, m.m13 + m.m31, m.m21 + m.m12);
    // A quarter of their sum, 4, is large enough.
    normalised(if w >= one {
        Quaternion::new(w, a, b, c)
    } else if x >= one {
        Quaternion::new(a, x, f, e)
    } else if y >= one {
        Quaternion::new(b, f, y, d)
    } else {
        Quaternion::new(c, e, d, z)
    })
}

/// The rotation vector from `from` to `to`, in {B}; see [`rotation_vector_of`].
pub fn rotation_vector<T: Real>(from: &Matrix3<T>, to: &Matrix3<T>) -> Vector3<T> {
    rotation_vector_of(&(to * from.transpose()))
}

/// The rotation vector of a rotation: axis times angle, rad, the angle between 0 and π.
pub fn rotation_vector_of<T: Real>(m: &Matrix3<T>) -> Vector3<T> {
    let twice_sine_axis = Vector3::new(m.m32 - m.m23, m.m13 - m.m31, m.m21 - m.m12);
    let sine = twice_sine_axis.norm_squared().root() * T::of(0.5);
    let cosine = (m.trace() - T::one()) * T::of(0.5);
    // Near 180 degrees the axis is lost in the antisymmetric part. No arm gets there; the vector is short then.
    let scale = if sine < T::of(1e-6) { T::of(0.5) } else { sine.atan2(cosine) / (sine + sine) };
    twice_sine_axis * scale
}

/// The rotation vector of an attitude: axis times angle, rad, the angle between 0 and π. nalgebra's own takes its roots in
/// software.
pub fn scaled_axis<T: Real>(attitude: &UnitQuaternion<T>) -> Vector3<T> {
    let (scalar, vector) = (attitude.scalar(), attitude.vector());
    let length = vector.norm_squared().root();
    // Also false for NaN.
    if !(length > T::zero()) {
        return Vector3::zeros();
    }
    let axis = if scalar < T::zero() { -vector } else { vector.into_owned() } / length;
    axis * (length.atan2(scalar.abs()) * T::of(2.0))
}

// A third of the calls of a rotation that is followed: 60 of its 1 900 cycles.
#[inline]
fn normalised<T: Real>(q: Quaternion<T>) -> UnitQuaternion<T> {
    let scale = T::one() / q.norm_squared().root();
    UnitQuaternion::new_unchecked(q * scale)
}
