//! The calibration of an elbow: the states, transitions, commands and times of [`procedure`](super), for a hinge.
//!
//! Poses are captured when the arm rests, far enough from the others by their lengths; the first set is identified without a
//! start, slice by slice; the second set must agree by χ². What differs from a ball: there is one way to move, so that the
//! guidance is to bend further until the lengths have changed by as much as a radian makes them; there is no phase with the
//! shoulder blade held, and no capture in motion.

mod commands;
mod outcome;
mod progress;
mod refusal;
mod rig;
mod set;
mod ticks;

pub use outcome::{ElbowCandidate, FoundHinge, SHOWN_NUMBERS};
pub use rig::ElbowRig;

use super::arm::{Arm, NotReady};
use super::encoders::{EncoderFault, EncoderLimits};
use super::limits::Limits;
use super::outcome::Ending;
use super::reason::Reason;
use super::solve::Detail;
use super::state::{PoseSet, StateName};
use super::transition::{self, Trigger};
use crate::identification::hinge::{FollowedAngle, HingeAngles, HingeEstimator, HingePose, HingeSettings, MAX_CABLES};
use crate::rig::CABLES;
use set::Set;

/// Poses that the first set has room for.
pub const CAPACITY: usize = 48;
/// Poses that the second set has room for.
pub const HELD_OUT_CAPACITY: usize = 16;
/// Poses in the first set before it can be good enough: two hinges fit fewer more often than not (`cargo study elbow`).
const ENOUGH_POSES: u8 = 20;
/// Smallest difference of a length between two poses, as a share of the ring of the platform's ends: 3 degrees.
const NEAREST: f32 = 0.05;
/// Range of a length below which bending further helps most, as a share of that ring: about a radian.
const BENT: f32 = 1.0;

/// A state with its data.
// The two with a hinge are larger than the others; there is no heap to box them on.
#[allow(clippy::large_enum_variant)]
#[derive(Debug, Clone)]
enum State {
    Idle,
    Collecting,
    Identifying,
    Verifying(Verifying),
    Review(ElbowCandidate),
    Failed,
}

/// The second set is being captured, or (with `judging`) laid against the hinge.
#[derive(Debug, Clone)]
struct Verifying {
    found: FoundHinge,
    judging: Option<Judging>,
}

/// The poses of the second set are laid against the hinge one after the other, one a tick.
#[derive(Debug, Clone, Copy, Default)]
struct Judging {
    next: u8,
    squares_mm2: f32,
    chi_square: f32,
}

/// What belongs to the run as a whole.
#[derive(Debug, Clone, Copy)]
struct Run {
    /// 0 before the first run.
    id: u16,
    by_command_only: bool,
    /// Solver runs so far, and poses in the first set at the last of them.
    attempts: u8,
    attempted_poses: u8,
    /// Slices of the solver run under way.
    slices: u32,
    /// The arm has moved since the last automatic capture: when it rests, that is a new pose.
    moved: bool,
    /// Since when the time of the state runs, ms.
    since_ms: u32,
    /// Why the solver or the second set refused, last.
    detail: Option<Detail>,
    /// Why the last pose was refused, if it was.
    refused_pose: Option<NotReady>,
}

/// The procedure, with the poses of the run and the hinge in use.
#[derive(Debug, Clone)]
pub struct ElbowProcedure {
    rig: ElbowRig,
    limits: Limits,
    boot: u16,
    wearer: u16,
    arm: Arm,
    state: State,
    run: Run,
    estimator: HingeEstimator<f32>,
    poses: Set<CAPACITY>,
    held_out: Set<HELD_OUT_CAPACITY>,
    ending: Option<Ending>,
    live: Option<ElbowCandidate>,
    /// Of the hinge in use.
    angles: Option<HingeAngles<f32>>,
}

