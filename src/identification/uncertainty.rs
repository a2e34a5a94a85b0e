//! The error bar: from the covariance of the six unknowns to figures that a person can read.

use super::normal_equations::{PACKED, UNKNOWNS, at};
use crate::kinematics::{Pivot, RigPoints};
use crate::scalar::Real;
use nalgebra::Matrix3;

/// Rounds of the power iteration. A direction that stands out by a factor of two in variance is exact to 1e-4 then;
/// where none stands out, any of them is as weak as the other.
const POWER_ROUNDS: usize = 24;

/// Covariance of x, y, z, p1, p2, p3 from that of O and C: dp_i = -(s_i - C)·dC / p_i.
pub fn covariance_of_parameters<T: Real>(
    of_pivot: &[T; PACKED],
    pivot: &Pivot<T>,
    points: &RigPoints<T>,
) -> [T; PACKED] {
    let block = |row: usize, column: usize| {
        Matrix3::from_fn(|i, j| {
            let (i, j) = (3 * row + i, 3 * column + j);
            of_pivot[if i >= j { at(i, j) } else { at(j, i) }]
        })
    };
    let rows = points.platform_mm.map(|s| {
        let arm = pivot.in_platform_mm - s;
        (arm / arm.norm_squared().root()).transpose()
    });
    let jacobian = Matrix3::from_rows(&rows);
    let centre = block(0, 0);
    let mixed = jacobian * block(1, 0);
    let radii = jacobian * block(1, 1) * jacobian.transpose();
    let mut packed = [T::zero(); PACKED];
    for i in 0..3 {
        for j in 0..=i {
            packed[at(i, j)] = centre[(i, j)];
            packed[at(3 + i, 3 + j)] = radii[(i, j)];
        }
        for j in 0..3 {
            packed[at(3 + i, j)] = mixed[(i, j)];
        }
    }
    packed
}

/// 1σ of each unknown from a packed covariance.
pub fn sigmas<T: Real>(covariance: &[T; PACKED]) -> [T; UNKNOWNS] {
    core::array::from_fn(|i| covariance[at(i, i)].max(T::zero()).root())
}

/// The direction of largest variance among all six unknowns, a unit vector, and its 1σ.
pub fn worst_direction<T: Real>(covariance: &[T; PACKED]) -> ([T; UNKNOWNS], T) {
    worst(covariance)
}

/// 1σ of the centre (first three unknowns) in its worst direction, and that direction as a unit vector in {B}.
pub fn worst_centre_direction<T: Real>(covariance: &[T; PACKED]) -> (T, [T; 3]) {
    let (direction, sigma) = worst::<T, 3>(covariance);
    (sigma, direction)
}

/// Power iteration on the leading `K` x `K` block.
fn worst<T: Real, const K: usize>(covariance: &[T; PACKED]) -> ([T; K], T) {
    let entry = |i: usize, j: usize| covariance[if i >= j { at(i, j) } else { at(j, i) }];
    // Begins with the column of the largest variance: never orthogonal to the direction that is looked for.
    let start = (0..K).fold(0, |best, i| if entry(i, i) > entry(best, best) { i } else { best });
    let mut direction: [T; K] = core::array::from_fn(|i| entry(i, start));
    let mut variance = entry(start, start);
    for _ in 0..POWER_ROUNDS {
        let norm = direction.iter().fold(T::zero(), |sum, x| sum + *x * *x).root();
        // A zero or a NaN: there is no direction.
        if !(norm > T::zero()) {
            break;
        }
        direction = direction.map(|x| x / norm);
        let image: [T; K] = core::array::from_fn(|i| (0..K).fold(T::zero(), |sum, j| sum + entry(i, j) * direction[j]));
        variance = (0..K).fold(T::zero(), |sum, i| sum + image[i] * direction[i]);
        direction = image;
    }
    let norm = direction.iter().fold(T::zero(), |sum, x| sum + *x * *x).root();
    if norm > T::zero() {
        direction = direction.map(|x| x / norm);
    }
    (direction, variance.max(T::zero()).root())
}
