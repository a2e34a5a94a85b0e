//! The error bar: from the covariance of the six unknowns to figures that a person can read.

use super::blocks::Blocks;
use super::normal_equations::{PACKED, UNKNOWNS};
use crate::calls::{difference, dot, image_transposed, root, unit};
use crate::kinematics::{Pivot, RigPoints};
use crate::rig::Parameters;
use crate::scalar::Real;
use crate::symmetric::Symmetric;
use nalgebra::Matrix3;

/// Rounds of the power iteration. A direction that stands out by a factor of two in variance is exact to 1e-4 then;
/// where none stands out, any of them is as weak as the other.
const POWER_ROUNDS: usize = 24;

/// Centre and radii of a pivot, and their covariance from that of O and C: dp_i = -(s_i - C)·dC / p_i.
///
/// `covariance` is that of x, y, z, p1, p2, p3, times `factor`: lower triangle, row by row.
#[inline(never)]
pub fn parameters_of<T: Real>(
    pivot: &Pivot<T>,
    of_pivot: &Blocks<T>,
    factor: T,
    points: &RigPoints<T>,
    parameters: &mut Parameters<T>,
    covariance: &mut [T; PACKED],
) {
    parameters.centre_mm = pivot.in_base_mm;
    let mut directions = Matrix3::zeros();
    let mut mixed = Matrix3::zeros();
    for i in 0..3 {
        let arm = difference(&pivot.in_platform_mm, &points.platform_mm[i]);
        parameters.radii_mm[i] = root(dot(&arm, &arm));
        let direction = unit(&arm);
        mixed.data.0[i] = image_transposed(&of_pivot.mixed, &direction).into();
        directions.data.0[i] = direction.into();
    }
    let mut of_radii = Symmetric::zero();
    let mut images = directions;
    of_pivot.second.apply_to(&mut images);
    of_radii.add_product(&directions, &images, T::one());
    let [pp, qp, qq, rp, rq, rr] = of_radii.0;
    let [xx, yx, yy, zx, zy, zz] = of_pivot.first.0;
    let [[px, py, pz], [qx, qy, qz], [rx, ry, rz]] = mixed.data.0;
    #[rustfmt::skip]
    let entries = [
        xx,
        yx, yy,
        zx, zy, zz,
        px, py, pz, pp,
        qx, qy, qz, qp, qq,
        rx, ry, rz, rp, rq, rr,
    ];
    *covariance = entries;
    covariance.iter_mut().for_each(|entry| *entry *= factor);
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
    worst_direction_of_point(&Symmetric([xx, yx, yy, zx, zy, zz]))
}

/// 1σ in the direction of largest variance of a point, and that direction.
pub fn worst_direction_of_point<T: Real>(covariance: &Symmetric<T>) -> (T, [T; 3]) {
    let (variance, direction) = covariance.largest();
    (root(variance), direction.into())
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
