//! What every calibration has, whatever the joint: the state, the run and its times, the arm, and how the last run ended.
//! The state is changed here and nowhere else.

use super::arm::{Arm, NotReady};
use super::encoders::EncoderLimits;
use super::guidance::Guidance;
use super::limits::Limits;
use super::outcome::{Ending, PoseNotice};
use super::reason::Reason;
use super::reply::Reply;
use super::solve::Detail;
use super::state::{PoseSet, StateName};
use super::transition::{self, Trigger};

/// A state with its data: what was found while the second set is held against it, the new value while it waits for a decision.
// The two with data are larger than the others (400 bytes and more); there is no heap to box them on.
#[allow(clippy::large_enum_variant)]
#[derive(Debug, Clone)]
pub(super) enum State<Verifying, Candidate> {
    Idle,
    Collecting,
    /// The solver's workspace stands beside the state: it is not moved about on the stack.
    Identifying,
    Verifying(Verifying),
    Review(Candidate),
    Failed,
}

impl<Verifying, Candidate> State<Verifying, Candidate> {
    const fn name(&self) -> StateName {
        match self {
            Self::Idle => StateName::Idle,
            Self::Collecting => StateName::Collecting,
            Self::Identifying => StateName::Identifying,
            Self::Verifying(_) => StateName::Verifying,
            Self::Review(_) => StateName::Review,
            Self::Failed => StateName::Failed,
        }
    }
}

/// What belongs to the run as a whole.
#[derive(Debug, Clone, Copy)]
pub(super) struct Run {
    /// 0 before the first run.
    pub id: u16,
    pub by_command_only: bool,
    /// Solver runs so far, and poses in the first set at the last of them.
    pub attempts: u8,
    pub attempted_poses: u8,
    /// The arm has moved since the last automatic capture: when it rests, that is a new pose.
    pub moved: bool,
    /// Since when the time of the state runs, ms.
    pub since_ms: u32,
    /// Why the solver or the second set refused, last.
    pub detail: Option<Detail>,
    /// Why the last pose was refused, if it was.
    pub refused_pose: Option<NotReady>,
}

