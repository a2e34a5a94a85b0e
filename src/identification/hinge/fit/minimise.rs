//! Levenberg-Marquardt, slice by slice.

use super::equate::Equate;
use super::place::Place;
use super::scratch::{PRODUCTS_A_SLICE, Scratch};
use super::solve::Solve;
use super::{Estimate, Fit, take_angles};
use crate::identification::hinge::pose::HingePose;
use crate::linear_algebra::Singular;
use crate::scalar::Real;

/// Damping at first, and beyond which no step helps.
const FIRST_DAMPING: f64 = 1e-2;
const LAST_DAMPING: f64 = 1e6;
/// Damping after a good step, and after a bad one, over what it was.
const LESS_DAMPING: f64 = 0.2;
const MORE_DAMPING: f64 = 4.0;
/// Trials from a start of nobody's in which the angles are searched anew: the hinge still moves far.
const SEARCHING_TRIALS: usize = 6;

/// The minimisation of the squares under way.
#[derive(Clone, Debug)]
pub struct Minimise<T: Real> {
    /// Most steps that are tried, and those tried so far.
    trials: usize,
    trial: usize,
    /// The poses' angles are not known yet.
    search: bool,
    damping: T,
    step: Step<T>,
}

#[derive(Clone, Debug)]
enum Step<T: Real> {
    /// The poses' angles where it begins.
    Begin(Place<T>),
    /// The equations for the next step; `is_last`: for nothing more.
    Equate {
        equate: Equate,
        is_last: bool,
    },
    /// The damped ones are factored, solved, and the step is taken.
    Factor,
    Solve(Solve<T>),
    /// The poses' angles after a step from this estimate.
    Try {
        before: Estimate<T>,
        place: Place<T>,
    },
}

impl<T: Real> Minimise<T> {
    /// Before the first step. `search`: the poses' angles are not known yet.
    pub fn new(trials: usize, search: bool) -> Self {
        Self { trials, trial: 0, search, damping: T::of(FIRST_DAMPING), step: Step::Begin(Place::new(search)) }
    }

    /// One slice; true at the end.
    pub fn advance(&mut self, fit: &mut Fit<T>, scratch: &mut Scratch<T>, poses: &mut [HingePose<T>]) -> bool {
        match &mut self.step {
            Step::Begin(place) => {
                if let Some(squares) = place.advance(fit, &mut scratch.angles, poses) {
                    fit.squares_mm2 = squares;
                    take_angles(poses);
                    self.step = Step::Equate { equate: Equate::new(), is_last: false };
                }
                false
            }
            Step::Equate { equate, is_last } => {
                let is_last = *is_last;
                equate.advance(fit, &mut scratch.rows, poses) && (is_last || self.next_trial(fit, scratch))
            }
            Step::Factor if !scratch.equations.is_factored() => {
                scratch.equations.factor_some(PRODUCTS_A_SLICE) == Err(Singular) && self.more_damping(fit, scratch)
            }
            Step::Factor => {
                self.step = Step::Solve(Solve::new(*scratch.equations.gradient()));
                false
            }
            Step::Solve(solve) => {
                let Some(solution) = solve.advance(&scratch.equations) else { return false };
                let Some(step) = Fit::limited(*solution) else { return self.more_damping(fit, scratch) };
                let before = fit.estimate();
                fit.take(&step);
                let search = self.search && self.trial < SEARCHING_TRIALS;
                self.step = Step::Try { before, place: Place::new(search) };
                false
            }
            Step::Try { before, place } => {
                let Some(squares) = place.advance(fit, &mut scratch.angles, poses) else { return false };
                let before = *before;
                self.judge(fit, scratch, poses, before, squares)
            }
        }
    }

    /// Was the step a good one? True at the end.
    fn judge(
        &mut self,
        fit: &mut Fit<T>,
        scratch: &mut Scratch<T>,
        poses: &mut [HingePose<T>],
        before: Estimate<T>,
        squares: T,
    ) -> bool {
        // A gain below this moves nothing by a noticeable part of its standard deviation.
        let enough = fit.noise_mm * fit.noise_mm * T::default_epsilon().root();
        // Also refuses NaN.
        if squares < fit.squares_mm2 {
            let gain = fit.squares_mm2 - squares;
            fit.squares_mm2 = squares;
            take_angles(poses);
            let is_last = gain <= enough + squares * T::default_epsilon();
            self.step = Step::Equate { equate: Equate::new(), is_last };
            self.damping = (self.damping * T::of(LESS_DAMPING)).max(T::default_epsilon());
            self.trial += 1;
            return false;
        }
        fit.set_estimate(before);
        let no_step_gains = squares - fit.squares_mm2 <= enough * T::of(1e-2);
        self.more_damping(fit, scratch) || no_step_gains
    }

    /// After a bad step, or none. True at the end.
    fn more_damping(&mut self, fit: &Fit<T>, scratch: &mut Scratch<T>) -> bool {
        self.damping *= T::of(MORE_DAMPING);
        self.trial += 1;
        self.damping > T::of(LAST_DAMPING) || self.next_trial(fit, scratch)
    }

    /// Damps the equations for the next trial; true when there is none.
    fn next_trial(&mut self, fit: &Fit<T>, scratch: &mut Scratch<T>) -> bool {
        if self.trial >= self.trials {
            return true;
        }
        fit.damp(self.damping, &mut scratch.equations);
        self.step = Step::Factor;
        false
    }
}
