//! What the elbow's procedure does when it is asked, and what it answers.

use super::{ElbowProcedure, Judging, NEAREST, Set, Verifying};
use crate::identification::hinge::{HingePose, MAX_CABLES};
use crate::procedure::arm::NotReady;
use crate::procedure::outcome::PoseNotice;
use crate::procedure::reason::Reason;
use crate::procedure::reply::Reply;
use crate::procedure::solve::Detail;
use crate::procedure::state::{Command, PoseSet};
use crate::procedure::transition::Trigger;

impl ElbowProcedure {
    /// Obeys a command, or says why not. A command that is refused changes nothing.
    pub fn command(&mut self, now_ms: u32, command: Command) -> Reply {
        if let Some(objection) = Reply::objection(self.state(), command) {
            return objection;
        }
        match command {
            // Neither is anything that an elbow has.
            Command::Start { held_first: true, .. } | Command::Start { in_motion: true, .. } => {
                Reply::refused(Reason::NotOfHinge, 0)
            }
            Command::Start { by_command_only, .. } => self.start(now_ms, by_command_only),
            Command::Capture => {
                let notice = self.take_pose(now_ms);
                let detail = if notice.reason == Reason::Fine { notice.index } else { notice.cable };
                Reply { pose: Some(notice), ..Reply::refused(notice.reason, detail.into()) }
            }
            Command::Identify if usize::from(self.poses.count()) < crate::identification::hinge::MIN_POSES => {
                Reply::refused(Reason::TooFewPoses, u16::from(self.poses.count()))
            }
            Command::Identify => {
                self.identify(now_ms);
                Reply::FINE
            }
            Command::Verify if self.held_out.count() == 0 => Reply::refused(Reason::TooFewPoses, 0),
            Command::Verify => {
                self.judge();
                Reply::FINE
            }
            Command::Accept => self.accept(now_ms),
            Command::Reject => {
                self.calibration.end(now_ms, Trigger::Reject, Detail::of(Reason::Rejected));
                Reply::FINE
            }
            Command::Abort => {
                if self.calibration.abort(now_ms) {
                    self.forget_poses();
                }
                Reply::FINE
            }
            Command::Acknowledge => {
                self.calibration.acknowledge(now_ms);
                Reply::FINE
            }
        }
    }

    fn start(&mut self, now_ms: u32, by_command_only: bool) -> Reply {
        if let Err(refused) = self.calibration.start(now_ms, by_command_only) {
            return refused;
        }
        self.forget_poses();
        Reply::FINE
    }

    /// The encoders must be believable now, and have lost no count since the run began: a hinge in terms of counts that
    /// have shifted is a wrong one.
    fn accept(&mut self, now_ms: u32) -> Reply {
        let Some(candidate) = self.candidate().cloned() else { return Reply::FINE };
        if let Some(fault) = self.calibration.arm.fault(now_ms) {
            return Reply::refused(fault.reason, u16::from(fault.cable));
        }
        self.calibration.end(now_ms, Trigger::Accept, Detail::of(Reason::Accepted));
        self.take_into_use(candidate);
        Reply::FINE
    }

    fn forget_poses(&mut self) {
        self.poses.clear();
        self.held_out.clear();
    }

    /// Hands the first set to the solver.
    pub(super) fn identify(&mut self, now_ms: u32) {
        if self.calibration.identify(now_ms, self.poses.count()) {
            // An estimation before has left its angles and weights: it begins anew from the lengths alone.
            self.poses.poses_mut().iter_mut().for_each(|pose| *pose = HingePose::new(pose.lengths_mm));
            self.estimator.restart();
            self.slices = 0;
        }
    }

    /// Begins to hold the second set against the hinge.
    pub(super) fn judge(&mut self) {
        if let Some(Verifying { judging: judging @ None, .. }) = self.calibration.verifying_mut() {
            *judging = Some(Judging::default());
        }
    }

    /// Captures the pose in which the arm is held, or says why not.
    pub(super) fn take_pose(&mut self, now_ms: u32) -> PoseNotice {
        let outcome = self.try_pose(now_ms);
        self.calibration.note_pose(now_ms, outcome, self.pose_count(), self.advice())
    }

    fn try_pose(&mut self, now_ms: u32) -> Result<(), NotReady> {
        let held = self.calibration.arm.held(now_ms)?;
        let impossible = |cable| NotReady { reason: Reason::LengthImpossible, cable };
        let lengths_mm: [f32; MAX_CABLES] = self.rig.lengths_mm(&held.first, &held.above).map_err(impossible)?;
        // A pose of the second set that repeats one of the first would verify nothing.
        let nearest_mm = self.poses.nearest_mm(&lengths_mm).min(self.held_out.nearest_mm(&lengths_mm));
        let refused = |reason| NotReady { reason, cable: 0 };
        if nearest_mm < NEAREST * self.rig.ring_mm() {
            return Err(refused(Reason::PoseTooNear));
        }
        let has_room = match self.calibration.current_set() {
            PoseSet::Identification => Set::push(&mut self.poses, lengths_mm),
            PoseSet::HeldOut => Set::push(&mut self.held_out, lengths_mm),
        };
        if has_room { Ok(()) } else { Err(refused(Reason::PosesFull)) }
    }
}
