//! The calibration procedure: from the wish to calibrate to an accepted centre, with a person at the arm.
//!
//! ```text
//! Idle        --Start-->        Collecting
//! Idle        --Abort-->        Idle
//! Idle        --Acknowledge-->  Idle
//! Collecting  --Identify-->     Identifying
//! Collecting  --Timeout-->      Failed
//! Collecting  --CountLost-->    Failed
//! Collecting  --Abort-->        Idle
//! Identifying --Found-->        Verifying
//! Identifying --HeldFound-->    Collecting
//! Identifying --WantsMore-->    Collecting
//! Identifying --GaveUp-->       Failed
//! Identifying --Abort-->        Idle
//! Verifying   --Verified-->     Review
//! Verifying   --Contradicted--> Failed
//! Verifying   --Timeout-->      Failed
//! Verifying   --CountLost-->    Failed
//! Verifying   --Abort-->        Idle
//! Review      --Accept-->       Idle
//! Review      --Reject-->       Idle
//! Review      --Abort-->        Idle
//! Review      --Acknowledge-->  Review
//! Review      --Timeout-->      Failed
//! Failed      --Acknowledge-->  Idle
//! Failed      --Abort-->        Idle
//! ```
//!
//! These are all transitions; [`transition::next`] is the table that the code goes by, and a test holds it against
//! this picture. The live centre changes in one of them only, Accept. Time is passed in as milliseconds that may wrap.
//! Every state's time is watched here and nowhere else.

pub mod arm;
mod assess;
mod between_runs;
mod calibration;
pub mod captured;
mod capturing;
mod commands;
mod course;
pub mod elbow;
pub mod encoders;
pub mod guidance;
pub mod limits;
pub mod loose;
pub mod module;
pub mod outcome;
mod phase;
pub mod plausible;
mod progress;
pub mod reason;
mod reply;
pub mod slow_motion;
pub mod solve;
pub mod state;
pub mod stillness;
mod ticks;
pub mod transition;

pub use guidance::Guidance;
pub use limits::{Limits, LimitsError, Settings};
pub use module::{ModuleProcedure, ModuleRig};
pub use outcome::{Candidate, Ending, PoseNotice, Verification};
pub use plausible::Plausibility;
pub use reason::{Band, Reason};
pub use reply::Reply;
pub use state::{Command, PoseSet, StateName};
pub use transition::Trigger;

use crate::identification::estimator::PoseVerification;
use crate::identification::joint::ShownMotion;
use crate::identification::{Identified, Machine, Pose, PredictedAccuracy};
use crate::rig::{CABLES, Rig};
use arm::NotReady;
use assess::Assessing;
use calibration::{Calibration, State};
use captured::Captured;
use capturing::Capturing;
use course::Course;
use encoders::EncoderFault;
use guidance::Spread;
use phase::Phase;
use solve::{Detail, Work, is_refused_as_ball};

/// Poses that the first set has room for.
pub const CAPACITY: usize = crate::identification::DEFAULT_CAPACITY;
/// Poses that the second set has room for.
pub const HELD_OUT_CAPACITY: usize = 32;

/// The second set is being captured, or (with `judging`) laid against the centre.
#[derive(Debug, Clone)]
struct Verifying {
    identified: Identified<f32>,
    motion: Option<ShownMotion>,
    judging: Option<Judging>,
}

/// The poses of the second set are laid against the centre one after the other, a slice a tick.
#[derive(Debug, Clone, Copy)]
struct Judging {
    next: u8,
    verification: PoseVerification<f32>,
    squares_mm2: f32,
    chi_square: f32,
}

/// The procedure, with the poses of the run and the centre in use.
#[derive(Debug, Clone)]
pub struct Procedure {
    rig: Rig<f32>,
    calibration: Calibration<Verifying, Candidate>,
    course: Course,
    /// How well the encoder zeros are known in the runs to come, 1σ, mm; 0 = as the rig's tolerance says.
    zero_prior_mm: f32,
    work: Work,
    poses: Captured<CAPACITY>,
    held_out: Captured<HELD_OUT_CAPACITY>,
    spread: Spread,
    machine: Machine<f32>,
    accuracy: PredictedAccuracy<f32>,
    capturing: Option<Capturing>,
    /// To the command that the last capture began with, until it is taken.
    answer: Option<(Reason, u16)>,
    assessing: Option<Assessing>,
    /// Of the first set so far, mm; kept, for it is asked for with every heartbeat.
    predicted_sigma_mm: Option<f32>,
    /// The same with ten poses more.
    sigma_with_more_mm: Option<f32>,
    live: Option<Candidate>,
}

impl Procedure {
    /// A procedure in the idle state, without a centre.
    // Inlined so that it is built where it stays: 15 KB more of the stack otherwise (`cargo stack`).
    #[inline(always)]
    pub fn new(rig: Rig<f32>, limits: Limits) -> Self {
        let zero_prior_mm = limits.settings().zero_prior_mm;
        let machine = Machine::with_offset_prior(&rig, rig.offset_prior_mm(zero_prior_mm));
        Self {
            calibration: Calibration::new(limits, limits.encoders()),
            course: Course::new(false, false),
            work: Work::new(&machine, &rig),
            zero_prior_mm,
            accuracy: PredictedAccuracy::new(&machine, rig.nominal()),
            machine,
            capturing: None,
            answer: None,
            assessing: None,
            predicted_sigma_mm: None,
            sigma_with_more_mm: None,
            rig,
            poses: Captured::new(),
            held_out: Captured::new(),
            spread: Spread::default(),
            live: None,
        }
    }

