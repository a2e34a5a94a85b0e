//! Levenberg-Marquardt on the hinge and the machine's constants, the angle eliminated pose by pose.

use super::joint::{HINGE_UNKNOWNS, Hinge, is_direction};
use super::machine::{HingeMachine, MAX_CONSTANTS};
use super::pose::{AngleSearch, HingePose, MAX_UNKNOWNS, PoseAt};
use super::rig::{Drawing, HingeRig};
use crate::linear_algebra::{NormalEquations, Singular};
use crate::scalar::Real;

/// Entries of the packed normal matrix.
const PACKED: usize = MAX_UNKNOWNS * (MAX_UNKNOWNS + 1) / 2;
/// The normal equations of a hinge.
pub(super) type Equations<T> = NormalEquations<T, MAX_UNKNOWNS, PACKED>;

/// Damping at first, and beyond which no step helps.
const FIRST_DAMPING: f64 = 1e-2;
const LAST_DAMPING: f64 = 1e6;
/// Damping after a good step, and after a bad one, over what it was.
const LESS_DAMPING: f64 = 0.2;
const MORE_DAMPING: f64 = 4.0;
/// Largest step of a direction, rad, and of a place, mm.
const MAX_TURN: f64 = 0.5;
const MAX_MOVE_MM: f64 = 60.0;
/// Trials from a start of nobody's in which the angles are searched anew: the hinge still moves far.
const SEARCHING_TRIALS: usize = 6;
/// Gauss-Newton rounds for the angle of one pose, from where it was searched, and from its last value.
const SEARCHED_ROUNDS: usize = 4;
const NEXT_ROUNDS: usize = 2;

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
    /// At the present estimate, factored by [`Fit::finish`].
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

    /// Gives every pose its best angle at this estimate, searched for or from the last one, and sums the squares. The
    /// angles stay on trial.
    pub fn place(&self, poses: &mut [HingePose<T>], search: bool) -> T {
        let at = PoseAt::new(&self.hinge, &self.machine);
        let search = search.then(|| AngleSearch::new(&self.hinge, &self.machine, self.range_rad()));
        let rounds = if search.is_some() { SEARCHED_ROUNDS } else { NEXT_ROUNDS };
        let mut squares = self.prior_squares();
        for pose in poses {
            let from = match &search {
                Some(search) => search.nearest_rad(&pose.lengths_mm, self.machine.cables()),
                None => pose.angle_rad,
            };
            let (angle, left) = at.best_angle(&pose.lengths_mm, from, rounds);
            pose.trial_rad = angle;
            squares += left * pose.weight;
        }
        squares
    }

    /// Takes the angles on trial, and writes the poses' χ².
    pub fn settle(&mut self, poses: &mut [HingePose<T>]) {
        let at = PoseAt::new(&self.hinge, &self.machine);
        for pose in poses {
            let (angle, left) = at.best_angle(&pose.lengths_mm, pose.trial_rad, 1);
            pose.angle_rad = angle;
            pose.chi_square = left / (self.noise_mm * self.noise_mm);
        }
    }

    fn prior_squares(&self) -> T {
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

    /// The normal equations at the present estimate and angles.
    pub fn equate(&mut self, poses: &[HingePose<T>]) {
        let unknowns = self.unknowns();
        self.equations.clear(unknowns);
        let at = PoseAt::new(&self.hinge, &self.machine);
        for pose in poses.iter().filter(|pose| pose.is_used()) {
            let mut rows = at.rows(&pose.lengths_mm, pose.angle_rad, self.constants);
            let by_angle = rows.by_angle;
            rows.eliminate(&by_angle, unknowns);
            let weight = pose.weight.root();
            for (row, residual) in rows.jacobian.iter_mut().zip(&rows.residual_mm).take(self.machine.cables()) {
                row.iter_mut().for_each(|entry| *entry *= weight);
                self.equations.add_row(row, *residual * weight);
            }
        }
        self.add_priors();
    }

    fn add_priors(&mut self) {
        let mut row = [T::zero(); MAX_UNKNOWNS];
        if let Some(Drawing { hinge: drawn, sigma: Some(sigma), .. }) = &self.drawing {
            let difference = drawn.difference(&self.hinge);
            let jacobian = drawn.difference_jacobian(&self.hinge);
            for (i, (value, sigma)) in difference.iter().zip(sigma).enumerate() {
                let scale = self.noise_mm / *sigma;
                for (j, entry) in row.iter_mut().enumerate().take(HINGE_UNKNOWNS) {
                    *entry = jacobian.get((i, j)).copied().unwrap_or_else(T::zero) * scale;
                }
                self.equations.add_row(&row, -*value * scale);
            }
        }
        if !self.constants {
            return;
        }
        for (k, ((_, sigma), value)) in self.machine.constants().iter().zip(self.machine.values()).enumerate() {
            let precision = (self.noise_mm / *sigma) * (self.noise_mm / *sigma);
            self.equations.add_to_entry(HINGE_UNKNOWNS + k, HINGE_UNKNOWNS + k, precision);
            self.equations.add_to_gradient(HINGE_UNKNOWNS + k, -*value * precision);
        }
    }

    /// Minimises the squares, at most `trials` steps. `search`: the poses' angles are not known yet.
    pub fn minimise(&mut self, poses: &mut [HingePose<T>], trials: usize, search: bool) {
        self.squares_mm2 = self.place(poses, search);
        self.take_angles(poses);
        let variance = self.noise_mm * self.noise_mm;
        // A gain below this moves nothing by a noticeable part of its standard deviation.
        let enough = variance * T::default_epsilon().root();
        let mut damping = T::of(FIRST_DAMPING);
        self.equate(poses);
        for trial in 0..trials {
            let Some(step) = self.damped_step(damping) else {
                damping *= T::of(MORE_DAMPING);
                if damping > T::of(LAST_DAMPING) {
                    return;
                }
                continue;
            };
            let before = (self.hinge, *self.machine.values());
            self.take(&step);
            let squares = self.place(poses, search && trial < SEARCHING_TRIALS);
            // Also refuses NaN.
            if squares < self.squares_mm2 {
                let gain = self.squares_mm2 - squares;
                self.squares_mm2 = squares;
                self.take_angles(poses);
                self.equate(poses);
                if gain <= enough + squares * T::default_epsilon() {
                    return;
                }
                damping = (damping * T::of(LESS_DAMPING)).max(T::default_epsilon());
            } else {
                self.hinge = before.0;
                self.machine.set_values(before.1);
                damping *= T::of(MORE_DAMPING);
                if damping > T::of(LAST_DAMPING) || squares - self.squares_mm2 <= enough * T::of(1e-2) {
                    return;
                }
            }
        }
    }

    fn take_angles(&self, poses: &mut [HingePose<T>]) {
        poses.iter_mut().for_each(|pose| pose.angle_rad = pose.trial_rad);
    }

    /// (JᵀJ + λ diag) x = Jᵀe, shortened to what a step may be; `None` where it has no solution.
    fn damped_step(&self, damping: T) -> Option<[T; MAX_UNKNOWNS]> {
        let mut damped = self.equations;
        for k in 0..self.unknowns() {
            let diagonal = self.equations.matrix().get(crate::linear_algebra::packed_index(k, k)).copied()?;
            // Something of its own for an unknown that nothing depends on.
            damped.add_to_entry(k, k, diagonal * damping + T::of(1e-9));
        }
        if let Some(held) = self.held {
            damped.hold(held);
        }
        damped.factor().ok()?;
        let mut step = damped.step();
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

    /// The last, undamped step; then the equations are factored for the covariance, and the poses have their χ².
    ///
    /// # Errors
    /// [`Singular`] when some combination of the unknowns is not determined.
    pub fn finish(&mut self, poses: &mut [HingePose<T>]) -> Result<(), Singular> {
        self.equate(poses);
        self.equations.factor()?;
        let step = self.equations.step();
        let before = (self.hinge, *self.machine.values());
        self.take(&step);
        let squares = self.place(poses, false);
        if squares <= self.squares_mm2 + self.noise_mm * self.noise_mm * T::of(0.01) {
            self.squares_mm2 = squares;
            self.take_angles(poses);
        } else {
            self.hinge = before.0;
            self.machine.set_values(before.1);
            self.place(poses, false);
        }
        self.settle(poses);
        self.equate(poses);
        self.equations.factor()
    }
}
