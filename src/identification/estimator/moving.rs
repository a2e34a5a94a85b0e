//! Gauss-Newton with a joint centre that moves or scatters: the variance of the scatter is estimated on the way.

use super::Next;
use super::fit::{Fit, Pass};
use super::refine::{MEDIAN_PASSES, Plan};
use super::result::Accepted;
use crate::identification::joint::Joint;
use crate::identification::machine::Machine;
use crate::identification::parameters::{CENTRE_UNKNOWNS, MAX_UNKNOWNS};
use crate::identification::pose::Pose;
use crate::identification::refusal::Refusal;
use crate::identification::statistics::{MEDIAN_OF_CHI_SQUARE_3, count_within};
use crate::identification::weights::Weights;
use crate::scalar::Real;

/// χ², scatter included, beyond which a pose is left out: once in 6 000 sound poses.
const INLIER_LIMIT: f64 = 20.0;

/// Passes after those that follow the median, in which the scatter follows the sum of χ²; three to five suffice.
const MAX_PASSES: u8 = 12;

/// Largest relative change of the scatter's variance that counts as converged.
const SETTLED_SCATTER: f64 = 0.01;

/// At most one pose in so many is left out; with more, the model is at fault.
const MAX_LEFT_OUT: usize = 8;

impl<T: Real> Fit<T> {
    /// Begins Gauss-Newton with a joint whose centre scatters, from the present centre.
    pub(super) fn begin_scattered(&mut self, machine: &Machine<T>, joint: Joint<T>) -> Next<T> {
        self.joint = joint;
        self.estimate.release();
        if self.parameters() + CENTRE_UNKNOWNS > MAX_UNKNOWNS {
            // A moving joint on a machine of which every end is uncertain: more unknowns than there is room for.
            return Next::Done(Err(self.ball_refusal.unwrap_or(Refusal::Singular)));
        }
        self.residuals.noise_mm = machine.noise_mm().min(self.residuals.noise_mm);
        self.result.rms_residuals_mm.clear();
        Next::Refine(Plan::new(self, Weights::Equal, true))
    }
}

impl<T: Real> Fit<T> {
    /// Accepts held poses with a common centre.
    fn judge_held(&self, scatter_mm: T) -> Next<T> {
        if !self.joint.is_held_still() {
            return Next::Done(Err(Refusal::NotHeld { scatter_mm: scatter_mm.to_f32() }));
        }
        Next::Check(Accepted::Moving)
    }
}

impl<T: Real> Plan<T> {
    /// Goes on with a joint that moves or scatters, each pose in or out.
    pub(super) fn select(fit: &mut Fit<T>) -> Self {
        Self::new(fit, Weights::Inliers(T::of(INLIER_LIMIT)), true)
    }

    /// What follows a pass of the moving centre's model.
    pub(super) fn after_moving_pass(
        &self,
        fit: &mut Fit<T>,
        poses: &[Pose<T>],
        pass: &Pass<T>,
        settled: bool,
    ) -> Next<T> {
        let variance = fit.variance_mm2();
        let (median, residuals) = (fit.residuals.chi_squares.median, fit.residuals);
        let Some(scatter) = fit.joint.scatter_mut() else { return self.again(fit) };
        if let (Weights::Equal, true) = (self.weights, self.passes <= MEDIAN_PASSES) {
            scatter.follow_median(median / T::of(MEDIAN_OF_CHI_SQUARE_3));
            if self.passes < MEDIAN_PASSES {
                return self.again(fit);
            }
            return match &fit.joint {
                Joint::Moving(_) if !fit.is_compared => Next::Compare,
                _ => Next::Refine(Self::select(fit)),
            };
        }
        let excess = residuals.squares_mm2 / variance - residuals.freedom;
        let change = scatter.improve(excess, pass.squared_gradients / (variance * variance));
        let left_out = poses.len() - count_within(poses, T::of(INLIER_LIMIT));
        let is_too_many = left_out > (poses.len() / MAX_LEFT_OUT).max(1);
        let is_stable = settled && change < T::of(SETTLED_SCATTER) && self.is_selection_stable(fit);
        match self.weights {
            Weights::Inliers(_) if is_too_many && self.passes > 2 && fit.joint.is_held_still() => {
                let (rejected, poses) = (left_out as u32, poses.len() as u32);
                Next::Done(Err(Refusal::TooManyOutliers { rejected, poses }))
            }
            Weights::Inliers(_) if is_too_many && self.passes > 2 => {
                // It is not a few poses: fit all of them, and let the scatter show it.
                Next::Refine(Self::new(fit, Weights::Equal, true).after(MEDIAN_PASSES))
            }
            _ if is_stable => match &fit.joint {
                Joint::Held(scatter) => fit.judge_held(scatter.sigma_mm()),
                _ => Next::Inspect,
            },
            _ if self.passes >= MAX_PASSES + MEDIAN_PASSES => {
                Next::Done(Err(fit.ball_refusal.unwrap_or(Refusal::IterationCap)))
            }
            _ => self.again(fit),
        }
    }
}