impl State {
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

impl ElbowProcedure {
    /// A procedure in the idle state, without a hinge, with the default limits.
    pub fn new(rig: ElbowRig) -> Self {
        let limits = Limits::of_module(rig.drum(), rig.hinge().length_noise_mm());
        Self::with_limits(&rig, limits)
    }

    /// The same with other limits.
    pub fn with_limits(rig: &ElbowRig, limits: Limits) -> Self {
        let encoders = EncoderLimits { cables: rig.cables(), ..limits.encoders() };
        Self {
            arm: Arm::over(&limits, encoders),
            estimator: HingeEstimator::new(rig.hinge(), HingeSettings::for_rig(rig.hinge())),
            rig: rig.clone(),
            limits,
            boot: 0,
            wearer: 0,
            state: State::Idle,
            run: Run::before_the_first(),
            poses: Set::new(),
            held_out: Set::new(),
            ending: None,
            live: None,
            angles: None,
        }
    }

    /// Goes on after a power-down: in which boot, and from which run id on. Nothing has happened yet since power-up.
    pub fn resume_at(&mut self, boot: u16, last_run_id: u16) {
        if matches!(self.state, State::Idle) && self.run.id == 0 {
            self.boot = boot;
            self.run.id = last_run_id;
        }
    }

    /// Takes over the hinge of an earlier run, of before the power was switched off.
    ///
    /// # Errors
    /// [`Reason::RecordUnfit`] when a number of it is none; there is no hinge in use then.
    pub fn resume(&mut self, live: ElbowCandidate) -> Result<(), Reason> {
        if !live.found.is_finite() {
            return Err(Reason::RecordUnfit);
        }
        if matches!(self.state, State::Idle) {
            self.take_into_use(live);
        }
        Ok(())
    }

    fn take_into_use(&mut self, live: ElbowCandidate) {
        self.angles = Some(self.estimator.angles_of(&live.found.hinge, &live.found.constants));
        self.live = Some(live);
    }

    /// How far the joint in use bends where the counts stand so; `None` without a hinge in use, and while the angle is searched
    /// for, a few calls long.
    pub fn angle(&mut self, counts: &[i32; CABLES]) -> Option<FollowedAngle<f32>> {
        let lengths_mm = self.lengths_of(counts)?;
        self.angles.as_mut()?.follow(&lengths_mm)
    }

    /// The cables' lengths where the counts stand so, mm; `None` when one of them is none.
    pub fn lengths_of(&self, counts: &[i32; CABLES]) -> Option<[f32; MAX_CABLES]> {
        self.rig.lengths_mm(counts, &[0.0; CABLES]).ok()
    }

    /// The angles of the hinge in use.
    pub fn angles_mut(&mut self) -> Option<&mut HingeAngles<f32>> {
        self.angles.as_mut()
    }

    /// Sets whose arm the runs to come are made for; 0 = not said. Not while a run is under way.
    pub fn set_wearer(&mut self, wearer: u16) -> Reason {
        if !matches!(self.state, State::Idle | State::Failed) {
            return Reason::AlreadyRunning;
        }
        self.wearer = wearer;
        Reason::Fine
    }

    /// Takes in one sample of the board's counts. Every sample counts: silence is a fault.
    pub fn sample(&mut self, now_ms: u32, counts: &[i32; CABLES]) {
        let mut in_use = [0; CABLES];
        let pairs = in_use.iter_mut().zip(counts).take(usize::from(self.rig.cables()));
        pairs.for_each(|(own, count)| *own = *count);
        self.arm.sample(now_ms, &in_use, self.rig.drum());
        if self.arm.ready(now_ms).is_err() {
            self.run.moved = true;
        }
    }

    /// The machine.
    pub const fn rig(&self) -> &ElbowRig {
        &self.rig
    }

    /// The limits of a run.
    pub const fn limits(&self) -> &Limits {
        &self.limits
    }

    /// The state's name.
    pub const fn state(&self) -> StateName {
        self.state.name()
    }

