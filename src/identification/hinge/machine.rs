//! The hinge's machine as it is estimated: where the cables end, and the constants that are not known exactly.
//!
//! Each constant whose tolerance is not zero takes part with that as its prior standard deviation: the shape of the
//! base's points and of the platform's (their rigid motions are motions of the frames, which no length can see), an
//! offset of each encoder, a scale of each drum.

use super::rig::{HingeRig, MAX_CABLES};
use crate::identification::machine::{SCALE_UNIT, for_each_mode};
use crate::kinematics::geometry::{Span, over_pulley, straight};
use crate::rig::Pulley;
use crate::scalar::Real;
use heapless::Vec;
use nalgebra::Vector3;

/// Shape modes of four points: twelve coordinates less six of rigid motion.
const MAX_MODES: usize = 6;
/// Maximum number of unknown constants.
pub const MAX_CONSTANTS: usize = 2 * MAX_MODES + 2 * MAX_CABLES;

/// Points of one body, as many as there are cables.
type Points<T> = [Vector3<T>; MAX_CABLES];

/// An unknown constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Constant {
    /// A mode of the base's shape, mm.
    Base(usize),
    /// A mode of the shape of the platform's ends, mm.
    Ends(usize),
    /// The offset of a cable's encoder (cable from 0), mm.
    Offset(usize),
    /// The scale of a cable's drum, less one, in units of [`SCALE_UNIT`].
    Scale(usize),
}

/// The machine at the present estimate of its constants.
#[derive(Clone, Debug, PartialEq)]
pub struct HingeMachine<T: Real> {
    cables: usize,
    stated_base_mm: Points<T>,
    stated_end_mm: Points<T>,
    pulleys: [Pulley<T>; MAX_CABLES],
    home_mm: [T; MAX_CABLES],
    base_modes: Vec<Points<T>, MAX_MODES>,
    end_modes: Vec<Points<T>, MAX_MODES>,
    constants: Vec<(Constant, T), MAX_CONSTANTS>,
    values: [T; MAX_CONSTANTS],
    base_mm: Points<T>,
    end_mm: Points<T>,
    offset_mm: [T; MAX_CABLES],
    scale: [T; MAX_CABLES],
}

impl<T: Real> HingeMachine<T> {
    /// The machine as stated.
    pub fn new(rig: &HingeRig<T>) -> Self {
        let (zero, one) = (T::zero(), T::one());
        let cables = rig.cables();
        let mut machine = Self {
            cables: cables.len(),
            stated_base_mm: [Vector3::zeros(); MAX_CABLES],
            stated_end_mm: [Vector3::zeros(); MAX_CABLES],
            pulleys: [Pulley::none(); MAX_CABLES],
            home_mm: *rig.home_length_mm(),
            base_modes: Vec::new(),
            end_modes: Vec::new(),
            constants: Vec::new(),
            values: [zero; MAX_CONSTANTS],
            base_mm: [Vector3::zeros(); MAX_CABLES],
            end_mm: [Vector3::zeros(); MAX_CABLES],
            offset_mm: [zero; MAX_CABLES],
            scale: [one; MAX_CABLES],
        };
        let places = machine.stated_base_mm.iter_mut().zip(&mut machine.stated_end_mm).zip(&mut machine.pulleys);
        for (((base, end), pulley), cable) in places.zip(cables) {
            (*base, *end, *pulley) = (cable.base_mm, cable.end_mm, cable.pulley);
        }
        let tolerance = rig.tolerance();
        if tolerance.base_mm > zero {
            put_modes(&mut machine.base_modes, &machine.stated_base_mm, machine.cables);
        }
        if tolerance.edges_mm > zero {
            put_modes(&mut machine.end_modes, &machine.stated_end_mm, machine.cables);
        }
        let mut add = |count: usize, constant: fn(usize) -> Constant, sigma: T| {
            for index in 0..if sigma > zero { count } else { 0 } {
                let _ = machine.constants.push((constant(index), sigma));
            }
        };
        add(machine.base_modes.len(), Constant::Base, tolerance.base_mm);
        add(machine.end_modes.len(), Constant::Ends, tolerance.edges_mm);
        add(cables.len(), Constant::Offset, tolerance.offset_mm);
        add(cables.len(), Constant::Scale, tolerance.drum / T::of(SCALE_UNIT));
        machine.set_values([zero; MAX_CONSTANTS]);
        machine
    }

