//! The estimator: from lengths to a hinge with its covariance, or a refusal that names its cause.
//!
//! ```text
//! Begin    --sound-->        Search
//! Begin    --refused-->      Done
//! Search   --candidates-->   Judge
//! Search   --none-->         Done
//! Judge    --noise-->        Bend
//! Judge    --otherwise-->    Outliers
//! Outliers --left out-->     Bend
//! Outliers --no hinge-->     Second
//! Outliers --nothing fits--> Explain
//! Outliers --refused-->      Done
//! Second   --refused-->      Done
//! Explain  --refused-->      Done
//! Bend     --enough-->       Report
//! Bend     --refused-->      Done
//! Report   --finished-->     Compare
//! Report   --refused-->      Done
//! Compare  --other-->        Report
//! Compare  --accurate-->     Profile
//! Compare  --refused-->      Done
//! Profile  --true-->         Isolate
//! Profile  --refused-->      Done
//! Isolate  --isolated-->     Done
//! ```
//!
//! Every call of [`HingeEstimator::advance`] does a bounded slice of work.

mod compare;
mod explain;
mod input;
mod leave_out;
mod outliers;
mod profile;
mod report;
mod search;
mod stage;
mod work;

use self::compare::{Compare, Compared};
use self::explain::Explain;
use self::outliers::{Left, Outliers};
use self::profile::Profile;
use self::report::Report;
use self::search::Search;
pub use self::stage::{StageName, may_follow};
use self::work::{LAST_TRIALS, Work};
use super::judge::{self, Flexion, Isolation};
use super::pose::{HingePose, MAX_UNKNOWNS};
use super::refusal::HingeRefusal;
use super::result::IdentifiedHinge;
use super::rig::HingeRig;
use super::second_axis::SecondAxisSearch;
use super::settings::HingeSettings;
use crate::identification::settings::Noise;
use crate::scalar::Real;

/// The estimator of a hinge, resumable: each call of [`advance`](Self::advance) does a bounded slice of work, mostly that of
/// one pose. The poses stay with the caller.
#[derive(Clone, Debug)]
pub struct HingeEstimator<T: Real> {
    stage: Stage<T>,
    pub(super) work: Work<T>,
}

/// Where the estimator stands.
#[derive(Clone, Debug)]
enum Stage<T: Real> {
    /// Is the input sound?
    Begin,
    /// The hinges that the starts lead to.
    Search(Search<T>),
    /// Does the best of them explain the poses?
    Judge,
    /// Poses that contradict the others are left out.
    Outliers(Outliers<T>),
    /// The poses left refuse the hinge: is there a second axis?
    Second(SecondAxisSearch<T>),
    /// Why nothing fits.
    Explain(Explain<T>),
    /// Does the joint bend enough?
    Bend(Flexion<T>),
    /// The result, and what it is to be compared with afterwards, unless nothing was yet.
    Report(Report<T>, Option<Compare<T>>),
    /// Another hinge that fits as well?
    Compare(Compare<T>),
    /// Is the covariance true?
    Profile(Profile<T>),
    /// Fault isolation.
    Isolate(Isolation),
    /// The result stands, or a refusal.
    Done(Result<(), HingeRefusal>),
}

/// What a slice ended with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HingeProgress<'a, T: Real> {
    /// There is more to do.
    Working,
    /// The hinge.
    Identified(&'a IdentifiedHinge<T>),
    /// Why there is none.
    Refused(HingeRefusal),
}

impl<T: Real> HingeEstimator<T> {
    /// An estimator at its beginning.
    pub fn new(rig: &HingeRig<T>, settings: HingeSettings<T>) -> Self {
        Self { stage: Stage::Begin, work: Work::new(rig, settings) }
    }

    /// Back to the beginning, in place.
    pub fn restart(&mut self) {
        self.stage = Stage::Begin;
        self.work.stop();
        self.work.fit.noise_mm = self.work.rig.length_noise_mm();
        self.work.fit.held = None;
    }

    /// Identifies the hinge, from the beginning to the end. The poses get their angles, χ² and weights.
    ///
    /// # Errors
    /// The [`HingeRefusal`] that names the cause.
    pub fn run(&mut self, poses: &mut [HingePose<T>]) -> Result<IdentifiedHinge<T>, HingeRefusal> {
        self.restart();
        loop {
            match self.advance(poses) {
                HingeProgress::Working => {}
                HingeProgress::Identified(found) => return Ok(found.clone()),
                HingeProgress::Refused(refusal) => return Err(refusal),
            }
        }
    }

