//! Geometry of the six cables: their ends, and the guide pulleys that they run over.

use crate::rig::{ATTACHMENTS, CABLES, POINTS, Pulley, Rig};
use crate::scalar::Real;
use nalgebra::Vector3;

/// The ends of the six cables as the kinematics use them; the estimator moves a copy of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geometry<T> {
    /// Where each cable leaves the base, in {B}, mm. With a pulley: where it enters, on the swivel axis.
    pub base_mm: [Vector3<T>; CABLES],
    /// Where each cable ends on the platform, in {P}, mm.
    pub end_mm: [Vector3<T>; CABLES],
    /// The guide pulley of each cable.
    pub pulleys: Option<[Pulley<T>; CABLES]>,
    /// Cables 1 and 2, 3 and 4, 5 and 6 end at one point each, and every base point serves two cables: the 3-3 machine
    /// of the paper.
    pub is_three_three: bool,
}

/// Length of a cable with its end at one place, and its gradient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span<T> {
    /// Length from where the cable enters (or is attached) to its end, mm.
    pub length_mm: T,
    /// Gradient of the length with the end: the unit vector along the free part of the cable.
    pub direction: Vector3<T>,
}

impl<T: Real> Geometry<T> {
    /// The geometry of `rig`.
    pub fn new(rig: &Rig<T>) -> Self {
        match rig.cables() {
            Some(cables) => Self {
                base_mm: cables.map(|cable| cable.base_mm),
                end_mm: cables.map(|cable| cable.end_mm),
                pulleys: cables
                    .iter()
                    .any(|cable| cable.pulley.radius_mm > T::zero())
                    .then(|| cables.map(|c| c.pulley)),
                is_three_three: false,
            },
            None => Self::three_three(rig.base_mm(), &rig.platform_mm()),
        }
    }

    /// The 3-3 machine with these attachment points in {B} and end-points in {P}, mm.
    pub fn three_three(base_mm: &[Vector3<T>; POINTS], platform_mm: &[Vector3<T>; POINTS]) -> Self {
        let point = |cable: usize| cable / 2;
        Self {
            base_mm: core::array::from_fn(|cable| base_mm[ATTACHMENTS[point(cable)][cable % 2]]),
            end_mm: core::array::from_fn(|cable| platform_mm[point(cable)]),
            pulleys: None,
            is_three_three: true,
        }
    }

    /// The end-points P1..P3 in {P}, mm: of a machine with ends of its own for every cable, the middle of each two.
    pub fn end_points_mm(&self) -> [Vector3<T>; POINTS] {
        let [a, b, c, d, e, f] = &self.end_mm;
        let half = T::of(0.5);
        [(a + b) * half, (c + d) * half, (e + f) * half]
    }

    /// Cable `cable` (from 0) with its end at `end_mm` in {B}.
    ///
    /// Inlined into the rows of the Jacobian: 100 instructions of 630 less.
    #[inline(always)]
    pub fn span(&self, cable: usize, end_mm: &Vector3<T>) -> Span<T> {
        let span = end_mm - self.base_mm[cable];
        match &self.pulleys {
            Some(pulleys) if pulleys[cable].radius_mm > T::zero() => over_pulley(&pulleys[cable], &span),
            _ => straight(&span),
        }
    }
}

/// A straight cable. `span`: from its attachment point to its end, in {B}, mm.
pub fn straight<T: Real>(span: &Vector3<T>) -> Span<T> {
    let length_mm = span.norm_squared().root();
    Span { length_mm, direction: span * (T::one() / length_mm) }
}

/// A cable over a swivelling guide pulley (Pott 2012): it comes up along the swivel axis, runs round the pulley, which
/// turns about that axis to face the cable's end, and leaves it on a tangent.
///
/// In the plane of the swivel axis (z, from where the cable enters) and the end (x across): the pulley's centre stands
/// at (r, 0), free = √((x - r)² + z² - r²), and the cable touches the rim over r (π - atan2(z, x - r) - atan2(free,
/// r)). Not finite where the end lies inside the pulley.
pub fn over_pulley<T: Real>(pulley: &Pulley<T>, span: &Vector3<T>) -> Span<T> {
    let (r, axis) = (pulley.radius_mm, &pulley.axis);
    let z = span.dot(axis);
    let across = span - axis * z;
    let x = across.norm_squared().root();
    let from_centre = x - r;
    let free = (from_centre * from_centre + z * z - r * r).root();
    let to_end = z.atan2(from_centre);
    let to_tangent = free.atan2(r);
    let length_mm = free + r * (T::pi() - to_end - to_tangent);
    // The rim's point of tangency stands at the sum of both angles from the direction away from the axis: sine and cosine
    // of the sum, from (z, x - r) and (free, r), which are equally long. A call of `sin_cos` takes 7 KB of flash.
    let by_square = T::one() / (free * free + r * r);
    let (sin, cos) = ((z * r + from_centre * free) * by_square, (from_centre * r - z * free) * by_square);
    let along = z - r * sin;
    let outward = from_centre - r * cos;
    let direction = (axis * along + across * (outward / x)) * (T::one() / free);
    Span { length_mm, direction }
}
