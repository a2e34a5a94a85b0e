//! A pose of a hinge: its cables' lengths, its angle, and its equations with the angle eliminated.

use super::joint::{Frame, HINGE_UNKNOWNS, Hinge, about};
use super::machine::{Constant, HingeMachine, MAX_CONSTANTS};
use super::rig::MAX_CABLES;
use crate::scalar::Real;
use core::ops::Range;
use nalgebra::{Matrix3, Vector3};

/// Maximum number of unknowns: the hinge's, then the machine's.
pub const MAX_UNKNOWNS: usize = HINGE_UNKNOWNS + MAX_CONSTANTS;

/// Angles of the first search, over the circle or the joint's range.
const SEARCHED: usize = 24;
/// Largest step of an angle, rad.
const MAX_ANGLE_STEP: f64 = 0.3;

/// One pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HingePose<T> {
    /// What the encoders read, mm; as many as the rig has cables.
    pub lengths_mm: [T; MAX_CABLES],
    /// The angle about the axis, rad, from the hinge's own zero.
    pub angle_rad: T,
    /// Squared residuals over the noise's variance, the angle at its best.
    pub chi_square: T,
    /// How much it counts, 0 (left out) to 1.
    pub weight: T,
    /// Bit k set: cable k + 1 is suspected, where the pose is left out.
    pub suspect_cables: u8,
    /// The angle at the estimate that is being tried.
    pub(super) trial_rad: T,
    /// The angle about a second axis, where one is looked for.
    pub(super) second_rad: T,
}

impl<T: Real> HingePose<T> {
    /// A pose with nothing known but the lengths of its cables, mm.
    pub fn new(lengths_mm: [T; MAX_CABLES]) -> Self {
        let zero = T::zero();
        Self {
            lengths_mm,
            angle_rad: zero,
            chi_square: zero,
            weight: T::one(),
            suspect_cables: 0,
            trial_rad: zero,
            second_rad: zero,
        }
    }

    /// Did it take part in the result?
    pub fn is_used(&self) -> bool {
        self.weight > T::zero()
    }
}

/// The lengths at angles over a range: where the search for a pose's angle begins.
#[derive(Clone, Debug)]
pub(super) struct AngleSearch<T> {
    first_rad: T,
    step_rad: T,
    readings_mm: [[T; MAX_CABLES]; SEARCHED],
}

impl<T: Real> AngleSearch<T> {
    /// How many angles there are.
    pub const ANGLES: usize = SEARCHED;

    /// At no angle yet.
    pub fn nowhere() -> Self {
        Self { first_rad: T::zero(), step_rad: T::zero(), readings_mm: [[T::zero(); MAX_CABLES]; SEARCHED] }
    }

    /// Over a range, rad, or the whole circle.
    pub fn new(hinge: &Hinge<T>, machine: &HingeMachine<T>, range_rad: Option<(T, T)>) -> Self {
        let mut search = Self::nowhere();
        search.begin(range_rad);
        search.look(hinge, machine, 0..SEARCHED);
        search
    }

    /// Spreads the angles over a range, rad, or the whole circle.
    pub fn begin(&mut self, range_rad: Option<(T, T)>) {
        let whole = (-T::pi(), T::pi() - T::two_pi() / T::of_integer(SEARCHED as i32));
        let (first_rad, last_rad) = range_rad.unwrap_or(whole);
        self.first_rad = first_rad;
        self.step_rad = (last_rad - first_rad) / T::of_integer(SEARCHED as i32 - 1);
    }

    /// The lengths at some of the angles.
    pub fn look(&mut self, hinge: &Hinge<T>, machine: &HingeMachine<T>, angles: Range<usize>) {
        let (first_rad, step_rad) = (self.first_rad, self.step_rad);
        for (index, readings) in self.readings_mm.iter_mut().enumerate().take(angles.end).skip(angles.start) {
            let rotation = hinge.rotation(first_rad + step_rad * T::of_integer(index as i32));
            let ends = machine.end_mm().iter().take(machine.cables()).enumerate();
            for ((cable, end), reading) in ends.zip(readings) {
                let at = hinge.platform_foot_mm() + rotation * (end - hinge.foot_in_platform_mm());
                *reading = machine.reading(cable, machine.span(cable, &at).length_mm).0;
            }
        }
    }

