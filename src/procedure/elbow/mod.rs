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

use super::arm::NotReady;
use super::calibration::{Calibration, State};
use super::encoders::{EncoderFault, EncoderLimits};
use super::limits::Limits;
use super::outcome::Ending;
use super::reason::Reason;
use super::solve::Detail;
use super::state::{PoseSet, StateName};
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

/// The procedure, with the poses of the run and the hinge in use.
#[derive(Debug, Clone)]
pub struct ElbowProcedure {
    rig: ElbowRig,
    calibration: Calibration<Verifying, ElbowCandidate>,
    /// Slices of the solver run under way.
    slices: u32,
    estimator: HingeEstimator<f32>,
    poses: Set<CAPACITY>,
    held_out: Set<HELD_OUT_CAPACITY>,
    live: Option<ElbowCandidate>,
    /// Of the hinge in use.
    angles: Option<HingeAngles<f32>>,
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
            calibration: Calibration::new(limits, encoders),
            slices: 0,
            estimator: HingeEstimator::new(rig.hinge(), HingeSettings::for_rig(rig.hinge())),
            rig: rig.clone(),
            poses: Set::new(),
            held_out: Set::new(),
            live: None,
            angles: None,
        }
    }

    /// Goes on after a power-down: in which boot, and from which run id on. Nothing has happened yet since power-up.
    pub fn resume_at(&mut self, boot: u16, last_run_id: u16) {
        self.calibration.resume_at(boot, last_run_id);
    }

    /// Takes over the hinge of an earlier run, of before the power was switched off.
    ///
    /// # Errors
    /// [`Reason::RecordUnfit`] when a number of it is none; there is no hinge in use then.
    pub fn resume(&mut self, live: ElbowCandidate) -> Result<(), Reason> {
        if !live.found.is_finite() {
            return Err(Reason::RecordUnfit);
        }
        if self.state() == StateName::Idle {
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
        self.calibration.set_wearer(wearer)
    }

    /// Takes in one sample of the board's counts. Every sample counts: silence is a fault.
    pub fn sample(&mut self, now_ms: u32, counts: &[i32; CABLES]) {
        let mut in_use = [0; CABLES];
        let pairs = in_use.iter_mut().zip(counts).take(usize::from(self.rig.cables()));
        pairs.for_each(|(own, count)| *own = *count);
        self.calibration.arm.sample(now_ms, &in_use, self.rig.drum());
        self.calibration.sampled(now_ms);
    }

    /// The machine.
    pub const fn rig(&self) -> &ElbowRig {
        &self.rig
    }

    /// The limits of a run.
    pub const fn limits(&self) -> &Limits {
        &self.calibration.limits
    }

    /// The state's name.
    pub const fn state(&self) -> StateName {
        self.calibration.name()
    }

    /// There is computing to do: the next tick should follow as soon as the board has time.
    pub const fn is_busy(&self) -> bool {
        matches!(self.calibration.state(), State::Identifying | State::Verifying(Verifying { judging: Some(_), .. }))
    }

    /// The run under way, or the last one; 0 before the first.
    pub const fn run_id(&self) -> u16 {
        self.calibration.run.id
    }

    /// Are poses captured by command only?
    pub const fn by_command_only(&self) -> bool {
        self.calibration.run.by_command_only
    }

    /// Whose arm the runs to come, or the one under way, are made for.
    pub const fn wearer(&self) -> u16 {
        self.calibration.wearer
    }

    /// The hinge in use.
    pub const fn live(&self) -> Option<&ElbowCandidate> {
        self.live.as_ref()
    }

    /// The new hinge that waits for a decision.
    pub const fn candidate(&self) -> Option<&ElbowCandidate> {
        self.calibration.candidate()
    }

    /// The hinge that the run has identified so far, verified or not.
    pub const fn found(&self) -> Option<&FoundHinge> {
        match self.calibration.state() {
            State::Verifying(verifying) => Some(&verifying.found),
            State::Review(candidate) => Some(&candidate.found),
            _ => None,
        }
    }

    /// Why the solver or the second set refused, last; None when neither did.
    pub const fn refusal(&self) -> Option<&Detail> {
        self.calibration.run.detail.as_ref()
    }

    /// How the last run ended; None while one is under way and before the first.
    pub const fn ending(&self) -> Option<&Ending> {
        self.calibration.ending.as_ref()
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
        self.calibration.arm.fault(now_ms)
    }

    /// The reason, if a count was lost since the last run began.
    pub fn lost_count(&self) -> Option<Reason> {
        self.calibration.arm.lost().map(|_| Reason::EncoderJumped)
    }

    /// Is the arm held still, with believable encoders and every cable at rest?
    ///
    /// # Errors
    /// What is in the way.
    pub fn arm(&self, now_ms: u32) -> Result<(), NotReady> {
        self.calibration.arm.ready(now_ms)
    }
}
