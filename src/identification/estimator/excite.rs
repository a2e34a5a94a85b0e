//! Rotational excitation, a few poses a slice: do the rotations of the poses determine the centre?

use super::Next;
use super::fit::Fit;
use super::refine::Plan;
use super::result::Accepted;
use crate::identification::excitation::{Excitation, MeanRotation};
use crate::identification::gates::{AxisMotion, require_excitation};
use crate::identification::joint::{ArmFrame, ArmMotion, Joint, MovingCentre};
use crate::identification::machine::Machine;
use crate::identification::pose::{Pose, PoseState};
use crate::identification::refusal::Refusal;
use crate::identification::weights::Weights;
use crate::scalar::Real;

/// Poses a slice; of a moving centre, where each takes an arc tangent and two rotations more.
const POSES_A_SLICE: usize = 16;
const POSES_A_SLICE_OF_ARM: usize = 4;

/// What the excitation is computed for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Purpose {
    /// The fit has converged: the last gates.
    Accept,
    /// The normal equations are singular; the rotations name the cause.
    NameWhatIsSingular,
    /// A moving centre is tried: the frame of its features, and enough motion for it.
    MovingCentre,
    /// The set is refused as a ball: decide between outliers and a centre that is not fixed.
    MeasureMigration {
        /// Poses beyond the inlier limit.
        rejected: usize,
    },
}

/// Two rounds over the poses: their mean rotation, then how far each moves the axis that all of them move least.
#[derive(Clone, Copy, Debug)]
pub(super) struct Excite<T> {
    purpose: Purpose,
    next: usize,
    mean: MeanRotation<T>,
    motion: Option<(Excitation<T>, AxisMotion<T>)>,
    /// For a moving centre: its frame, and how far the arm moves in it.
    arm: Option<(ArmFrame<T>, ArmMotion<T>)>,
}

impl<T: Real> Excite<T> {
    /// Begins.
    pub fn new(purpose: Purpose) -> Self {
        Self { purpose, next: 0, mean: MeanRotation::default(), motion: None, arm: None }
    }

    /// The next few poses.
    pub fn advance(&mut self, fit: &mut Fit<T>, machine: &Machine<T>, poses: &mut [Pose<T>]) -> Option<Next<T>> {
        let least = if self.purpose == Purpose::Accept { PoseState::Used } else { PoseState::Placed };
        // The steps before have diverged along the singular direction, and the rotations with them: place again.
        let has_diverged = self.purpose == Purpose::NameWhatIsSingular && self.motion.is_none();
        let poses_a_slice = match self.arm {
            _ if has_diverged => 1,
            Some(_) => POSES_A_SLICE_OF_ARM,
            None => POSES_A_SLICE,
        };
        let slice = poses.iter_mut().enumerate().skip(self.next).take(poses_a_slice);
        for (index, pose) in slice {
            if has_diverged {
                pose.reset();
                pose.place(machine.platform());
            }
            if pose.state < least {
                continue;
            }
            match &mut self.motion {
                None => self.mean.add(&pose.rotation()),
                Some((excitation, motion)) => motion.add(index, &pose.rotation(), excitation),
            }
            if let Some((frame, arm)) = &mut self.arm {
                let (tilt, torsion) = frame.tilt_and_torsion(&pose.rotation());
                arm.add(tilt, torsion);
            }
        }
        self.next += poses_a_slice;
        if self.next < poses.len() {
            return None;
        }
        match &self.motion {
            None => {
                self.motion = Some((self.mean.excitation(), AxisMotion::default()));
                if self.purpose == Purpose::MovingCentre {
                    self.arm = Some((ArmFrame::new(&self.mean), ArmMotion::default()));
                }
                self.next = 0;
                None
            }
            Some((excitation, motion)) => Some(match self.purpose {
                Purpose::MovingCentre => self.begin_moving(fit, machine, poses, excitation),
                _ => self.judge(fit, machine, poses, excitation, motion),
            }),
        }
    }

    /// Begins a moving centre, or refuses with the motion that is missing.
    fn begin_moving(
        &self,
        fit: &mut Fit<T>,
        machine: &Machine<T>,
        poses: &[Pose<T>],
        excitation: &Excitation<T>,
    ) -> Next<T> {
        fit.result.excitation_rad = excitation.least_rad;
        let Some((frame, arm)) = &self.arm else { return Next::Done(Err(Refusal::Singular)) };
        if let Err(refusal) = arm.require_motion(frame, poses.len()) {
            return Next::Done(Err(refusal));
        }
        fit.begin_scattered(machine, Joint::Moving(MovingCentre::new(*frame)))
    }

    fn judge(
        &self,
        fit: &mut Fit<T>,
        machine: &Machine<T>,
        poses: &[Pose<T>],
        excitation: &Excitation<T>,
        motion: &AxisMotion<T>,
    ) -> Next<T> {
        fit.result.excitation_rad = excitation.least_rad;
        if let Err(refusal) = require_excitation(excitation, motion, &fit.settings) {
            return Next::Done(Err(refusal));
        }
        match self.purpose {
            Purpose::NameWhatIsSingular => Next::Done(Err(Refusal::Singular)),
            Purpose::MeasureMigration { rejected } => {
                Next::Refine(Plan::new(fit, Weights::OwnCentres { rejected }, true))
            }
            Purpose::MovingCentre => self.begin_moving(fit, machine, poses, excitation),
            Purpose::Accept => Next::Check(Accepted::Ball { dominant: motion.dominant_pose() }),
        }
    }
}