    /// Number of cables.
    pub fn cables(&self) -> usize {
        self.cables
    }

    /// The unknown constants, each with the 1σ of its prior.
    pub fn constants(&self) -> &[(Constant, T)] {
        &self.constants
    }

    /// By how much each constant differs from what was stated.
    pub fn values(&self) -> &[T; MAX_CONSTANTS] {
        &self.values
    }

    /// Where the base's points are by the present estimate, in {B}, mm.
    pub fn base_mm(&self) -> &[Vector3<T>] {
        self.base_mm.get(..self.cables).unwrap_or(&[])
    }

    /// Where the platform's points are by the present estimate, in {P}, mm.
    pub fn end_mm(&self) -> &[Vector3<T>; MAX_CABLES] {
        &self.end_mm
    }

    /// What each encoder reads too much, mm.
    pub fn offset_mm(&self) -> &[T; MAX_CABLES] {
        &self.offset_mm
    }

    /// How much cable each drum pays out for 1 mm stated.
    pub fn scale(&self) -> &[T; MAX_CABLES] {
        &self.scale
    }

    /// Sets the constants.
    pub fn set_values(&mut self, values: [T; MAX_CONSTANTS]) {
        self.values = values;
        (self.base_mm, self.end_mm) = (self.stated_base_mm, self.stated_end_mm);
        for ((constant, _), value) in self.constants.iter().zip(&values) {
            match *constant {
                Constant::Base(mode) => displace(&mut self.base_mm, self.base_modes.get(mode), *value),
                Constant::Ends(mode) => displace(&mut self.end_mm, self.end_modes.get(mode), *value),
                Constant::Offset(cable) => set(&mut self.offset_mm, cable, *value),
                Constant::Scale(cable) => set(&mut self.scale, cable, T::one() + *value * T::of(SCALE_UNIT)),
            }
        }
    }

    /// Cable `cable` (from 0) with its end at `at_mm` in {B}: its true length and direction.
    pub fn span(&self, cable: usize, at_mm: &Vector3<T>) -> Span<T> {
        let Some((base, pulley)) = self.base_mm.get(cable).zip(self.pulleys.get(cable)) else {
            return straight(at_mm);
        };
        let span = at_mm - base;
        if pulley.radius_mm > T::zero() { over_pulley(pulley, &span) } else { straight(&span) }
    }

    /// What the encoder of a cable of this true length reads, mm, and its derivative with the true length.
    pub fn reading(&self, cable: usize, length_mm: T) -> (T, T) {
        let of = |numbers: &[T; MAX_CABLES]| numbers.get(cable).copied().unwrap_or_else(T::zero);
        let (home, scale) = (of(&self.home_mm), of(&self.scale));
        (home + scale * (length_mm - home) + of(&self.offset_mm), scale)
    }

    /// How far a constant moves the platform's end of a cable in {P}, per unit.
    pub fn end_motion(&self, constant: Constant, cable: usize) -> Option<&Vector3<T>> {
        let Constant::Ends(mode) = constant else { return None };
        self.end_modes.get(mode)?.get(cable)
    }

    /// How far a constant moves the base's end of a cable in {B}, per unit.
    pub fn base_motion(&self, constant: Constant, cable: usize) -> Option<&Vector3<T>> {
        let Constant::Base(mode) = constant else { return None };
        self.base_modes.get(mode)?.get(cable)
    }

    /// How far a drum's scale changes the reading of a cable, per unit.
    pub fn scale_motion(&self, cable: usize, length_mm: T) -> T {
        (length_mm - self.home_mm.get(cable).copied().unwrap_or(length_mm)) * T::of(SCALE_UNIT)
    }
}

fn set<T: Real>(numbers: &mut [T; MAX_CABLES], cable: usize, value: T) {
    if let Some(number) = numbers.get_mut(cable) {
        *number = value;
    }
}

fn displace<T: Real>(points: &mut Points<T>, mode: Option<&Points<T>>, value: T) {
    for (point, moved) in points.iter_mut().zip(mode.into_iter().flatten()) {
        *point += moved * value;
    }
}

/// Adds the modes of the first `cables` points to none.
fn put_modes<T: Real>(modes: &mut Vec<Points<T>, MAX_MODES>, points: &Points<T>, cables: usize) {
    for_each_mode(points.get(..cables).unwrap_or_default(), |mode| {
        // Points that there are not do not move.
        let _ = mode.first_chunk().map(|points| modes.push(*points));
    });
}
