//! What the elbow's procedure does when it is asked, and what it answers.

use super::{ElbowProcedure, Judging, NEAREST, Run, Set, State, Verifying};
use crate::identification::hinge::{HingePose, MAX_CABLES};
use crate::procedure::arm::NotReady;
use crate::procedure::commands::Reply;
use crate::procedure::guidance::Guidance;
use crate::procedure::outcome::PoseNotice;
use crate::procedure::reason::Reason;
use crate::procedure::solve::Detail;
use crate::procedure::state::{Command, PoseSet, StateName};
use crate::procedure::transition::{Trigger, allows};

impl Run {
    pub(super) const fn before_the_first() -> Self {
        Self {
            id: 0,
            by_command_only: false,
            attempts: 0,
            attempted_poses: 0,
            slices: 0,
            moved: true,
            since_ms: 0,
            detail: None,
            refused_pose: None,
        }
    }

    /// The run after the run `last_id`. Ids wrap past zero, which means "no run".
    const fn new(last_id: u16, by_command_only: bool, now_ms: u32) -> Self {
        let id = match last_id.wrapping_add(1) {
            0 => 1,
            id => id,
        };
        Self { id, by_command_only, since_ms: now_ms, ..Self::before_the_first() }
    }
}

impl ElbowProcedure {
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
                self.end(now_ms, Trigger::Reject, Detail::of(Reason::Rejected));
                Reply::FINE
            }
            Command::Abort => {
                // In the idle state there is nothing to abort: the end of the last run stays as it was reported.
                if !matches!(self.state, State::Idle) {
                    self.end(now_ms, Trigger::Abort, Detail::of(Reason::Aborted));
                    self.forget_poses();
                }
                Reply::FINE
            }
            Command::Acknowledge => {
                if matches!(self.state, State::Failed) {
                    self.go(now_ms, Trigger::Acknowledge, State::Idle);
                }
                Reply::FINE
            }
        }
    }

    fn start(&mut self, now_ms: u32, by_command_only: bool) -> Reply {
        // A count lost in an earlier run must not lock the device for ever.
        let mut arm = self.arm;
        arm.forgive();
        if let Err(NotReady { reason, cable }) = arm.ready(now_ms) {
            return Reply::refused(reason, u16::from(cable));
        }
        if self.go(now_ms, Trigger::Start, State::Collecting) {
            self.arm = arm;
            self.run = Run::new(self.run.id, by_command_only, now_ms);
            self.forget_poses();
            self.ending = None;
        }
        Reply::FINE
    }

    /// The encoders must be believable now, and have lost no count since the run began: a hinge in terms of counts that
    /// have shifted is a wrong one.
    fn accept(&mut self, now_ms: u32) -> Reply {
        let Some(candidate) = self.candidate().cloned() else { return Reply::FINE };
        if let Some(fault) = self.arm.fault(now_ms) {
            return Reply::refused(fault.reason, u16::from(fault.cable));
        }
        self.end(now_ms, Trigger::Accept, Detail::of(Reason::Accepted));
        self.take_into_use(candidate);
        Reply::FINE
    }

    fn forget_poses(&mut self) {
        self.poses.clear();
        self.held_out.clear();
    }

    /// Hands the first set to the solver.
    pub(super) fn identify(&mut self, now_ms: u32) {
        if self.go(now_ms, Trigger::Identify, State::Identifying) {
            // An estimation before has left its angles and weights: it begins anew from the lengths alone.
            self.poses.poses_mut().iter_mut().for_each(|pose| *pose = HingePose::new(pose.lengths_mm));
            self.estimator.restart();
            self.run.slices = 0;
            self.run.attempts = self.run.attempts.saturating_add(1);
            self.run.attempted_poses = self.poses.count();
            self.run.detail = None;
        }
    }

    /// Begins to hold the second set against the hinge.
    pub(super) fn judge(&mut self) {
        if let State::Verifying(Verifying { judging: judging @ None, .. }) = &mut self.state {
            *judging = Some(Judging::default());
        }
    }

    /// Captures the pose in which the arm is held, or says why not.
    pub(super) fn take_pose(&mut self, now_ms: u32) -> PoseNotice {
        let set = self.current_set();
        let outcome = self.try_pose(now_ms);
        self.run.refused_pose = outcome.err();
        if outcome.is_ok() {
            self.run.since_ms = now_ms;
        }
        let NotReady { reason, cable } = outcome.err().unwrap_or(NotReady { reason: Reason::Fine, cable: 0 });
        let guidance = match reason {
            Reason::Fine => self.advice(),
            Reason::PoseTooNear | Reason::ArmMoving => Guidance::MoveFurther,
            Reason::PosesFull => Guidance::Nothing,
            Reason::EncoderSilent | Reason::EncoderFrozen | Reason::EncoderJumped => Guidance::CheckEncoders,
            _ => Guidance::TightenCable,
        };
        let count = self.pose_count();
        let index = if outcome.is_ok() { count.saturating_sub(1) } else { count };
        PoseNotice { set, index, reason, cable, sigma_mm: None, distance_rad: None, guidance }
    }

    fn try_pose(&mut self, now_ms: u32) -> Result<(), NotReady> {
        let held = self.arm.held(now_ms)?;
        let impossible = |cable| NotReady { reason: Reason::LengthImpossible, cable };
        let lengths_mm: [f32; MAX_CABLES] = self.rig.lengths_mm(&held.first, &held.above).map_err(impossible)?;
        // A pose of the second set that repeats one of the first would verify nothing.
        let nearest_mm = self.poses.nearest_mm(&lengths_mm).min(self.held_out.nearest_mm(&lengths_mm));
        let refused = |reason| NotReady { reason, cable: 0 };
        if nearest_mm < NEAREST * self.rig.ring_mm() {
            return Err(refused(Reason::PoseTooNear));
        }
        let has_room = match self.current_set() {
            PoseSet::Identification => Set::push(&mut self.poses, lengths_mm),
            PoseSet::HeldOut => Set::push(&mut self.held_out, lengths_mm),
        };
        if has_room { Ok(()) } else { Err(refused(Reason::PosesFull)) }
    }
}
