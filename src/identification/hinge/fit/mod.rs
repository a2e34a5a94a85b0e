//! The fit: the hinge and the machine's constants at the present estimate, and the equations for a step of them, the angle
//! eliminated pose by pose. What takes longer is done in slices.

mod equate;
mod finish;
mod minimise;
mod place;
mod scratch;
mod solve;

pub(super) use self::finish::Finish;
pub(super) use self::minimise::Minimise;
pub(super) use self::place::Place;
pub(super) use self::scratch::Scratch;
pub(super) use self::solve::Solve;

use super::joint::{HINGE_UNKNOWNS, Hinge, is_direction};
use super::machine::{HingeMachine, MAX_CONSTANTS};
use super::pose::{HingePose, MAX_UNKNOWNS, PoseAt};
use super::rig::{Drawing, HingeRig};
use crate::linear_algebra::{NormalEquations, packed_index};
use crate::scalar::Real;
use core::ops::Range;

/// Entries of the packed normal matrix.
const PACKED: usize = MAX_UNKNOWNS * (MAX_UNKNOWNS + 1) / 2;
/// The normal equations of a hinge.
pub(super) type Equations<T> = NormalEquations<T, MAX_UNKNOWNS, PACKED>;

/// A hinge, and the machine's constants.
pub(super) type Estimate<T> = (Hinge<T>, [T; MAX_CONSTANTS]);

/// Largest step of a direction, rad, and of a place, mm.
const MAX_TURN: f64 = 0.5;
const MAX_MOVE_MM: f64 = 60.0;
/// The hinge and the machine at the present estimate.
#[derive(Clone, Debug)]
pub(super) struct Fit<T: Real> {
    pub hinge: Hinge<T>,
    pub machine: HingeMachine<T>,
    /// Do the machine's constants take part?
    pub constants: bool,
    pub drawing: Option<Drawing<T>>,
    pub noise_mm: T,
    /// An unknown of the hinge that stays where it is.
    pub held: Option<usize>,
    /// Squares of the residuals and priors, mm².
    pub squares_mm2: T,
    /// At the present estimate, factored by [`Finish`].
    pub equations: Equations<T>,
}

impl<T: Real> Fit<T> {
    /// At the drawing, or anywhere.
    pub fn new(rig: &HingeRig<T>, hinge: Hinge<T>) -> Self {
        Self {
            hinge,
            machine: HingeMachine::new(rig),
            constants: false,
            drawing: rig.drawing().copied(),
            noise_mm: rig.length_noise_mm(),
            held: None,
            squares_mm2: T::zero(),
            equations: Equations::new(HINGE_UNKNOWNS),
        }
    }

    /// The prior standard deviations of the hinge, with the hinge that they are about.
    pub fn prior(&self) -> Option<(&Hinge<T>, &[T; HINGE_UNKNOWNS])> {
        let drawing = self.drawing.as_ref()?;
        Some((&drawing.hinge, drawing.sigma.as_ref()?))
    }

    /// Unknowns that take part.
    pub fn unknowns(&self) -> usize {
        HINGE_UNKNOWNS + if self.constants { self.machine.constants().len() } else { 0 }
    }

    /// The range of angles that is searched: the joint's about a drawing that is a prior, else the whole circle.
    pub fn range_rad(&self) -> Option<(T, T)> {
        self.drawing.as_ref().filter(|drawing| drawing.sigma.is_some()).map(|drawing| drawing.range_rad)
    }

    /// Gives a pose its best angle from the one on trial, and its χ².
    pub fn settle(&self, pose: &mut HingePose<T>) {
        let at = PoseAt::new(&self.hinge, &self.machine);
        let (angle, left) = at.best_angle(&pose.lengths_mm, pose.trial_rad, 1);
        pose.angle_rad = angle;
        pose.chi_square = left / (self.noise_mm * self.noise_mm);
    }

    /// Squares of the priors, mm².
    pub fn prior_squares(&self) -> T {
        let variance = self.noise_mm * self.noise_mm;
        let ratio = |value: T, sigma: T| (value / sigma) * (value / sigma) * variance;
        let mut squares = T::zero();
        if let Some((drawn, sigma)) = self.prior() {
            let difference = drawn.difference(&self.hinge);
            squares = difference.iter().zip(sigma).fold(squares, |sum, (x, sigma)| sum + ratio(*x, *sigma));
        }
        let constants = self.machine.constants().iter().zip(self.machine.values());
        constants.fold(squares, |sum, ((_, sigma), value)| sum + ratio(*value, *sigma))
    }

