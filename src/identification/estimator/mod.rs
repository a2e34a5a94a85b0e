//! The start-free estimator: from raw lengths to a joint centre with a standard deviation, or a refusal that names its
//! cause.
//!
//! ```text
//! Place   --placed-->    Refine
//! Place   --singular-->  Excite
//! Place   --moving-->    Excite
//! Place   --refused-->   Done
//! Refine  --otherwise--> Refine
//! Refine  --converged--> Excite
//! Refine  --refused-->   Done
//! Excite  --accepted-->  Check
//! Excite  --not fixed--> Refine
//! Excite  --moving-->    Refine
//! Excite  --refused-->   Done
//! Refine  --explained--> Compare
//! Compare --moving-->    Refine
//! Compare --refused-->   Done
//! Refine  --compared-->  Inspect
//! Refine  --held-->      Check
//! Inspect --accepted-->  Check
//! Inspect --refused-->   Done
//! Check   --redundant--> Isolate
//! Check   --refused-->   Done
//! Isolate --isolated-->  Done
//! ```
//!
//! 1. **Place**: forward kinematics give each pose's rotation R and origin t without knowing the centre. The centre is
//!    fixed in both bodies, O = R C + t, which is linear in O and C: pivot calibration (SCoRE) starts everything.
//! 2. **Refine**: Gauss-Newton with each pose's marginal information (see
//!    [`marginal_information`](super::marginal_information)); the pose's own rotation is refined on the way. This is
//!    the maximum a posteriori estimate; its covariance is the inverse of the summed information. When the residuals
//!    are larger than the noise, poses are weighted down by their χ² (graduated non-convexity) until those that
//!    contradict the others stand out, and are left out.
//! 3. **Excite**: do the rotations determine the centre? Then the gate of accuracy. When the residuals refuse a fixed
//!    centre and there are poses enough, Refine begins again with a centre that moves with the arm.
//! 4. **Compare**: would a ball on another machine explain as much? **Inspect**: the gates of a moving centre: a slip between
//!    two poses, residuals, accuracy.
//! 5. **Check**: would the result stand without any one of few poses, or without the one that makes most of the
//!    excitation? (Leave-one-out.)
//! 6. **Isolate**: for each pose left out, which cable, if ignored, makes it fit the centre? (Fault isolation.)
//!
//! Every call of [`Estimator::advance`] does a bounded slice of work.

mod carry;
mod check;
mod compare;
mod excite;
mod fit;
mod inspect;
mod isolate;
mod model;
mod moving;
mod place;
mod refine;
mod result;
mod scratch;
mod seen;
mod seen_pose;
mod stage;
mod verify;

use self::check::Check;
use self::compare::Compare;
use self::excite::{Excite, Purpose};
use self::fit::Fit;
use self::inspect::Inspect;
use self::isolate::Isolate;
pub use self::model::Model;
use self::place::Place;
use self::refine::{Plan, Refine};
use self::result::Accepted;
pub use self::scratch::Scratch;
pub use self::stage::{StageName, may_follow};
pub use self::verify::PoseVerification;
pub use super::gates::{MIN_POSES, MIN_POSES_AFTER_REJECTION};
use super::joint::{HeldCentre, Joint};
use super::machine::{Machine, MachineEstimate};
use super::outcome::{Identified, Progress, Refusal};
use super::parameters::{Equations, MAX_UNKNOWNS};
use super::pose::Pose;
use super::settings::{EstimatorSettings, JointChoice};
use crate::kinematics::JointCentre;
use crate::rig::Parameters;
use crate::scalar::Real;

/// Where the estimator stands; every stage carries its data.
// A tag of one byte would leave the data of a stage unaligned, and copies of it byte by byte: with that of the steps, 2.6 KB of
// flash and a hundredth of the time.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Debug)]
#[repr(u32)]
enum Stage<T: Real> {
    /// Placing poses, and the pivot calibration of those placed.
    Place(Place<T>),
    /// Gauss-Newton.
    Refine(Refine<T>),
    /// Rotational excitation.
    Excite(Excite<T>),
    /// Is it the machine that looks like a moving centre?
    Compare(Compare<T>),
    /// The gates of a moving centre.
    Inspect(Inspect<T>),
    /// Leave-one-out.
    Check(Check<T>),
    /// Fault isolation of the poses left out.
    Isolate(Isolate<T>),
    /// The result stands, or a refusal.
    Done(Result<(), Refusal>),
}

/// The stage to go to, and what it begins with: some bytes, where a stage is up to 1.4 KB that would be moved twice (6 000
/// instructions of `cargo cycles --profile start-free-slice --worst`).
#[derive(Clone, Copy, Debug)]
enum Next<T> {
    Refine(Plan<T>),
    Excite(Purpose),
    Compare,
    Inspect,
    Check(Accepted),
    Isolate,
    Done(Result<(), Refusal>),
}

/// The estimator, resumable: each call of [`advance`](Self::advance) does a bounded slice of work, at most the placing
/// of one pose. The poses stay with the caller.
#[derive(Clone, Debug)]
pub struct Estimator<T: Real> {
    stage: Stage<T>,
    fit: Fit<T>,
}

/// What an estimator computes in, lent to others while no estimation is under way: it is too large to be there twice.
#[derive(Debug)]
pub struct Workspace<'a, T: Real> {
    /// Normal equations.
    pub equations: &'a mut Equations<T>,
    /// A pose that is being added to them.
    pub scratch: &'a mut Scratch<T>,
}

impl<T: Real> Estimator<T> {
    /// An estimator at its beginning. `nominal`: where the centre is expected, only to fill the result until it is
    /// known.
    pub fn new(machine: &Machine<T>, nominal: &Parameters<T>, settings: EstimatorSettings<T>) -> Self {
        Self { stage: Stage::Place(Place::default()), fit: Fit::new(machine, nominal, settings.sound()) }
    }

