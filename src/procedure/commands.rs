//! What the procedure does when it is asked, and what it answers.

use super::course::Course;
use super::reason::Reason;
use super::reply::Reply;
use super::solve::Detail;
use super::state::Command;
use super::transition::Trigger;
use super::{Judging, Procedure, Verifying};
use crate::identification::Pose;
use crate::identification::estimator::PoseVerification;

impl Procedure {
    /// Obeys a command, or says why not. A command that is refused changes nothing.
    pub fn command(&mut self, now_ms: u32, command: Command) -> Reply {
        if let Some(objection) = Reply::objection(self.state(), command) {
            return objection;
        }
        match command {
            Command::Start { by_command_only, held_first, in_motion } => {
                let in_motion = in_motion || self.calibration.limits.settings().capture_in_motion;
                self.start(now_ms, by_command_only, Course::new(in_motion, held_first))
            }
            Command::Capture => self.capture_by_command(now_ms),
            Command::Identify => self.identify_by_command(now_ms),
            Command::Verify => self.verify_by_command(),
            Command::Accept => self.accept(now_ms),
            Command::Reject => self.ended(now_ms, Trigger::Reject, Reason::Rejected),
            Command::Abort => self.abort(now_ms),
            Command::Acknowledge => self.acknowledge(now_ms),
        }
    }

    fn start(&mut self, now_ms: u32, by_command_only: bool, course: Course) -> Reply {
        if let Err(refused) = self.calibration.start(now_ms, by_command_only) {
            return refused;
        }
        self.course = course;
        self.forget_poses();
        Reply::FINE
    }

    fn identify_by_command(&mut self, now_ms: u32) -> Reply {
        if usize::from(self.poses.count()) < self.course.phase.min_poses() {
            return Reply::refused(Reason::TooFewPoses, u16::from(self.poses.count()));
        }
        self.identify(now_ms);
        Reply::FINE
    }

    fn verify_by_command(&mut self) -> Reply {
        if self.held_out.count() == 0 {
            return Reply::refused(Reason::TooFewPoses, 0);
        }
        self.judge();
        Reply::FINE
    }

    /// The encoders must be believable now, and have lost no count since the run began: a centre in terms of counts
    /// that have shifted is a wrong one.
    fn accept(&mut self, now_ms: u32) -> Reply {
        let Some(candidate) = self.candidate() else { return Reply::FINE };
        if let Some(fault) = self.calibration.arm.fault(now_ms) {
            return Reply::refused(fault.reason, u16::from(fault.cable));
        }
        if let Err(detail) = self.check_plausible(&candidate.identified) {
            return Reply::refused(detail.reason, u16::from(detail.cable));
        }
        let candidate = candidate.clone();
        self.calibration.end(now_ms, Trigger::Accept, Detail::of(Reason::Accepted));
        self.live = Some(candidate);
        Reply::FINE
    }

    fn abort(&mut self, now_ms: u32) -> Reply {
        if self.calibration.abort(now_ms) {
            self.give_up_capture();
            self.forget_poses();
        }
        Reply::FINE
    }

    fn acknowledge(&mut self, now_ms: u32) -> Reply {
        self.calibration.acknowledge(now_ms);
        Reply::FINE
    }

    fn ended(&mut self, now_ms: u32, trigger: Trigger, reason: Reason) -> Reply {
        self.calibration.end(now_ms, trigger, Detail::of(reason));
        Reply::FINE
    }

    pub(super) fn forget_poses(&mut self) {
        self.poses.clear();
        self.held_out.clear();
        self.spread = Default::default();
        self.accuracy.restart(&self.machine, self.rig.nominal());
        self.assessing = None;
        self.capturing = None;
        self.predicted_sigma_mm = None;
        self.sigma_with_more_mm = None;
    }

    /// Hands the first set to the solver.
    pub(super) fn identify(&mut self, now_ms: u32) {
        if self.calibration.identify(now_ms, self.poses.count()) {
            self.give_up_capture();
            if self.calibration.run.attempts > 1 {
                // The estimator before has refined the rotations: it begins anew from the lengths alone.
                self.poses.poses_mut().iter_mut().for_each(Pose::reset);
            }
            let (joint, held) = self.course.phase.joint();
            self.work.restart(&self.machine, joint, held);
        }
    }

    /// Begins to hold the second set against the centre.
    pub(super) fn judge(&mut self) {
        if let Some(Verifying { judging: judging @ None, .. }) = self.calibration.verifying_mut() {
            *judging =
                Some(Judging { next: 0, verification: PoseVerification::default(), squares_mm2: 0.0, chi_square: 0.0 });
        }
    }
}