    /// Adds some of the drawing's priors to the normal equations.
    pub fn add_priors(&mut self, unknowns: Range<usize>) {
        let mut row = [T::zero(); MAX_UNKNOWNS];
        if let Some(Drawing { hinge: drawn, sigma: Some(sigma), .. }) = &self.drawing {
            let difference = drawn.difference(&self.hinge);
            let jacobian = drawn.difference_jacobian(&self.hinge);
            for (i, (value, sigma)) in difference.iter().zip(sigma).enumerate() {
                if !unknowns.contains(&i) {
                    continue;
                }
                let scale = self.noise_mm / *sigma;
                for (j, entry) in row.iter_mut().enumerate().take(HINGE_UNKNOWNS) {
                    *entry = jacobian.get((i, j)).copied().unwrap_or_else(T::zero) * scale;
                }
                // The machine's constants have no share in it.
                self.equations.add_row(row.get(..HINGE_UNKNOWNS).unwrap_or(&row), -*value * scale);
            }
        }
    }

    /// Adds the priors of the machine's constants.
    pub fn add_priors_of_constants(&mut self) {
        if !self.constants {
            return;
        }
        for (k, ((_, sigma), value)) in self.machine.constants().iter().zip(self.machine.values()).enumerate() {
            let precision = (self.noise_mm / *sigma) * (self.noise_mm / *sigma);
            self.equations.add_to_entry(HINGE_UNKNOWNS + k, HINGE_UNKNOWNS + k, precision);
            self.equations.add_to_gradient(HINGE_UNKNOWNS + k, -*value * precision);
        }
    }

    /// JᵀJ + λ diag and Jᵀe, without what is held, in place of other equations.
    pub fn damp(&self, damping: T, damped: &mut Equations<T>) {
        damped.clone_from(&self.equations);
        for k in 0..self.unknowns() {
            let diagonal = self.equations.matrix().get(packed_index(k, k)).copied().unwrap_or_else(T::zero);
            // Something of its own for an unknown that nothing depends on.
            damped.add_to_entry(k, k, diagonal * damping + T::of(1e-9));
        }
        if let Some(held) = self.held {
            damped.hold(held);
        }
    }

    /// A solution shortened to what a step may be; `None` where it is no number.
    pub fn limited(mut step: [T; MAX_UNKNOWNS]) -> Option<[T; MAX_UNKNOWNS]> {
        let mut shorter = T::one();
        for (k, x) in step.iter().enumerate().take(HINGE_UNKNOWNS) {
            let limit = T::of(if is_direction(k) { MAX_TURN } else { MAX_MOVE_MM });
            if x.abs() > limit {
                shorter = shorter.min(limit / x.abs());
            }
        }
        step.iter_mut().for_each(|x| *x *= shorter);
        step.iter().all(|x| x.is_a_number()).then_some(step)
    }

    /// Moves all unknowns by a step.
    pub fn take(&mut self, step: &[T; MAX_UNKNOWNS]) {
        self.hinge = self.hinge.moved(step);
        if self.constants {
            let mut values: [T; MAX_CONSTANTS] = *self.machine.values();
            let steps = step.iter().skip(HINGE_UNKNOWNS).take(self.machine.constants().len());
            values.iter_mut().zip(steps).for_each(|(value, step)| *value += *step);
            self.machine.set_values(values);
        }
    }

    /// The present estimate: the hinge, and the machine's constants.
    pub fn estimate(&self) -> Estimate<T> {
        (self.hinge, *self.machine.values())
    }

    /// To another estimate.
    pub fn set_estimate(&mut self, (hinge, values): Estimate<T>) {
        self.hinge = hinge;
        self.machine.set_values(values);
    }
}

/// Takes the angles on trial.
pub(super) fn take_angles<T: Real>(poses: &mut [HingePose<T>]) {
    poses.iter_mut().for_each(|pose| pose.angle_rad = pose.trial_rad);
}
