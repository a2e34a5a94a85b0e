//! Deterministic starts: where a hinge of a limb can be, from the machine alone.
//!
//! A hinge of a limb lies beyond the base's ring on the platform's side, and crosses the limb: its directions lie in the
//! planes of both rings.

use super::joint::Hinge;
use super::machine::HingeMachine;
use crate::linear_algebra::{symmetric_eigen, unit};
use crate::scalar::Real;
use nalgebra::{Matrix3, Vector3};

/// Directions that are tried, with the platform on either side of the axis each.
const DIRECTIONS: usize = 24;
/// Number of starts.
pub(super) const STARTS: usize = 2 * DIRECTIONS;

/// Steps of the directions in the two planes, turns: the golden ratio and the plastic number spread them evenly.
const STEP_IN_BASE: f64 = 0.618_034;
const STEP_IN_PLATFORM: f64 = 0.754_877_7;

/// Distance of the axis from the middle of the base's points and of the platform's, in mean cable lengths.
const FROM_BASE: f64 = 0.65;
const FROM_PLATFORM: f64 = 0.4;

/// Start `index` of [`STARTS`], for cables of this mean length, mm.
pub(super) fn start<T: Real>(machine: &HingeMachine<T>, mean_length_mm: T, index: usize) -> Hinge<T> {
    let (base, normal) = plane(machine.base_mm());
    let normal = base_side(normal);
    let (platform, platform_normal) = plane(machine.end_mm().get(..machine.cables()).unwrap_or(&[]));
    let side = if index.is_multiple_of(2) { T::one() } else { -T::one() };
    let turn = T::two_pi() * T::of_integer((index / 2) as i32);
    Hinge::through(
        &in_plane(&normal, turn * T::of(STEP_IN_BASE)),
        &(base + normal * (mean_length_mm * T::of(FROM_BASE))),
        &in_plane(&platform_normal, turn * T::of(STEP_IN_PLATFORM)),
        &(platform + platform_normal * (side * mean_length_mm * T::of(FROM_PLATFORM))),
    )
}

/// Number of starts beside a hinge.
pub(super) const STARTS_BESIDE: usize = DIRECTIONS;

/// Start `index` of [`STARTS_BESIDE`]: the axis of a known hinge in the base, anywhere in the platform.
pub(super) fn beside<T: Real>(
    machine: &HingeMachine<T>,
    mean_length_mm: T,
    known: &Hinge<T>,
    index: usize,
) -> Hinge<T> {
    let start = start(machine, mean_length_mm, index);
    let (base, _) = plane(machine.base_mm());
    let in_platform = start.foot_in_platform_mm();
    Hinge::through(known.axis(), &known.nearest_mm(&base), &start.axis_in_platform(), in_platform)
}

/// Is the hinge on the platform's side of the base? Everything mirrored in the plane of flat rings fits as well.
pub(super) fn is_on_platform_side<T: Real>(machine: &HingeMachine<T>, hinge: &Hinge<T>) -> bool {
    let (middle, normal) = plane(machine.base_mm());
    base_side(normal).dot(&(hinge.nearest_mm(&middle) - middle)) > T::zero()
}

/// The direction of the base's normal that points to the platform: +z of the base's frame.
fn base_side<T: Real>(normal: Vector3<T>) -> Vector3<T> {
    if normal.z < T::zero() { -normal } else { normal }
}

/// Middle and normal of the plane best fitted to some points.
fn plane<T: Real>(points: &[Vector3<T>]) -> (Vector3<T>, Vector3<T>) {
    let count = T::of_integer(points.len().max(1) as i32);
    let middle = points.iter().fold(Vector3::zeros(), |sum, point| sum + point) / count;
    let spread = points.iter().fold(Matrix3::zeros(), |sum, point| {
        let from = point - middle;
        sum + from * from.transpose()
    });
    let eigen = symmetric_eigen(&spread);
    let [x, y, z] = eigen.values.into();
    let least = if x <= y && x <= z {
        0
    } else if y <= z {
        1
    } else {
        2
    };
    (middle, unit(&crate::linear_algebra::column(&eigen.vectors, least)))
}

fn in_plane<T: Real>(normal: &Vector3<T>, turn_rad: T) -> Vector3<T> {
    let [first, second] = super::joint::across(normal);
    let (sin, cos) = turn_rad.sine_and_cosine();
    first * cos + second * sin
}
