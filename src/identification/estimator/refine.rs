//! Gauss-Newton, pass by pass, and what comes after each.

use super::excite::Purpose;
use super::fit::{Fit, Pass};
use super::{MIN_POSES_AFTER_REJECTION, Next};
use crate::identification::gates::{MIN_POSES, migration_or_outliers};
use crate::identification::joint::{Joint, MIN_MOVING_POSES};
use crate::identification::machine::Machine;
use crate::identification::noise::POSES_TO_ESTIMATE;
use crate::identification::pose::Pose;
use crate::identification::refusal::Refusal;
use crate::identification::settings::{JointChoice, Noise};
use crate::identification::statistics::{MEDIAN_OF_CHI_SQUARE_3, MedianSearch, count_within};
use crate::identification::weights::{FINAL_SCALE, INLIER_LIMIT, SCALE_STEP, Weights};
use crate::linear_algebra::Singular;
use crate::scalar::Real;

/// A χ² this many times the median is an outlier whatever the noise.
const STANDS_OUT: f64 = 40.0;

/// χ² beyond which a pose may stand in the wrong assembly mode, and is re-initialised.
const REINITIALISE_ABOVE: f64 = 100.0;

/// Passes with equal weights before outliers are looked for.
const MAX_EQUAL_PASSES: u8 = 4;

/// The same when the machine has unknown constants: offsets of ±10 mm settle in six to eight passes.
const MAX_EQUAL_PASSES_WITH_PARAMETERS: u8 = 10;

/// Where the median of χ² stays so many times above the scale of the weights, more than half of the poses have lost theirs:
/// a ball with few outliers keeps most (`cargo study outliers` judges it).
const MAJORITY_LOST: f64 = 8.0;

/// Passes with each pose in or out. A selection that has not settled by then is refused as a ball.
const MAX_INLIER_PASSES: u8 = 8;

/// Passes of a joint that moves or scatters in which the scatter follows the median of χ², which outliers do not move.
pub(super) const MEDIAN_PASSES: u8 = 3;

/// Passes that measure the scatter of the poses' own centres.
const OWN_CENTRE_PASSES: u8 = 2;

/// A pass to be made.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plan<T> {
    pub(super) weights: Weights<T>,
    /// Passes with these weights, the present one included.
    pub(super) passes: u8,
    /// χ² beyond which the pass re-initialises a pose. Infinite where it re-initialises none.
    reinitialise_above: T,
    /// Poses have been re-initialised after convergence: at most once a run.
    reinitialised: bool,
    /// Poses used in the pass before.
    used_before: usize,
}

/// Gauss-Newton, the pass under way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Refine<T> {
    plan: Plan<T>,
    pass: Pass<T>,
    step: Step<T>,
}

/// A pass step by step.
#[derive(Clone, Copy, Debug)]
#[repr(u32)]
enum Step<T> {
    /// The equations are to be empty.
    Begin,
    /// The poses are summed.
    Sum,
    /// The normal equations are factored.
    Factor,
    /// They are solved, then the step is taken.
    Solve,
    /// Its residuals are kept; the median of χ² is sought.
    Median { largest_mm: T, search: MedianSearch<T> },
}

impl<T: Real> Refine<T> {
    /// Begins a pass.
    pub fn new(plan: Plan<T>) -> Self {
        Self { plan, pass: Pass::default(), step: Step::Begin }
    }

    /// One slice of a pass.
    pub fn advance(&mut self, fit: &mut Fit<T>, machine: &Machine<T>, poses: &mut [Pose<T>]) -> Option<Next<T>> {
        let Self { plan, pass, step } = self;
        match step {
            Step::Begin => {
                fit.begin_pass();
                *step = Step::Sum;
                None
            }
            Step::Sum => {
                if !fit.add_next_pose(pass, machine, poses, &plan.weights, plan.reinitialise_above) {
                    *step = Step::Factor;
                }
                None
            }
            Step::Factor => match fit.factor() {
                Ok(false) => None,
                Ok(true) => {
                    fit.begin_step();
                    *step = Step::Solve;
                    None
                }
                Err(Singular) => Some(plan.after_singular(fit, poses)),
            },
            Step::Solve if !fit.solve() => None,
            Step::Solve => {
                let largest_mm = fit.take_step(machine, pass);
                *step = Step::Median { largest_mm, search: MedianSearch::new(poses) };
                None
            }
            Step::Median { largest_mm, search } => {
                fit.residuals.chi_squares = search.advance(poses)?;
                if fit.result.rms_residuals_mm.push(fit.result.rms_residual_mm).is_err() {
                    return Some(Next::Done(Err(Refusal::IterationCap)));
                }
                let settled = *largest_mm <= fit.settings.tolerance_mm;
                Some(match fit.joint {
                    Joint::Ball => plan.after_pass(fit, poses, settled),
                    Joint::Held(_) | Joint::Moving(_) => plan.after_moving_pass(fit, poses, pass, settled),
                })
            }
        }
    }
}