    /// The limits of a run.
    pub const fn limits(&self) -> &Limits {
        &self.calibration.limits
    }

    /// Looks whether a centre can be one on this rig.
    #[cfg_attr(feature = "ccm", unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
    fn check_plausible(&self, identified: &Identified<f32>) -> Result<(), Detail> {
        let limits = &self.calibration.limits.settings().plausibility;
        limits.check(self.rig.nominal(), &identified.parameters, &identified.sigma_mm(), &identified.offsets_mm)
    }

    /// Poses in the first set before it can be good enough: more when the zeros must be found from them as well.
    fn enough_poses(&self) -> u8 {
        let settings = self.calibration.limits.settings();
        let of_ball = if self.zero_prior_mm > 0.0 { settings.enough_poses_with_zeros } else { settings.enough_poses };
        self.course.phase.enough_poses(of_ball, self.moves())
    }

    /// Has the solver found that the centre moves more than a ball's?
    fn moves(&self) -> bool {
        self.calibration.run.detail.is_some_and(|detail| is_refused_as_ball(detail.reason))
    }

    /// Is the shoulder blade to be held now: the first of two phases?
    pub const fn is_held_phase(&self) -> bool {
        matches!(self.course.phase, Phase::Held)
            && matches!(self.state(), StateName::Collecting | StateName::Identifying)
    }

    /// The machine as the estimator sees it.
    pub const fn machine(&self) -> &Machine<f32> {
        &self.machine
    }

    /// The machine.
    pub const fn rig(&self) -> &Rig<f32> {
        &self.rig
    }

    /// Takes in one sample of the six counts. Every sample counts: silence is a fault.
    pub fn sample(&mut self, now_ms: u32, counts: &[i32; CABLES]) {
        self.calibration.arm.sample(now_ms, counts, self.rig.drum());
        self.calibration.sampled(now_ms);
    }

    /// The state's name.
    pub const fn state(&self) -> StateName {
        self.calibration.name()
    }

    /// There is computing to do: the next tick should follow as soon as the board has time.
    pub const fn is_busy(&self) -> bool {
        self.capturing.is_some()
            || self.assessing.is_some()
            || matches!(
                self.calibration.state(),
                State::Identifying | State::Verifying(Verifying { judging: Some(_), .. })
            )
    }

    /// The run under way, or the last one; 0 before the first.
    pub const fn run_id(&self) -> u16 {
        self.calibration.run.id
    }

    /// Are poses captured by command only?
    pub const fn by_command_only(&self) -> bool {
        self.calibration.run.by_command_only
    }

    /// The centre in use, to spoil it as memory can.
    #[cfg(test)]
    pub(crate) fn live_mut(&mut self) -> &mut Option<Candidate> {
        &mut self.live
    }

    /// What it goes by, to spoil it as memory can.
    #[cfg(test)]
    pub(crate) fn spoil_constants(&mut self, rig: Rig<f32>, limits: Limits) {
        (self.rig, self.calibration.limits) = (rig, limits);
    }

    /// The centre in use.
    pub const fn live(&self) -> Option<&Candidate> {
        self.live.as_ref()
    }

    /// The new centre that waits for a decision.
    pub const fn candidate(&self) -> Option<&Candidate> {
        self.calibration.candidate()
    }

    /// The centre that the run has identified so far, verified or not.
    pub const fn identified(&self) -> Option<&Identified<f32>> {
        match self.calibration.state() {
            State::Verifying(verifying) => Some(&verifying.identified),
            State::Review(candidate) => Some(&candidate.identified),
            _ => None,
        }
    }

    /// How that centre moves with the arm; None for a ball, and while there is no such centre.
    pub const fn motion(&self) -> Option<&ShownMotion> {
        match self.calibration.state() {
            State::Verifying(verifying) => verifying.motion.as_ref(),
            State::Review(candidate) => candidate.motion.as_ref(),
            _ => None,
        }
    }

    /// How the last run ended; None while one is under way and before the first.
    pub const fn ending(&self) -> Option<&Ending> {
        self.calibration.ending.as_ref()
    }

    /// Why the solver refused the set, last; None when it did not.
    pub const fn refusal(&self) -> Option<&Detail> {
        self.calibration.run.detail.as_ref()
    }

    /// Predicted σ of the centre in its worst direction with the first set so far, mm; None while the poses do not
    /// determine it.
    pub const fn predicted_sigma_mm(&self) -> Option<f32> {
        self.predicted_sigma_mm
    }

    /// The captured poses of a set. They stay until the next run starts, unless the run is aborted.
    pub fn poses(&self, set: PoseSet) -> &[Pose<f32>] {
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
