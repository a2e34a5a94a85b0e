//! The error bar: from the covariance of the six unknowns to figures that a person can read.

use super::normal_equations::{PACKED, UNKNOWNS};
use crate::kinematics::{Pivot, RigPoints};
use crate::scalar::Real;
use crate::vector::{difference, dot, image, image_transposed, scaled, square};
use nalgebra::{Matrix3, Vector3};

/// Rounds of the power iteration. A direction that stands out by a factor of two in variance is exact to 1e-4 then;
/// where none stands out, any of them is as weak as the other.
const POWER_ROUNDS: usize = 24;

/// The same by squaring.
const SQUARINGS: usize = 5;

/// Covariance of x, y, z, p1, p2, p3 from that of O and C: dp_i = -(s_i - C)·dC / p_i.
pub fn covariance_of_parameters<T: Real>(
    of_pivot: &[T; PACKED],
    pivot: &Pivot<T>,
    points: &RigPoints<T>,
) -> [T; PACKED] {
    #[rustfmt::skip]
    let [
        o11,
        o21, o22,
        o31, o32, o33,
        m11, m12, m13, c11,
        m21, m22, m23, c21, c22,
        m31, m32, m33, c31, c32, c33,
    ] = *of_pivot;
    let mixed = Matrix3::new(m11, m12, m13, m21, m22, m23, m31, m32, m33);
    let inner = Matrix3::new(c11, c21, c31, c21, c22, c32, c31, c32, c33);
    let mut packed = [T::zero(); PACKED];
    let [p11, p21, p22, p31, p32, p33, rest @ ..] = &mut packed;
    [*p11, *p21, *p22, *p31, *p32, *p33] = [o11, o21, o22, o31, o32, o33];
    let mut rest = rest.iter_mut();
    let mut rows = [Vector3::zeros(); 3];
    for i in 0..3 {
        let arm = difference(&pivot.in_platform_mm, &points.platform_mm[i]);
        rows[i] = scaled(&arm, T::one() / square(&arm).root());
        let (with_centre, with_pivot) = (image_transposed(&mixed, &rows[i]), image(&inner, &rows[i]));
        // entry after entry, as they are packed
        let with_radii = rows.iter().take(i + 1).map(|row| dot(&with_pivot, row));
        let entries = with_centre.iter().copied().chain(with_radii);
        entries.zip(rest.by_ref()).for_each(|(entry, place)| *place = entry);
    }
    packed
}

/// 1σ of each unknown from a packed covariance.
pub fn sigmas<T: Real>(covariance: &[T; PACKED]) -> [T; UNKNOWNS] {
    let [xx, _, yy, _, _, zz, _, _, _, p1, _, _, _, _, p2, _, _, _, _, _, p3] = *covariance;
    [xx, yy, zz, p1, p2, p3].map(|variance| variance.max(T::zero()).root())
}

/// The direction of largest variance among all six unknowns, a unit vector, and its 1σ.
pub fn worst_direction<T: Real>(covariance: &[T; PACKED]) -> ([T; UNKNOWNS], T) {
    worst(covariance)
}

/// 1σ of the centre (first three unknowns) in its worst direction, and that direction as a unit vector in {B}.
pub fn worst_centre_direction<T: Real>(covariance: &[T; PACKED]) -> (T, [T; 3]) {
    let [xx, yx, yy, zx, zy, zz, ..] = *covariance;
    worst_of_three(&[xx, yx, yy, zx, zy, zz])
}

/// 1σ in the direction of largest variance of a packed 3x3 covariance, and that direction.
///
/// The matrix is squared five times: 32 rounds of a power iteration in the time of six.
#[inline(never)]
pub fn worst_of_three<T: Real>(covariance: &[T; 6]) -> (T, [T; 3]) {
    let zero = T::zero();
    let mut power = *covariance;
    for _ in 0..SQUARINGS {
        let [xx, _, yy, _, _, zz] = power;
        let scale = T::one() / (xx + yy + zz);
        // A zero, an infinity or a NaN: there is no direction.
        if !(scale > zero && scale.is_a_number()) {
            break;
        }
        let [xx, yx, yy, zx, zy, zz] = power;
        let (xx, yx, yy) = (xx * scale, yx * scale, yy * scale);
        let (zx, zy, zz) = (zx * scale, zy * scale, zz * scale);
        power = [
            xx * xx + yx * yx + zx * zx,
            yx * (xx + yy) + zy * zx,
            yx * yx + yy * yy + zy * zy,
            zx * (xx + zz) + zy * yx,
            zy * (yy + zz) + zx * yx,
            zx * zx + zy * zy + zz * zz,
        ];
    }
    // Every column is along that direction; the longest holds the most digits.
    let [xx, yx, yy, zx, zy, zz] = power;
    let column = if xx >= yy && xx >= zz {
        Vector3::new(xx, yx, zx)
    } else if yy >= zz {
        Vector3::new(yx, yy, zy)
    } else {
        Vector3::new(zx, zy, zz)
    };
    let norm = square(&column).root();
    let direction = if norm > zero { scaled(&column, T::one() / norm) } else { column };
    let [xx, yx, yy, zx, zy, zz] = *covariance;
    let image = image(&Matrix3::new(xx, yx, zx, yx, yy, zy, zx, zy, zz), &direction);
    (dot(&image, &direction).max(zero).root(), direction.into())
}

/// Power iteration.
fn worst<T: Real>(covariance: &[T; PACKED]) -> ([T; UNKNOWNS], T) {
    #[rustfmt::skip]
    let [
        xx,
        yx, yy,
        zx, zy, zz,
        px, py, pz, pp,
        qx, qy, qz, qp, qq,
        rx, ry, rz, rp, rq, rr,
    ] = *covariance;
    let columns = [
        [xx, yx, zx, px, qx, rx],
        [yx, yy, zy, py, qy, ry],
        [zx, zy, zz, pz, qz, rz],
        [px, py, pz, pp, qp, rp],
        [qx, qy, qz, qp, qq, rq],
        [rx, ry, rz, rp, rq, rr],
    ];
    let product = |a: &[T; UNKNOWNS], b: &[T; UNKNOWNS]| a.iter().zip(b).fold(T::zero(), |sum, (a, b)| sum + *a * *b);
    // Begins with the column of the largest variance: never orthogonal to the direction that is looked for.
    let variances = [yy, zz, pp, qq, rr].into_iter().zip(columns.into_iter().skip(1));
    let larger = |best: (T, _), next: (T, _)| if next.0 > best.0 { next } else { best };
    let [first, ..] = columns;
    let (mut variance, mut direction) = variances.fold((xx, first), larger);
    for _ in 0..POWER_ROUNDS {
        let norm = product(&direction, &direction).root();
        // A zero or a NaN: there is no direction.
        if !(norm > T::zero()) {
            break;
        }
        direction = direction.map(|x| x / norm);
        let image = columns.map(|column| product(&column, &direction));
        variance = product(&image, &direction);
        direction = image;
    }
    let norm = product(&direction, &direction).root();
    if norm > T::zero() {
        direction = direction.map(|x| x / norm);
    }
    (direction, variance.max(T::zero()).root())
}