impl<T: Real> Plan<T> {
    /// The first pass with these weights.
    pub fn new(fit: &mut Fit<T>, weights: Weights<T>, reinitialised: bool) -> Self {
        if let Weights::OwnCentres { .. } = weights {
            fit.estimate.hold();
        }
        Self {
            weights,
            passes: 1,
            reinitialise_above: Self::reinitialise_above(&weights, 1),
            reinitialised,
            used_before: 0,
        }
    }

    /// As if so many passes had been made already.
    pub(super) fn after(self, passes: u8) -> Self {
        Self { passes: self.passes + passes, ..self }
    }

    /// A pose that fits nothing may stand in the wrong assembly mode: it is re-initialised from the known centre.
    fn reinitialise_above(weights: &Weights<T>, passes: u8) -> T {
        match weights {
            Weights::Inliers(_) if passes <= 1 => T::of(REINITIALISE_ABOVE),
            _ => T::of(f64::INFINITY),
        }
    }

    /// What follows a pass of the ball model.
    fn after_pass(&self, fit: &mut Fit<T>, poses: &[Pose<T>], settled: bool) -> Next<T> {
        let residuals = &fit.residuals;
        let noise = fit.settings.noise;
        match self.weights {
            Weights::Equal => {
                if settled && residuals.used == poses.len() && residuals.are_noise(noise, poses.len()) {
                    return self.converged(fit, poses);
                }
                // An outlier with large leverage would pull the next passes off: weight it down at once.
                if settled || stands_out(fit) || self.passes > max_equal_passes(fit) {
                    let scale = first_scale(fit, poses.len());
                    return self.weight_down(fit, scale);
                }
            }
            Weights::GemanMcClure(scale) => {
                // A centre that moves needs no more passes to be no ball.
                let may_move = fit.settings.joint == JointChoice::Auto && poses.len() >= MIN_MOVING_POSES;
                if may_move && residuals.chi_squares.median > scale * T::of(MAJORITY_LOST) {
                    return measure_migration(poses);
                }
                // The median of fewer poses is too coarse to estimate the noise again.
                let shrinks = poses.len() >= POSES_TO_ESTIMATE && estimate_noise(fit, poses.len());
                if !shrinks && scale <= T::of(FINAL_SCALE) {
                    return Next::Refine(Self::new(fit, Weights::Inliers(T::of(INLIER_LIMIT)), self.reinitialised));
                }
                if !shrinks {
                    return self.weight_down(fit, scale * T::of(SCALE_STEP));
                }
            }
            Weights::Inliers(_) => {
                if settled && residuals.used == self.used_before {
                    return self.judge_inliers(fit, poses);
                }
                if self.passes > MAX_INLIER_PASSES {
                    return measure_migration(poses);
                }
            }
            Weights::OwnCentres { rejected } if self.passes >= OWN_CENTRE_PASSES => {
                let variance = residuals.squares_mm2 / residuals.freedom;
                let refusal = migration_or_outliers(variance, residuals.chi_squares.median, rejected, poses.len());
                return after_ball_refused(fit, refusal, poses.len());
            }
            Weights::OwnCentres { .. } | Weights::Without { .. } => {}
        }
        self.again(fit)
    }

    /// Another pass with the same weights.
    pub(super) fn again(&self, fit: &mut Fit<T>) -> Next<T> {
        let passes = self.passes.saturating_add(1);
        Next::Refine(Self {
            passes,
            reinitialise_above: Self::reinitialise_above(&self.weights, passes),
            used_before: fit.residuals.used,
            ..*self
        })
    }

    /// The same poses took part in the last two passes.
    pub(super) fn is_selection_stable(&self, fit: &Fit<T>) -> bool {
        fit.residuals.used == self.used_before
    }

    /// Starts a Geman-McClure pass with this scale (not below the final one).
    fn weight_down(&self, fit: &mut Fit<T>, scale: T) -> Next<T> {
        let weights = Weights::GemanMcClure(scale.max(T::of(FINAL_SCALE)));
        Next::Refine(Self::new(fit, weights, self.reinitialised))
    }

