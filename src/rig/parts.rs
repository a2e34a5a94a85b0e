//! The parts of a rig: its drive, its cables, how well they are known, and where the centre is expected.

use super::{CABLES, POINTS};
use crate::scalar::Real;
use nalgebra::Vector3;

/// How a motor's encoder turns into a cable length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drum<T> {
    /// Radius at which the cable leaves the drum, mm, positive.
    pub radius_mm: T,
    /// Counts of one drum turn (quadrature counts times gear ratio), positive.
    pub counts_per_turn: T,
    /// Length of each cable at count zero, mm, positive. Counts rise as cable is paid out.
    pub home_length_mm: [T; CABLES],
    /// Fastest that the drive can move a cable, mm/s, positive. A faster change is a fault of the encoder.
    pub fastest_mm_per_s: T,
}

/// A guide pulley that swivels about the axis along which its cable comes up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pulley<T> {
    /// Radius to the middle of the cable, mm; 0 = no pulley.
    pub radius_mm: T,
    /// Direction in which the cable comes up to the pulley, in {B}, a unit vector.
    pub axis: Vector3<T>,
}

/// The two ends of one cable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CableEnds<T> {
    /// Where it leaves the base, in {B}, mm. With a pulley: where it enters, on the swivel axis.
    pub base_mm: Vector3<T>,
    /// Where it ends on the platform, mm.
    pub end_mm: Vector3<T>,
    /// The pulley that it runs over.
    pub pulley: Pulley<T>,
}

/// How well the machine is known: 1σ of each constant, 0 = exactly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance<T> {
    /// Each coordinate of an attachment point, mm.
    pub base_mm: T,
    /// Each platform edge, mm; where every cable has ends of its own, each coordinate of an end.
    pub edges_mm: T,
    /// Each encoder's offset: what homing leaves, mm.
    pub offset_mm: T,
    /// Each drum's radius, relative.
    pub drum: T,
}

/// Encoder offsets and drum scales that commissioning has found, taken off the readings first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correction<T> {
    /// Encoder offsets (reading minus true length at home), mm.
    pub offset_mm: [T; CABLES],
    /// Drum scales, about 1: reading = home + scale (L - home) + offset.
    pub scale: [T; CABLES],
}

/// Largest valid tolerance of a length, mm, and of a drum's radius, relative.
const MAX_TOLERANCE_MM: f64 = 100.0;
const MAX_DRUM_TOLERANCE: f64 = 0.2;

/// Largest valid correction of a drum's radius, relative.
const MAX_SCALE_CORRECTION: f64 = 0.2;

impl<T: Real> Drum<T> {
    /// Is every number of it positive and finite?
    pub(crate) fn is_possible(&self) -> bool {
        let numbers = [self.radius_mm, self.counts_per_turn, self.fastest_mm_per_s];
        numbers.iter().chain(&self.home_length_mm).all(|number| *number > T::zero() && number.is_a_number())
    }
}

impl<T: Real> Pulley<T> {
    /// No pulley.
    pub fn none() -> Self {
        Self { radius_mm: T::zero(), axis: Vector3::z() }
    }
}

impl<T: Real> Tolerance<T> {
    /// Everything exact.
    pub fn exact() -> Self {
        let zero = T::zero();
        Self { base_mm: zero, edges_mm: zero, offset_mm: zero, drum: zero }
    }

    /// A wearable machine built and measured by hand: points and edges within 0.5 mm, homing within 0.3 mm (an index
    /// mark passed by hand), drums turned to 0.1 %. Careful hand measurement reaches 1 to 3 mm on machines of a metre,
    /// half a millimetre with a calliper on one that can be worn.
    pub fn hand_built() -> Self {
        let half = T::of(0.5);
        Self { base_mm: half, edges_mm: half, offset_mm: T::of(0.3), drum: T::of(0.001) }
    }

    pub(crate) fn is_possible(&self) -> bool {
        let lengths = [self.base_mm, self.edges_mm, self.offset_mm];
        let within = |value: &T, most: f64| *value >= T::zero() && *value <= T::of(most);
        lengths.iter().all(|value| within(value, MAX_TOLERANCE_MM)) && within(&self.drum, MAX_DRUM_TOLERANCE)
    }
}

impl<T: Real> Correction<T> {
    /// What cable `cable` (from 0) has truly paid out beyond its home length, mm, when it reads `read_mm` beyond it.
    pub(crate) fn applied_to(&self, cable: usize, read_mm: T) -> T {
        match (self.offset_mm.get(cable), self.scale.get(cable)) {
            (Some(offset_mm), Some(scale)) => (read_mm - *offset_mm) / *scale,
            _ => read_mm,
        }
    }

    pub(super) fn is_possible(&self) -> bool {
        self.offset_mm.iter().all(|offset| offset.is_a_number())
            && self.scale.iter().all(|scale| (*scale - T::one()).abs() <= T::of(MAX_SCALE_CORRECTION))
    }
}

/// What is identified: the joint centre in {B} and its distances to the three end-points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters<T> {
    /// Joint centre O in {B}, mm.
    pub centre_mm: Vector3<T>,
    /// Distances |OP1|, |OP2|, |OP3|, mm.
    pub radii_mm: [T; POINTS],
}

impl<T: Real> Parameters<T> {
    /// The six unknowns in the paper's order x, y, z, p1, p2, p3, mm.
    pub fn to_array(self) -> [T; 6] {
        let [x, y, z] = self.centre_mm.into();
        let [p1, p2, p3] = self.radii_mm;
        [x, y, z, p1, p2, p3]
    }

    /// From the six unknowns in the paper's order x, y, z, p1, p2, p3, mm.
    pub fn from_array([x, y, z, p1, p2, p3]: [T; 6]) -> Self {
        Self { centre_mm: Vector3::new(x, y, z), radii_mm: [p1, p2, p3] }
    }

    /// Eq. 16: these parameters moved by `step` (mm, order x, y, z, p1, p2, p3).
    #[must_use]
    pub fn moved_by(self, step: &[T; 6]) -> Self {
        let now = self.to_array();
        Self::from_array(core::array::from_fn(|k| now[k] + step[k]))
    }
}
