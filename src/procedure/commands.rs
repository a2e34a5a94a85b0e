//! What the procedure does when it is asked, and what it answers.

use super::arm::NotReady;
use super::outcome::PoseNotice;
use super::phase::Phase;
use super::reason::Reason;
use super::solve::Detail;
use super::state::{Command, StateName};
use super::transition::{Trigger, allows};
use super::{Guidance, Judging, Procedure, Run, State, Verifying};
use crate::identification::Pose;
use crate::identification::estimator::PoseVerification;

/// The answer to a command.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Reply {
    /// [`Reason::Fine`] when the command was obeyed.
    pub reason: Reason,
    /// Index of the captured pose, number of the cable that is meant, or code of the state; 0 otherwise.
    pub detail: u16,
    /// The pose, when one was refused.
    pub pose: Option<PoseNotice>,
    /// A pose is being captured, and the answer comes with a tick to come ([`Procedure::take_answer`]).
    pub is_later: bool,
}

impl Reply {
    pub(super) const FINE: Self = Self { reason: Reason::Fine, detail: 0, pose: None, is_later: false };
    pub(super) const LATER: Self = Self { is_later: true, ..Self::FINE };

    pub(super) const fn refused(reason: Reason, detail: u16) -> Self {
        Self { reason, detail, ..Self::FINE }
    }
}

impl Procedure {
    /// Obeys a command, or says why not. A command that is refused changes nothing.
    pub fn command(&mut self, now_ms: u32, command: Command) -> Reply {
        let state = self.state();
        if !allows(state, command) {
            let reason = match (command, state) {
                (Command::Start { .. }, StateName::Failed) => Reason::AcknowledgeFirst,
                (Command::Start { .. }, _) => Reason::AlreadyRunning,
                _ => Reason::WrongState,
            };
            return Reply::refused(reason, u16::from(state.code()));
        }
        match command {
            Command::Start { by_command_only, held_first, in_motion } => {
                let in_motion = in_motion || self.limits.settings().capture_in_motion;
                self.start(now_ms, Run { in_motion, ..Run::new(self.run.id, by_command_only, now_ms) }, held_first)
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

    fn start(&mut self, now_ms: u32, run: Run, held_first: bool) -> Reply {
        // A count lost in an earlier run must not lock the device for ever; the new run begins from where the
        // encoders stand, and outliers, second set and standard deviation judge it like any other.
        let mut arm = self.arm;
        arm.forgive();
        if let Err(NotReady { reason, cable }) = arm.ready(now_ms) {
            return Reply::refused(reason, u16::from(cable));
        }
        if self.go(now_ms, Trigger::Start, State::Collecting) {
            self.arm = arm;
            self.run = run;
            if held_first {
                self.run.phase = Phase::Held;
                self.run.advice = Guidance::HoldBlade;
            }
            self.forget_poses();
            self.ending = None;
        }
        Reply::FINE
    }

    fn identify_by_command(&mut self, now_ms: u32) -> Reply {
        if usize::from(self.poses.count()) < self.run.phase.min_poses() {
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
        if let Some(fault) = self.arm.fault(now_ms) {
            return Reply::refused(fault.reason, u16::from(fault.cable));
        }
        if let Err(detail) = self.check_plausible(&candidate.identified) {
            return Reply::refused(detail.reason, u16::from(detail.cable));
        }
        let candidate = candidate.clone();
        self.end(now_ms, Trigger::Accept, Detail::of(Reason::Accepted));
        self.live = Some(candidate);
        Reply::FINE
    }

    fn abort(&mut self, now_ms: u32) -> Reply {
        // In the idle state there is nothing to abort: the end of the last run stays as it was reported.
        if !matches!(self.state, State::Idle) {
            self.end(now_ms, Trigger::Abort, Detail::of(Reason::Aborted));
            self.forget_poses();
        }
        Reply::FINE
    }

    fn acknowledge(&mut self, now_ms: u32) -> Reply {
        if matches!(self.state, State::Failed) {
            self.go(now_ms, Trigger::Acknowledge, State::Idle);
        }
        Reply::FINE
    }

    fn ended(&mut self, now_ms: u32, trigger: Trigger, reason: Reason) -> Reply {
        self.end(now_ms, trigger, Detail::of(reason));
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
        if self.go(now_ms, Trigger::Identify, State::Identifying) {
            if self.run.attempts > 0 {
                // The estimator before has refined the rotations: it begins anew from the lengths alone.
                self.poses.poses_mut().iter_mut().for_each(Pose::reset);
            }
            let (joint, held) = self.run.phase.joint();
            self.work.restart(&self.machine, joint, held);
            self.run.attempts = self.run.attempts.saturating_add(1);
            self.run.attempted_poses = self.poses.count();
            self.run.detail = None;
        }
    }

    /// Begins to hold the second set against the centre.
    pub(super) fn judge(&mut self) {
        if let State::Verifying(Verifying { judging: judging @ None, .. }) = &mut self.state {
            *judging =
                Some(Judging { next: 0, verification: PoseVerification::default(), squares_mm2: 0.0, chi_square: 0.0 });
        }
    }
}