    /// One slice of work. `poses` must be the same in every call.
    pub fn advance(&mut self, poses: &mut [HingePose<T>]) -> HingeProgress<'_, T> {
        if !self.work.advance(poses)
            && let Some(next) = self.next(poses)
        {
            debug_assert!(may_follow(self.stage.name(), next.name()), "{:?} to {:?}", self.stage.name(), next.name());
            // The only place where the stage is assigned, but for a restart.
            self.stage = next;
        }
        match &self.stage {
            Stage::Done(Ok(())) => HingeProgress::Identified(&self.work.found),
            Stage::Done(Err(refusal)) => HingeProgress::Refused(*refusal),
            _ => HingeProgress::Working,
        }
    }

    /// Column `unknown` of the covariance of all unknowns, for a noise of 1 mm: the hinge's, then the machine's.
    pub fn covariance_column(&self, unknown: usize) -> [T; MAX_UNKNOWNS] {
        self.work.fit.equations.covariance_column(unknown, 0)
    }

    /// The name of the present stage.
    pub fn stage(&self) -> StageName {
        self.stage.name()
    }

    /// A slice of the stage's own work; the next stage at its end.
    fn next(&mut self, poses: &mut [HingePose<T>]) -> Option<Stage<T>> {
        let refused = |refusal| Stage::Done(Err(refusal));
        let Self { stage, work } = self;
        Some(match stage {
            Stage::Begin => match input::require_input(work, poses) {
                Ok(()) => {
                    poses.iter_mut().for_each(|pose| pose.weight = T::one());
                    if let Noise::Known(noise) = work.settings.noise {
                        work.fit.noise_mm = noise;
                    }
                    Stage::Search(Search::new())
                }
                Err(refusal) => refused(refusal),
            },
            Stage::Search(search) => {
                if !search.advance(work, poses) {
                    return None;
                }
                let Some(best) = work.candidates.first().copied() else {
                    return Some(refused(HingeRefusal::NotAHinge { residual_mm: f32::INFINITY }));
                };
                work.go_to(&best);
                Stage::Judge
            }
            Stage::Judge if judge::are_noise(&work.fit, poses, work.settings.noise) => Stage::Bend(Flexion::new()),
            Stage::Judge => Stage::Outliers(Outliers::new()),
            Stage::Outliers(outliers) => match outliers.advance(work, poses)? {
                Left::Hinge => Stage::Bend(Flexion::new()),
                Left::NoHinge => Stage::Second(SecondAxisSearch::new(&work.fit)),
                Left::Nothing(outliers) => Stage::Explain(Explain::new(outliers)),
                Left::Refused(refusal) => refused(refusal),
            },
            Stage::Second(search) => {
                let second = search.advance(&work.fit, &mut work.scratch.equations, poses)?;
                refused(judge::no_hinge(&work.fit, poses, work.settings.noise, second.as_ref()))
            }
            Stage::Explain(explain) => refused(explain.advance(work, poses)?),
            Stage::Bend(flexion) => {
                let range = flexion.advance(poses)?;
                if let Err(refusal) = judge::require_flexion(range, &work.settings) {
                    return Some(refused(refusal));
                }
                if let Noise::EstimatedUpTo(_) = work.settings.noise {
                    // The priors weigh against the noise that there is.
                    let of_rig = work.rig.length_noise_mm();
                    work.fit.noise_mm = judge::noise_of_result_mm(&work.fit, poses, work.settings.noise, of_rig);
                    work.minimise(LAST_TRIALS, false);
                }
                Stage::Report(Report::new(), None)
            }
            Stage::Report(report, compare) => match report.advance(work, poses)? {
                Ok(()) => Stage::Compare((*compare).unwrap_or_else(|| Compare::new(work))),
                Err(refusal) => refused(refusal),
            },
            Stage::Compare(compare) => match compare.advance(work)? {
                Compared::Stands => match work.found.require_accuracy(&work.settings) {
                    Ok(()) => Stage::Profile(Profile::new()),
                    Err(refusal) => refused(refusal),
                },
                Compared::Other => Stage::Report(Report::new(), Some(*compare)),
                Compared::Refused(refusal) => refused(refusal),
            },
            Stage::Profile(profile) => match profile.advance(work)? {
                Ok(()) => Stage::Isolate(Isolation::new()),
                Err(refusal) => refused(refusal),
            },
            Stage::Isolate(isolation) => {
                if !isolation.advance(&work.fit, poses) {
                    return None;
                }
                Stage::Done(Ok(()))
            }
            Stage::Done(_) => return None,
        })
    }
}