impl Run {
    const fn before_the_first() -> Self {
        Self {
            id: 0,
            by_command_only: false,
            attempts: 0,
            attempted_poses: 0,
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

    /// What is said of a pose that was captured or refused, `count` poses being in its set now.
    fn note_pose(
        &mut self,
        now_ms: u32,
        outcome: Result<(), NotReady>,
        set: PoseSet,
        count: u8,
        advice: Guidance,
    ) -> PoseNotice {
        self.refused_pose = outcome.err();
        let taken = outcome.is_ok();
        if taken {
            self.since_ms = now_ms;
        }
        let NotReady { reason, cable } = outcome.err().unwrap_or(NotReady { reason: Reason::Fine, cable: 0 });
        let guidance = match reason {
            Reason::Fine => advice,
            Reason::PoseTooNear | Reason::ArmMoving => Guidance::MoveFurther,
            Reason::PosesFull => Guidance::Nothing,
            Reason::EncoderSilent | Reason::EncoderFrozen | Reason::EncoderJumped => Guidance::CheckEncoders,
            _ => Guidance::TightenCable,
        };
        let index = if taken { count.saturating_sub(1) } else { count };
        PoseNotice { set, index, reason, cable, sigma_mm: None, distance_rad: None, guidance }
    }
}

/// What the procedures of all joints have in common.
#[derive(Debug, Clone)]
pub(super) struct Calibration<Verifying, Candidate> {
    pub limits: Limits,
    /// The boot that is under way, and the wearer that the next run is made for.
    pub boot: u16,
    pub wearer: u16,
    pub arm: Arm,
    pub run: Run,
    /// How the last run ended; None while one is under way and before the first.
    pub ending: Option<Ending>,
    state: State<Verifying, Candidate>,
}

impl<Verifying, Candidate> Calibration<Verifying, Candidate> {
    /// The idle state, before the first run, over cables with these limits of their encoders.
    pub fn new(limits: Limits, encoders: EncoderLimits) -> Self {
        let (arm, run) = (Arm::new(&limits, encoders), Run::before_the_first());
        Self { limits, boot: 0, wearer: 0, arm, run, ending: None, state: State::Idle }
    }

    /// Goes on after a power-down: in which boot, and from which run id on. Nothing has happened yet since power-up.
    pub fn resume_at(&mut self, boot: u16, last_run_id: u16) {
        if self.name() == StateName::Idle && self.run.id == 0 {
            self.boot = boot;
            self.run.id = last_run_id;
        }
    }

    /// No run is under way, nor waits for a decision.
    pub fn is_between_runs(&self) -> bool {
        matches!(self.name(), StateName::Idle | StateName::Failed)
    }

    /// Sets whose arm the runs to come are made for; 0 = not said. Not while a run is under way.
    pub fn set_wearer(&mut self, wearer: u16) -> Reason {
        if !self.is_between_runs() {
            return Reason::AlreadyRunning;
        }
        self.wearer = wearer;
        Reason::Fine
    }

    /// The state with its data.
    pub const fn state(&self) -> &State<Verifying, Candidate> {
        &self.state
    }

    /// The state's name.
    pub const fn name(&self) -> StateName {
        self.state.name()
    }

    /// What was found, while the second set is held against it.
    pub const fn verifying_mut(&mut self) -> Option<&mut Verifying> {
        match &mut self.state {
            State::Verifying(verifying) => Some(verifying),
            _ => None,
        }
    }

    /// What waits for a decision.
    pub const fn candidate(&self) -> Option<&Candidate> {
        match &self.state {
            State::Review(candidate) => Some(candidate),
            _ => None,
        }
    }

    /// The set in which poses are captured now, if any.
    pub const fn current_set(&self) -> PoseSet {
        match self.state {
            State::Verifying(_) => PoseSet::HeldOut,
            _ => PoseSet::Identification,
        }
    }

    /// After a sample of the encoders: an arm that is not at rest has moved.
    pub fn sampled(&mut self, now_ms: u32) {
        if self.arm.ready(now_ms).is_err() {
            self.run.moved = true;
        }
    }

    /// The arm has come to rest where a pose is to be captured by itself: once a rest.
    pub fn has_come_to_rest(&mut self, now_ms: u32) -> bool {
        let is_new = !self.run.by_command_only && self.run.moved && self.arm.ready(now_ms).is_ok();
        if is_new {
            self.run.moved = false;
        }
        is_new
    }

    /// The state's time is over.
    pub fn is_overdue(&self, now_ms: u32, limit_ms: u32) -> bool {
        now_ms.wrapping_sub(self.run.since_ms) >= limit_ms
    }

    /// Changes the state, if the table has this transition; the only place where `state` is assigned.
    pub fn go(&mut self, now_ms: u32, trigger: Trigger, state: State<Verifying, Candidate>) -> bool {
        let allowed = transition::next(self.name(), trigger) == Some(state.name());
        if allowed {
            self.state = state;
            self.run.since_ms = now_ms;
            // The pose in which the state begins was captured already, if it was to be captured.
            self.run.moved = false;
        }
        allowed
    }

    /// Ends the run; the poses stay for read-out.
    pub fn end(&mut self, now_ms: u32, trigger: Trigger, detail: Detail) {
        let failed = transition::next(self.name(), trigger) == Some(StateName::Failed);
        if self.go(now_ms, trigger, if failed { State::Failed } else { State::Idle }) {
            self.ending = Some(Ending { run_id: self.run.id, detail });
        }
    }

    /// Ends the run if a count was lost since it began.
    pub fn fails_by_lost_count(&mut self, now_ms: u32) -> bool {
        let Some(cable) = self.arm.lost() else { return false };
        self.end(now_ms, Trigger::CountLost, Detail { cable, ..Detail::of(Reason::EncoderJumped) });
        true
    }

    /// Nobody decides for ever.
    pub fn tick_review(&mut self, now_ms: u32) {
        if self.is_overdue(now_ms, self.limits.settings().review_timeout_ms) {
            self.end(now_ms, Trigger::Timeout, Detail::of(Reason::ReviewTimeout));
        }
    }

    /// The first set, of so many poses, goes to the solver; false when it cannot in this state.
    pub fn identify(&mut self, now_ms: u32, poses: u8) -> bool {
        let gone = self.go(now_ms, Trigger::Identify, State::Identifying);
        if gone {
            self.run.attempts = self.run.attempts.saturating_add(1);
            self.run.attempted_poses = poses;
            self.run.detail = None;
        }
        gone
    }

    /// The solver has refused: more poses are collected where they cure it, until there were attempts enough.
    pub fn refused(&mut self, now_ms: u32, detail: Detail, is_cured_by_more_poses: bool) {
        self.run.detail = Some(detail);
        if is_cured_by_more_poses && self.run.attempts < self.limits.settings().max_attempts {
            self.go(now_ms, Trigger::WantsMore, State::Collecting);
        } else {
            self.end(now_ms, Trigger::GaveUp, detail);
        }
    }

    /// The second set contradicts what was found.
    pub fn contradicted(&mut self, now_ms: u32, detail: Detail) {
        self.run.detail = Some(detail);
        self.end(now_ms, Trigger::Contradicted, detail);
    }

    /// Begins a run. A count lost in an earlier one must not lock the device for ever; the new run begins from where the
    /// encoders stand, and outliers, second set and standard deviation judge it like any other.
    ///
    /// # Errors
    /// What about the arm is in the way.
    pub fn start(&mut self, now_ms: u32, by_command_only: bool) -> Result<(), Reply> {
        let mut arm = self.arm;
        arm.forgive();
        arm.ready(now_ms).map_err(|NotReady { reason, cable }| Reply::refused(reason, u16::from(cable)))?;
        if self.go(now_ms, Trigger::Start, State::Collecting) {
            self.arm = arm;
            self.run = Run::new(self.run.id, by_command_only, now_ms);
            self.ending = None;
        }
        Ok(())
    }

    /// Ends the run without a value; false in the idle state, where there is nothing to abort: the end of the last run stays as
    /// it was reported.
    pub fn abort(&mut self, now_ms: u32) -> bool {
        let is_under_way = self.name() != StateName::Idle;
        if is_under_way {
            self.end(now_ms, Trigger::Abort, Detail::of(Reason::Aborted));
        }
        is_under_way
    }

    /// The end of the run has been seen.
    pub fn acknowledge(&mut self, now_ms: u32) {
        if self.name() == StateName::Failed {
            self.go(now_ms, Trigger::Acknowledge, State::Idle);
        }
    }

    /// What is said of a pose that was captured or refused, `count` poses being in its set now.
    pub fn note_pose(&mut self, now_ms: u32, outcome: Result<(), NotReady>, count: u8, advice: Guidance) -> PoseNotice {
        let set = self.current_set();
        self.run.note_pose(now_ms, outcome, set, count, advice)
    }

    /// Why the run stands where it stands, or what disturbs it now.
    pub fn reason(&self, now_ms: u32) -> Reason {
        match self.name() {
            StateName::Idle | StateName::Failed => self.ending.map_or(Reason::Fine, |ending| ending.detail.reason),
            StateName::Identifying | StateName::Review => Reason::Fine,
            StateName::Collecting | StateName::Verifying => match (self.arm.fault(now_ms), self.run.refused_pose) {
                (Some(fault), _) => fault.reason,
                (None, Some(refused)) => refused.reason,
                (None, None) => self.run.detail.map_or(Reason::Fine, |detail| detail.reason),
            },
        }
    }

    /// What the person at the arm should do now; `advice` is what would help the set.
    pub fn guidance(&self, now_ms: u32, advice: Guidance) -> Guidance {
        guidance(self.name(), self.arm.ready(now_ms), self.run.refused_pose, advice)
    }
}

/// The same in this state, where the arm is so and the last pose was refused so.
fn guidance(state: StateName, arm: Result<(), NotReady>, refused_pose: Option<NotReady>, advice: Guidance) -> Guidance {
    match state {
        StateName::Idle => Guidance::Nothing,
        StateName::Identifying => Guidance::Wait,
        StateName::Review => Guidance::Decide,
        StateName::Failed => Guidance::Acknowledge,
        StateName::Collecting | StateName::Verifying => match arm.err().map(|not| not.reason) {
            Some(Reason::CableLoose) => Guidance::TightenCable,
            Some(Reason::EncoderSilent | Reason::EncoderFrozen | Reason::EncoderJumped) => Guidance::CheckEncoders,
            _ if refused_pose.is_some_and(|refused| refused.reason == Reason::PoseTooNear) => Guidance::MoveFurther,
            _ => advice,
        },
    }
}