    /// Back to the beginning, in place: the estimator is too large to be built on a small stack a second time.
    pub fn restart(&mut self, machine: &Machine<T>) {
        self.stage = Stage::Place(Place::default());
        self.fit.restart(machine);
    }

    /// Back to the beginning, for another model of the joint, and with what a held phase has found.
    pub fn restart_for(&mut self, machine: &Machine<T>, joint: JointChoice, held: Option<HeldCentre<T>>) {
        self.restart(machine);
        self.fit.settings.joint = joint;
        self.fit.held = held;
    }

    /// The joint centre in the platform is known from a held phase: a prior for a moving centre.
    pub fn set_held(&mut self, held: HeldCentre<T>) {
        self.fit.held = Some(held);
    }

    /// What it computes in. Changed, the covariances of its last result are gone.
    pub fn workspace(&mut self) -> Workspace<'_, T> {
        Workspace { equations: &mut self.fit.equations, scratch: &mut self.fit.scratch }
    }

    /// Runs to the end.
    ///
    /// # Errors
    /// The [`Refusal`] that names the cause.
    pub fn run(&mut self, machine: &Machine<T>, poses: &mut [Pose<T>]) -> Result<Identified<T>, Refusal> {
        loop {
            match self.advance(machine, poses) {
                Progress::Working => {}
                Progress::Identified(identified) => return Ok(identified.clone()),
                Progress::Refused(refusal) => return Err(refusal),
            }
        }
    }

    /// One slice of work. `machine` and `poses` must be the same in every call.
    pub fn advance(&mut self, machine: &Machine<T>, poses: &mut [Pose<T>]) -> Progress<&Identified<T>> {
        if poses.len() < MIN_POSES {
            return Progress::Refused(Refusal::TooFewPoses { poses: poses.len() as u32 });
        }
        let fit = &mut self.fit;
        let next = match &mut self.stage {
            Stage::Place(place) => place.advance(fit, machine, poses),
            Stage::Refine(refine) => refine.advance(fit, machine, poses),
            Stage::Excite(excite) => excite.advance(fit, machine, poses),
            Stage::Compare(compare) => compare.advance(fit, machine, poses),
            Stage::Inspect(inspect) => inspect.advance(fit, machine, poses),
            Stage::Check(check) => check.advance(fit, machine, poses),
            Stage::Isolate(isolate) => isolate.advance(fit, machine, poses),
            Stage::Done(_) => None,
        };
        if let Some(next) = next {
            let before = self.stage.name();
            self.go(next, machine, poses);
            debug_assert!(may_follow(before, self.stage.name()), "{before:?} to {:?}", self.stage.name());
        }
        match &self.stage {
            Stage::Done(Ok(())) => Progress::Identified(&self.fit.result),
            Stage::Done(Err(refusal)) => Progress::Refused(*refusal),
            _ => Progress::Working,
        }
    }

    /// The only place where the stage is assigned: each is built where it stays.
    fn go(&mut self, next: Next<T>, machine: &Machine<T>, poses: &[Pose<T>]) {
        match next {
            Next::Refine(plan) => self.stage = Stage::Refine(Refine::new(plan)),
            Next::Excite(purpose) => self.stage = Stage::Excite(Excite::new(purpose)),
            Next::Compare => self.stage = Stage::Compare(Compare::new(&self.fit, machine)),
            Next::Inspect => self.stage = Stage::Inspect(Inspect::new(poses)),
            Next::Check(accepted) => self.stage = Stage::Check(Check::new(accepted)),
            Next::Isolate => self.stage = Stage::Isolate(Isolate::default()),
            Next::Done(outcome) => self.stage = Stage::Done(outcome),
        }
    }

    /// Gauss-Newton steps taken so far.
    pub fn iterations(&self) -> u8 {
        self.fit.result.rms_residuals_mm.len() as u8
    }

    /// The name of the present stage.
    pub fn stage(&self) -> StageName {
        self.stage.name()
    }

    /// The joint centre in both bodies at the present estimate, mm.
    pub fn centre(&self) -> &JointCentre<T> {
        &self.fit.centre
    }

    /// What the held phase has found, once this estimator (set to [`JointChoice::Held`]) has
    /// come to a result: the joint centre in the platform for the free phase.
    pub fn held_centre(&self) -> Option<HeldCentre<T>> {
        match (&self.stage, &self.fit.joint) {
            (Stage::Done(Ok(())), Joint::Held(scatter)) => {
                let of_fit = self.centre_in_platform();
                Some(HeldCentre::new(of_fit.in_platform_mm, &of_fit.covariance_mm2, scatter.sigma_mm()))
            }
            _ => None,
        }
    }

    /// C and its covariance by the last fit.
    pub fn centre_in_platform(&self) -> HeldCentre<T> {
        self.fit.centre_in_platform()
    }

    /// The joint's model, as it is estimated.
    pub fn joint(&self) -> &Joint<T> {
        &self.fit.joint
    }

    /// Column `unknown` of the covariance of all unknowns, for a noise of 1 mm, in the order: the machine's constants,
    /// the joint's, O, C.
    pub fn covariance_column(&self, unknown: usize) -> [T; MAX_UNKNOWNS] {
        self.fit.equations.covariance_column(unknown, 0)
    }

    /// 1σ of the path of a moving centre over the poses, across the arm and in all, mm; 0 for a ball.
    pub fn path_sigmas_mm(&self) -> [T; 2] {
        self.fit.path_sigmas_mm
    }

    /// The machine's constants as they are estimated.
    pub fn machine_estimate(&self) -> &MachineEstimate<T> {
        &self.fit.estimate
    }
}