    /// The angle whose lengths are nearest to a pose's, rad.
    pub fn nearest_rad(&self, lengths_mm: &[T; MAX_CABLES], cables: usize) -> T {
        let mut best = (0, T::zero());
        for (index, readings) in self.readings_mm.iter().enumerate() {
            let pairs = readings.iter().zip(lengths_mm).take(cables);
            let squares = pairs.fold(T::zero(), |sum, (a, b)| sum + (*a - *b) * (*a - *b));
            if index == 0 || squares < best.1 {
                best = (index, squares);
            }
        }
        self.first_rad + self.step_rad * T::of_integer(best.0 as i32)
    }
}

/// The equations of a pose: one row a cable.
#[derive(Clone, Copy, Debug)]
pub(super) struct PoseRows<T> {
    /// Reading minus model, mm.
    pub residual_mm: [T; MAX_CABLES],
    /// Derivative of the reading with the angle, mm/rad.
    pub by_angle: [T; MAX_CABLES],
    /// Derivatives with the unknowns.
    pub jacobian: [[T; MAX_UNKNOWNS]; MAX_CABLES],
}

/// Where a hinge and an angle put the platform.
pub(super) struct PoseAt<'a, T: Real> {
    pub hinge: &'a Hinge<T>,
    pub machine: &'a HingeMachine<T>,
    /// The hinge's.
    pub frame: Frame<T>,
    /// The platform's ends in {P}, mm: the machine's, or moved against them.
    pub end_mm: &'a [Vector3<T>; MAX_CABLES],
    /// Bit k set: cable k takes part.
    pub cables: u8,
}

impl<'a, T: Real> PoseAt<'a, T> {
    /// All cables, the ends where the machine has them.
    pub fn new(hinge: &'a Hinge<T>, machine: &'a HingeMachine<T>) -> Self {
        Self { hinge, machine, frame: hinge.frame(), end_mm: machine.end_mm(), cables: u8::MAX }
    }

    fn rotation(&self, angle_rad: T) -> Matrix3<T> {
        about(self.hinge.axis(), angle_rad) * self.frame.at_zero
    }

    fn takes_part(&self, cable: usize) -> bool {
        cable < self.machine.cables() && self.cables & (1 << cable) != 0
    }

    /// The angle that fits best, by Gauss-Newton from `angle_rad`, and the squares that it leaves, mm².
    pub fn best_angle(&self, lengths_mm: &[T; MAX_CABLES], angle_rad: T, rounds: usize) -> (T, T) {
        let angle = self.turned(lengths_mm, angle_rad, rounds);
        (angle, self.squares(lengths_mm, angle))
    }

    /// The squares that an angle leaves, mm².
    pub fn squares(&self, lengths_mm: &[T; MAX_CABLES], angle_rad: T) -> T {
        self.sums(lengths_mm, angle_rad).2
    }

    /// The angle after some rounds of Gauss-Newton.
    pub fn turned(&self, lengths_mm: &[T; MAX_CABLES], angle_rad: T, rounds: usize) -> T {
        let mut angle = angle_rad;
        for _ in 0..rounds {
            let (gradient, information, _) = self.sums(lengths_mm, angle);
            let limit = T::of(MAX_ANGLE_STEP);
            angle += (gradient / information.max(T::of(1e-9))).max(-limit).min(limit);
        }
        angle
    }

    /// Dᵀe, DᵀD and eᵀe of a pose at an angle, D the derivative with the angle.
    fn sums(&self, lengths_mm: &[T; MAX_CABLES], angle_rad: T) -> (T, T, T) {
        let rotation = self.rotation(angle_rad);
        let foot = self.hinge.platform_foot_mm();
        let (mut gradient, mut information, mut squares) = (T::zero(), T::zero(), T::zero());
        for (cable, (end, measured)) in self.end_mm.iter().zip(lengths_mm).enumerate() {
            if !self.takes_part(cable) {
                continue;
            }
            let at = foot + rotation * (end - self.hinge.foot_in_platform_mm());
            let span = self.machine.span(cable, &at);
            let (reading, scale) = self.machine.reading(cable, span.length_mm);
            let by_angle = scale * span.direction.dot(&self.hinge.axis().cross(&(at - self.hinge.foot_mm())));
            let residual = *measured - reading;
            gradient += by_angle * residual;
            information += by_angle * by_angle;
            squares += residual * residual;
        }
        (gradient, information, squares)
    }

    /// The equations of a pose at an angle; the angle is not eliminated yet. `constants`: do the machine's take part?
    pub fn rows(&self, lengths_mm: &[T; MAX_CABLES], angle_rad: T, constants: bool) -> PoseRows<T> {
        let mut rows = PoseRows::none();
        self.fill(&mut rows, lengths_mm, angle_rad, constants, 0..MAX_CABLES);
        rows
    }

