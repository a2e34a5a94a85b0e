//! Is the covariance true? A hinge is not linear in its unknowns: where the valley of χ² bends, another hinge beyond five
//! standard deviations fits nearly as well.
//!
//! The profile of χ² answers it (Bates and Watts 1988, section 6.1): each unknown in turn is held 5 σ to either side of its
//! estimate, and all others are fitted anew. A linear problem leaves 25 more there.

use super::work::Work;
use crate::identification::hinge::fit::Solve;
use crate::identification::hinge::joint::HINGE_UNKNOWNS;
use crate::identification::hinge::judge;
use crate::identification::hinge::refusal::HingeRefusal;
use crate::scalar::Real;

/// Where the profile is looked at, standard deviations.
const AT: f64 = 5.0;
/// Smallest rise of χ², over that of a linear problem.
const MIN_RISE: f64 = 0.5;
/// Steps of the fit at each place.
const TRIALS: usize = 12;

/// The profile under way.
#[derive(Clone, Copy, Debug)]
pub struct Profile<T> {
    unknown: usize,
    /// Below the estimate; above it comes first.
    is_below: bool,
    step: Step<T>,
}

#[derive(Clone, Copy, Debug)]
enum Step<T> {
    /// The finished fit is to be kept.
    Begin,
    /// How all unknowns follow one, and that one is moved; they have followed.
    Solve(Solve<T>),
    HasFollowed,
    /// The finished fit is there again.
    Return(Result<(), HingeRefusal>),
}

impl<T: Real> Step<T> {
    fn solve(unknown: usize) -> Self {
        Self::Solve(Solve::column(unknown))
    }
}

impl<T: Real> Profile<T> {
    /// At the beginning.
    pub const fn new() -> Self {
        Self { unknown: 0, is_below: false, step: Step::Begin }
    }

    /// What follows the last minimisation; the outcome at the end: [`HingeRefusal::TwoAxesFit`] where another hinge, about
    /// 5 σ away, fits nearly as well.
    pub fn advance(&mut self, work: &mut Work<T>) -> Option<Result<(), HingeRefusal>> {
        match &mut self.step {
            Step::Begin => {
                work.keep();
                self.step = Step::solve(0);
            }
            Step::Solve(_) if self.unknown >= HINGE_UNKNOWNS => self.finish(work, Ok(())),
            Step::Solve(solve) => {
                // How all unknowns follow this one on average.
                let column = solve.advance(&work.kept.equations)?;
                let noise_mm = work.found.noise_mm;
                let sigma = work.found.sigma(self.unknown);
                let side = if self.is_below { -T::of(AT) } else { T::of(AT) };
                let follow = column.map(|entry| entry * noise_mm * noise_mm / sigma);
                work.fit.held = Some(self.unknown);
                work.fit.take(&follow.map(|entry| entry * side));
                work.minimise(TRIALS, false);
                self.step = Step::HasFollowed;
            }
            Step::HasFollowed => self.judge(work),
            Step::Return(outcome) => return Some(*outcome),
        }
        None
    }

    fn judge(&mut self, work: &mut Work<T>) {
        let (other, squares_mm2) = (work.fit.hinge, work.fit.squares_mm2);
        work.fit.held = None;
        work.fit.set_estimate(work.kept.estimate);
        let found = &work.found;
        let difference = found.hinge.difference(&other);
        let deviations = difference.get(self.unknown).copied().unwrap_or_else(T::zero) / found.sigma(self.unknown);
        let rise = (squares_mm2 - work.kept.squares_mm2) / (found.noise_mm * found.noise_mm);
        // Also refuses NaN.
        if !(rise >= T::of(MIN_RISE) * deviations * deviations) {
            let two_axes = judge::two_axes(&work.fit, &work.fit.hinge, &other);
            return self.finish(work, Err(two_axes));
        }
        self.unknown += usize::from(self.is_below);
        self.is_below = !self.is_below;
        self.step = Step::solve(self.unknown);
    }

    fn finish(&mut self, work: &mut Work<T>, outcome: Result<(), HingeRefusal>) {
        work.return_to_kept();
        self.step = Step::Return(outcome);
    }
}