    /// There is computing to do: the next tick should follow as soon as the board has time.
    pub const fn is_busy(&self) -> bool {
        matches!(self.state, State::Identifying | State::Verifying(Verifying { judging: Some(_), .. }))
    }

    /// The run under way, or the last one; 0 before the first.
    pub const fn run_id(&self) -> u16 {
        self.run.id
    }

    /// Are poses captured by command only?
    pub const fn by_command_only(&self) -> bool {
        self.run.by_command_only
    }

    /// Whose arm the runs to come, or the one under way, are made for.
    pub const fn wearer(&self) -> u16 {
        self.wearer
    }

    /// The hinge in use.
    pub const fn live(&self) -> Option<&ElbowCandidate> {
        self.live.as_ref()
    }

    /// The new hinge that waits for a decision.
    pub const fn candidate(&self) -> Option<&ElbowCandidate> {
        match &self.state {
            State::Review(candidate) => Some(candidate),
            _ => None,
        }
    }

    /// The hinge that the run has identified so far, verified or not.
    pub const fn found(&self) -> Option<&FoundHinge> {
        match &self.state {
            State::Verifying(verifying) => Some(&verifying.found),
            State::Review(candidate) => Some(&candidate.found),
            _ => None,
        }
    }

    /// Why the solver or the second set refused, last; None when neither did.
    pub const fn refusal(&self) -> Option<&Detail> {
        self.run.detail.as_ref()
    }

    /// How the last run ended; None while one is under way and before the first.
    pub const fn ending(&self) -> Option<&Ending> {
        self.ending.as_ref()
    }

    /// The lengths of a captured pose, mm; 0 for cables that the rig has not. They stay until the next run starts, unless the
    /// run is aborted.
    pub fn lengths_mm(&self, set: PoseSet, index: u8) -> Option<&[f32; MAX_CABLES]> {
        self.poses(set).get(usize::from(index)).map(|pose| &pose.lengths_mm)
    }

    /// The captured poses of a set.
    pub fn poses(&self, set: PoseSet) -> &[HingePose<f32>] {
        match set {
            PoseSet::Identification => self.poses.poses(),
            PoseSet::HeldOut => self.held_out.poses(),
        }
    }

    /// What is wrong with the encoders now.
    pub fn fault(&self, now_ms: u32) -> Option<EncoderFault> {
        self.arm.fault(now_ms)
    }

    /// The reason, if a count was lost since the last run began.
    pub fn lost_count(&self) -> Option<Reason> {
        self.arm.lost().map(|_| Reason::EncoderJumped)
    }

    /// Is the arm held still, with believable encoders and every cable at rest?
    ///
    /// # Errors
    /// What is in the way.
    pub fn arm(&self, now_ms: u32) -> Result<(), NotReady> {
        self.arm.ready(now_ms)
    }

    /// Changes the state, if the table has this transition; the only place where `state` is assigned.
    fn go(&mut self, now_ms: u32, trigger: Trigger, state: State) -> bool {
        let allowed = transition::next(self.state.name(), trigger) == Some(state.name());
        if allowed {
            self.state = state;
            self.run.since_ms = now_ms;
            // The pose in which the state begins was captured already, if it was to be captured.
            self.run.moved = false;
        }
        allowed
    }

    /// Ends the run; the poses stay for read-out.
    fn end(&mut self, now_ms: u32, trigger: Trigger, detail: Detail) {
        let failed = transition::next(self.state(), trigger) == Some(StateName::Failed);
        if self.go(now_ms, trigger, if failed { State::Failed } else { State::Idle }) {
            self.ending = Some(Ending { run_id: self.run.id, detail });
        }
    }

    /// The set in which poses are captured now, if any.
    const fn current_set(&self) -> PoseSet {
        match self.state {
            State::Verifying(_) => PoseSet::HeldOut,
            _ => PoseSet::Identification,
        }
    }
}