    /// The same into some of the rows, which are all zero.
    fn fill(
        &self,
        rows: &mut PoseRows<T>,
        lengths_mm: &[T; MAX_CABLES],
        angle_rad: T,
        constants: bool,
        cables: Range<usize>,
    ) {
        let zero = T::zero();
        let rotation = self.rotation(angle_rad);
        let outputs = rows.residual_mm.iter_mut().zip(&mut rows.by_angle).zip(&mut rows.jacobian);
        for (cable, ((residual, by_angle), row)) in outputs.enumerate() {
            let (Some(end), Some(measured)) = (self.end_mm.get(cable), lengths_mm.get(cable)) else { continue };
            if !self.takes_part(cable) || !cables.contains(&cable) {
                continue;
            }
            let arm = end - self.hinge.foot_in_platform_mm();
            let span = self.machine.span(cable, &(self.hinge.platform_foot_mm() + rotation * arm));
            let (reading, scale) = self.machine.reading(cable, span.length_mm);
            let u = span.direction * scale;
            *residual = *measured - reading;
            let [of_hinge @ .., turning] = self.hinge.motions(&self.frame, &rotation, &arm);
            *by_angle = u.dot(&turning);
            let (hinge_part, constant_part) = row.split_at_mut(HINGE_UNKNOWNS);
            hinge_part.iter_mut().zip(&of_hinge).for_each(|(entry, motion)| *entry = u.dot(motion));
            if !constants {
                continue;
            }
            let in_platform = rotation.tr_mul(&u);
            for ((constant, _), entry) in self.machine.constants().iter().zip(constant_part) {
                let motion = |point: Option<&Vector3<T>>, by: &Vector3<T>| point.map_or(zero, |point| by.dot(point));
                let of_this = |of: usize, value: T| if of == cable { value } else { zero };
                *entry = match *constant {
                    Constant::Base(_) => -motion(self.machine.base_motion(*constant, cable), &u),
                    Constant::Ends(_) => motion(self.machine.end_motion(*constant, cable), &in_platform),
                    Constant::Offset(of) => of_this(of, T::one()),
                    Constant::Scale(of) => of_this(of, self.machine.scale_motion(cable, span.length_mm)),
                };
            }
        }
    }
}

impl<T: Real> PoseRows<T> {
    /// No equations.
    pub fn none() -> Self {
        let zero = T::zero();
        Self {
            residual_mm: [zero; MAX_CABLES],
            by_angle: [zero; MAX_CABLES],
            jacobian: [[zero; MAX_UNKNOWNS]; MAX_CABLES],
        }
    }

    /// Those of [`PoseAt::rows`], in place and some at a time, the first ones first.
    pub fn set(
        &mut self,
        at: &PoseAt<'_, T>,
        lengths_mm: &[T; MAX_CABLES],
        angle_rad: T,
        constants: bool,
        cables: Range<usize>,
    ) {
        if cables.start == 0 {
            *self = Self::none();
        }
        at.fill(self, lengths_mm, angle_rad, constants, cables);
    }

    /// The same equations with another weight.
    pub fn scale(&mut self, weight: T) {
        let numbers = self.jacobian.iter_mut().flatten().chain(&mut self.residual_mm);
        numbers.for_each(|number| *number *= weight);
    }

    /// The same equations in the first `unknowns` without what a nuisance with these derivatives can explain: the projection onto
    /// what is left.
    pub fn eliminate(&mut self, by_nuisance: &[T; MAX_CABLES], unknowns: usize) {
        let squares = by_nuisance.iter().fold(T::zero(), |sum, d| sum + *d * *d);
        let scale = T::one() / squares.max(T::of(1e-9));
        let pairs = self.residual_mm.iter().zip(by_nuisance);
        let of_residual = pairs.fold(T::zero(), |sum, (residual, d)| sum + *residual * *d) * scale;
        for (residual, d) in self.residual_mm.iter_mut().zip(by_nuisance) {
            *residual -= *d * of_residual;
        }
        let mut shares = [T::zero(); MAX_UNKNOWNS];
        for (row, d) in self.jacobian.iter().zip(by_nuisance) {
            shares.iter_mut().zip(row).take(unknowns).for_each(|(share, entry)| *share += *entry * *d * scale);
        }
        for (row, d) in self.jacobian.iter_mut().zip(by_nuisance) {
            row.iter_mut().zip(&shares).take(unknowns).for_each(|(entry, share)| *entry -= *share * *d);
        }
    }
}
