//! From one candidate: the poses that contradict the others are weighted down until they stand out, and left out.

use super::work::{Candidate, Work};
use crate::identification::hinge::judge;
use crate::identification::hinge::pose::HingePose;
use crate::identification::hinge::refusal::HingeRefusal;
use crate::identification::weights::FINAL_SCALE;
use crate::scalar::Real;

/// Steps of the fit in a pass of weights, and once the weights stand.
const PASS_TRIALS: usize = 12;
const LAST_TRIALS: usize = 20;
/// Passes of weights at most, and rounds with each pose in or out.
const MAX_PASSES: usize = 30;
const ROUNDS: usize = 3;
/// The scale of the weights is lowered by this factor a pass: a hinge has weak directions, and follows slowly.
const SCALE_STEP: f64 = 0.5;

/// One attempt under way.
#[derive(Clone, Copy, Debug)]
pub struct LeaveOut<T> {
    scale: T,
    step: Step,
}

#[derive(Clone, Copy, Debug)]
enum Step {
    /// All poses count alike.
    Equal,
    /// So many passes of weights were made.
    Weighted(usize),
    /// So many rounds with each pose in or out.
    Selected(usize),
}

impl<T: Real> LeaveOut<T> {
    /// From this candidate, all poses counting alike.
    pub fn from(candidate: &Candidate<T>, work: &mut Work<T>, poses: &mut [HingePose<T>]) -> Self {
        poses.iter_mut().for_each(|pose| pose.weight = T::one());
        work.go_to(candidate);
        Self { scale: T::zero(), step: Step::Equal }
    }

    /// What follows the last minimisation; the outcome at the end: [`HingeRefusal::TooManyOutliers`] when more than a
    /// fifth of the poses would have to be left out.
    pub fn advance(&mut self, work: &mut Work<T>, poses: &mut [HingePose<T>]) -> Option<Result<(), HingeRefusal>> {
        match self.step {
            Step::Equal => {
                self.scale = poses.iter().fold(T::of(FINAL_SCALE), |worst, pose| worst.max(pose.chi_square));
                self.weigh(0, work, poses);
            }
            Step::Weighted(passes) if self.scale > T::of(FINAL_SCALE) && passes < MAX_PASSES => {
                self.scale = (self.scale * T::of(SCALE_STEP)).max(T::of(FINAL_SCALE));
                self.weigh(passes, work, poses);
            }
            Step::Weighted(_) => return self.select(0, work, poses),
            Step::Selected(rounds) if rounds < ROUNDS => return self.select(rounds, work, poses),
            Step::Selected(_) => return Some(Ok(())),
        }
        None
    }

    fn weigh(&mut self, passes: usize, work: &mut Work<T>, poses: &mut [HingePose<T>]) {
        for pose in poses {
            let root = self.scale / (self.scale + pose.chi_square);
            pose.weight = root * root;
        }
        work.minimise_and_settle(PASS_TRIALS, false);
        self.step = Step::Weighted(passes + 1);
    }

    fn select(
        &mut self,
        rounds: usize,
        work: &mut Work<T>,
        poses: &mut [HingePose<T>],
    ) -> Option<Result<(), HingeRefusal>> {
        let limit = judge::inlier_limit::<T>(work.fit.machine.cables());
        for pose in poses.iter_mut() {
            pose.weight = if pose.chi_square <= limit { T::one() } else { T::zero() };
        }
        if let Err(too_many) = judge::require_most(poses) {
            return Some(Err(too_many));
        }
        work.minimise_and_settle(LAST_TRIALS, false);
        self.step = Step::Selected(rounds + 1);
        None
    }
}
