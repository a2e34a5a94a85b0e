//! What the procedure does when it is asked, and what it answers.

use super::arm::NotReady;
use super::outcome::PoseNotice;
use super::phase::Phase;
use super::reason::Reason;
use super::solve::Detail;
use super::state::{Command, PoseSet, StateName};
use super::transition::{Trigger, allows};
use super::{Guidance, Judging, Procedure, Run, State, Verifying};
use crate::identification::Pose;
use crate::identification::estimator::PoseVerification;
use crate::kinematics::{CableLengths, PlatformError};

/// Between two poses in motion at least so much time passes, ms, six windows: whatever slides for a moment beside what the arm's
/// direction explains is then not counted twice, nor taken for a slip.
const PAUSE_IN_MOTION_MS: u32 = 540;

/// The answer to a command.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Reply {
    /// [`Reason::Fine`] when the command was obeyed.
    pub reason: Reason,
    /// Index of the captured pose, number of the cable that is meant, or code of the state; 0 otherwise.
    pub detail: u16,
    /// The pose, when one was captured or refused.
    pub pose: Option<PoseNotice>,
}

impl Reply {
    pub(super) const FINE: Self = Self { reason: Reason::Fine, detail: 0, pose: None };

    pub(super) const fn refused(reason: Reason, detail: u16) -> Self {
        Self { reason, detail, pose: None }
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

    fn capture_by_command(&mut self, now_ms: u32) -> Reply {
        if self.assessing.is_some() {
            // The arm stands where it was captured a moment ago.
            return Reply::refused(Reason::PoseTooNear, 0);
        }
        let notice = self.take_pose(now_ms);
        let detail = match notice.reason {
            Reason::Fine => u16::from(notice.index),
            _ => u16::from(notice.cable),
        };
        Reply { reason: notice.reason, detail, pose: self.assessed(notice, false) }
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

    /// Captures the pose in which the arm is held, or says why not.
    pub(super) fn take_pose(&mut self, now_ms: u32) -> PoseNotice {
        let mut distance_rad = None;
        let outcome = match self.arm.pose(now_ms, &self.rig) {
            Ok(taken) => self.try_pose(taken, &mut distance_rad),
            Err(not_ready) => Err(not_ready),
        };
        self.note_pose(now_ms, outcome, distance_rad)
    }

    /// Captures the pose through which the arm has just moved slowly, if there is one and it is far enough from the others.
    pub(super) fn take_pose_in_motion(&mut self, now_ms: u32) -> Option<PoseNotice> {
        let taken = self.arm.pose_in_motion(now_ms, &self.rig)?;
        if now_ms.wrapping_sub(self.run.since_ms) < PAUSE_IN_MOTION_MS {
            return None;
        }
        let mut distance_rad = None;
        // On the way from pose to pose most are too near: no notice is sent.
        self.try_pose(taken, &mut distance_rad).ok()?;
        Some(self.note_pose(now_ms, Ok(()), distance_rad))
    }

    fn note_pose(&mut self, now_ms: u32, outcome: Result<(), NotReady>, distance_rad: Option<f32>) -> PoseNotice {
        let set = self.current_set();
        self.run.refused_pose = outcome.err();
        let NotReady { reason, cable } = outcome.err().unwrap_or(NotReady { reason: Reason::Fine, cable: 0 });
        let taken = outcome.is_ok();
        if taken {
            self.run.since_ms = now_ms;
        }
        let guidance = match reason {
            Reason::Fine => self.run.advice,
            Reason::PoseTooNear | Reason::ArmMoving => Guidance::MoveFurther,
            Reason::PosesFull => Guidance::Nothing,
            Reason::EncoderSilent | Reason::EncoderFrozen | Reason::EncoderJumped => Guidance::CheckEncoders,
            _ => Guidance::TightenCable,
        };
        let count = match set {
            PoseSet::Identification => self.poses.count(),
            PoseSet::HeldOut => self.held_out.count(),
        };
        PoseNotice {
            set,
            index: if taken { count.saturating_sub(1) } else { count },
            reason,
            cable,
            sigma_mm: self.predicted_sigma_mm(),
            distance_rad,
            guidance,
        }
    }

    /// What would help the first set most.
    fn advice(&self) -> Guidance {
        match self.run.phase {
            Phase::Held => match self.spread.advice() {
                Guidance::MoveOn | Guidance::TiltMore => Guidance::HoldBlade,
                advice => advice,
            },
            Phase::Free(_) => self.spread.advice_for_moving(),
            Phase::Only if self.moves() => self.spread.advice_for_moving(),
            Phase::Only => self.spread.advice(),
        }
    }

    fn try_pose(
        &mut self,
        (lengths, samples): (CableLengths<f32>, u16),
        distance_rad: &mut Option<f32>,
    ) -> Result<(), NotReady> {
        let refused = |reason| NotReady { reason, cable: 0 };
        let pose = Pose::placed(self.machine.platform(), lengths).map_err(|error| match error {
            PlatformError::Length(error) => NotReady { reason: Reason::LengthImpossible, cable: error.cable },
            PlatformError::DoesNotClose => refused(Reason::PlatformDoesNotClose),
        })?;
        let pose = pose.averaged_over(samples);
        // A pose of the second set that repeats one of the first would verify nothing.
        let distances = [self.poses.nearest_rad(&pose), self.held_out.nearest_rad(&pose)];
        *distance_rad = distances.into_iter().flatten().reduce(f32::min);
        if distance_rad.is_some_and(|distance| distance < self.limits.settings().nearest_pose_rad) {
            return Err(refused(Reason::PoseTooNear));
        }
        match self.current_set() {
            PoseSet::Identification => {
                self.poses.push(pose).map_err(|_| refused(Reason::PosesFull))?;
                self.spread.add(&pose.rotation());
                self.run.advice = self.advice();
            }
            PoseSet::HeldOut => {
                self.held_out.push(pose).map_err(|_| refused(Reason::PosesFull))?;
                self.run.advice = Guidance::MoveOn;
            }
        }
        Ok(())
    }
}