    /// Near a singularity two assembly modes fit to within the noise. Where the residuals of the other poses vanish
    /// (noise-free lengths), one in the wrong mode stands out though it is no outlier: such poses are re-initialised
    /// once from the known centre.
    fn converged(&self, fit: &mut Fit<T>, poses: &[Pose<T>]) -> Next<T> {
        let limit = fit.residuals.chi_squares.median * T::of(STANDS_OUT);
        if self.reinitialised || count_within(poses, limit) >= fit.residuals.used {
            return Next::Excite(Purpose::Accept);
        }
        Next::Refine(Self {
            passes: self.passes.saturating_add(1),
            reinitialise_above: limit,
            reinitialised: true,
            used_before: fit.residuals.used,
            ..*self
        })
    }

    /// After the selection: are enough poses left, and are their residuals noise?
    fn judge_inliers(&self, fit: &mut Fit<T>, poses: &[Pose<T>]) -> Next<T> {
        let used = fit.residuals.used;
        if !is_selection_large_enough(used, poses.len())
            || !fit.residuals.of_inliers_are_noise(fit.settings.noise, poses.len())
            || fit.residuals.narrowly_out_are_no_noise(fit.settings.noise, poses)
        {
            return measure_migration(poses);
        }
        self.converged(fit, poses)
    }

    /// The equations of a pass have no solution.
    fn after_singular(&self, fit: &mut Fit<T>, poses: &[Pose<T>]) -> Next<T> {
        match (&fit.joint, self.weights) {
            (Joint::Held(_) | Joint::Moving(_), _) => Next::Done(Err(fit.ball_refusal.unwrap_or(Refusal::Singular))),
            (_, Weights::Equal) => Next::Excite(Purpose::NameWhatIsSingular),
            (_, Weights::OwnCentres { rejected }) => {
                let (rejected, poses) = (rejected as u32, poses.len() as u32);
                Next::Done(Err(Refusal::TooManyOutliers { rejected, poses }))
            }
            // Hardly any pose agrees with another.
            _ => measure_migration(poses),
        }
    }
}

/// Enough poses are left of those given, at most a fifth is left out.
fn is_selection_large_enough(used: usize, poses: usize) -> bool {
    let rejected = poses - used;
    let least = if rejected > 0 { MIN_POSES_AFTER_REJECTION } else { MIN_POSES };
    rejected * 5 <= poses && used >= least
}

/// The set is refused as a ball; decide between outliers and a joint centre that is not fixed.
fn measure_migration<T: Real>(poses: &[Pose<T>]) -> Next<T> {
    let rejected = poses.len() - count_within(poses, T::of(INLIER_LIMIT));
    Next::Excite(Purpose::MeasureMigration { rejected })
}

/// Is the largest χ² far beyond the median, and beyond noise?
fn stands_out<T: Real>(fit: &Fit<T>) -> bool {
    let chi_squares = &fit.residuals.chi_squares;
    chi_squares.worst > chi_squares.median.max(T::of(MEDIAN_OF_CHI_SQUARE_3)) * T::of(STANDS_OUT)
}

/// First scale of the Geman-McClure weights; with an unknown noise, its robust estimate too.
fn first_scale<T: Real>(fit: &mut Fit<T>, poses: usize) -> T {
    if let Noise::EstimatedUpTo(_) = fit.settings.noise {
        estimate_noise(fit, poses);
        return T::of(8.0 * FINAL_SCALE);
    }
    fit.residuals.chi_squares.median * T::of(3.0)
}

/// Estimates an unknown noise from the median χ². Outliers raise all χ² until they are weighted down, so the first
/// estimates are too large: true while the estimate falls by more than a fifth.
fn estimate_noise<T: Real>(fit: &mut Fit<T>, poses: usize) -> bool {
    let Noise::EstimatedUpTo(_) = fit.settings.noise else { return false };
    let before = fit.residuals.noise_mm;
    fit.residuals.noise_mm = fit.residuals.estimated_noise_mm(fit.settings.noise, poses);
    fit.residuals.noise_mm < before * T::of(0.8)
}

/// Passes with equal weights: more when the machine has unknown constants, which take more steps to find.
fn max_equal_passes<T: Real>(fit: &Fit<T>) -> u8 {
    if fit.parameters() > 0 { MAX_EQUAL_PASSES_WITH_PARAMETERS } else { MAX_EQUAL_PASSES }
}

/// The ball does not explain the residuals: the moving centre may, if there are poses enough for it.
fn after_ball_refused<T: Real>(fit: &mut Fit<T>, refusal: Refusal, poses: usize) -> Next<T> {
    fit.ball_refusal = Some(refusal);
    if fit.settings.joint == JointChoice::Auto && poses >= MIN_MOVING_POSES {
        return Next::Excite(Purpose::MovingCentre);
    }
    Next::Done(Err(refusal))
}
