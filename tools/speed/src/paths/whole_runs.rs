//! Identifications from beginning to end.

use core::borrow::Borrow;

use glenoid::identification::{Estimator, EstimatorSettings, Identified, Machine, Pose, Progress, Refusal};
use glenoid::paper::{PaperIteration, PaperSettings};
use glenoid::rig::Tolerance;

use super::{Bench, Held};
use crate::measure::{Answer, Number};
use crate::problem::{Spoilt, of_shoulder};

/// How well the encoders' offsets are known where nobody has homed them, 1σ, mm.
const OFFSET_PRIOR_MM: f64 = 10.0;

/// Nothing at all.
#[inline(never)]
pub fn empty<T: Number>(bench: &mut Bench<T>) -> Option<Answer<T>> {
    Some(Answer { parameters: bench.problem.truth, steps: 0 })
}

/// The paper's path: from the start estimate until δE < 1e-3 mm, with the covariance at the end. Its state is on the
/// stack: nothing keeps it after the run.
#[inline(never)]
pub fn paper<T: Number>(bench: &mut Bench<T>) -> Option<Answer<T>> {
    let problem = &bench.problem;
    let mut paper = PaperIteration::new(&problem.rig, problem.start, PaperSettings::default());
    loop {
        if let Some(answer) = answer(paper.advance(&problem.poses)) {
            return answer.ok();
        }
    }
}

/// A machine that is exactly known, and poses without noise.
pub fn exact<T: Number>(bench: &mut Bench<T>) -> Option<()> {
    set(bench, Tolerance::exact(), Spoilt::No)
}

/// Noise on every length.
pub fn noise<T: Number>(bench: &mut Bench<T>) -> Option<()> {
    set(bench, Tolerance::exact(), Spoilt::Noise)
}

/// The same, and one bad pose.
pub fn outlier<T: Number>(bench: &mut Bench<T>) -> Option<()> {
    set(bench, Tolerance::exact(), Spoilt::Outliers(1))
}

/// The same, and a fifth of the poses bad: as many as may be.
pub fn outliers<T: Number>(bench: &mut Bench<T>) -> Option<()> {
    set(bench, Tolerance::exact(), Spoilt::Outliers(20))
}

/// The offsets of all six encoders unknown by 10 mm.
pub fn offsets<T: Number>(bench: &mut Bench<T>) -> Option<()> {
    set(bench, Tolerance { offset_mm: T::of(OFFSET_PRIOR_MM), ..Tolerance::exact() }, Spoilt::No)
}

/// A machine built by hand: points and edges to half a millimetre, homed to 0.3 mm, drums to a tenth of a per cent.
pub fn tolerances<T: Number>(bench: &mut Bench<T>) -> Option<()> {
    set(bench, hand_built(), Spoilt::Noise)
}

/// That machine's tolerances.
pub fn hand_built<T: Number>() -> Tolerance<T> {
    let half = T::of(0.5);
    Tolerance { base_mm: half, edges_mm: half, offset_mm: T::of(0.3), drum: T::of(1e-3) }
}

/// The hand-built machine on a shoulder whose centre moves.
pub fn shoulder<T: Number>(bench: &mut Bench<T>) -> Option<()> {
    tolerances(bench)?;
    take_shoulder(bench)
}

/// An exact machine on it.
pub fn shoulder_on_exact<T: Number>(bench: &mut Bench<T>) -> Option<()> {
    exact(bench)?;
    take_shoulder(bench)
}

#[inline(never)]
fn take_shoulder<T: Number>(bench: &mut Bench<T>) -> Option<()> {
    let lengths = of_shoulder(&bench.problem, &bench.machine)?;
    bench.poses.clear();
    lengths.into_iter().try_for_each(|lengths| bench.poses.push(Pose::new(lengths)).ok().map(|_| ()))
}

/// The estimator at its beginning on it.
pub fn new_estimator_of_shoulder<T: Number>(bench: &mut Bench<T>) -> Option<()> {
    shoulder(bench)?;
    begin(bench);
    Some(())
}

// Not inlined: the machine passes through its frame on its way to its place.
#[inline(never)]
fn set<T: Number>(bench: &mut Bench<T>, tolerance: Tolerance<T>, spoilt: Spoilt) -> Option<()> {
    bench.machine = Machine::new(&bench.problem.rig.with_tolerance(tolerance).ok()?);
    bench.poses.clear();
    for lengths in bench.problem.spoilt(spoilt)? {
        bench.poses.push(Pose::new(lengths)).ok()?;
    }
    bench.held = Held::Nothing;
    Some(())
}

/// From raw lengths to centre, weights and covariance.
#[inline(never)]
pub fn start_free<T: Number>(bench: &mut Bench<T>) -> Option<Answer<T>> {
    begin(bench);
    let Bench { held: Held::Estimator(estimator), machine, poses, .. } = bench else { return None };
    loop {
        if let Some(answer) = answer(estimator.advance(machine, poses.as_mut_slice())) {
            return answer.ok();
        }
    }
}

/// The estimator at its beginning.
pub fn new_estimator<T: Number>(bench: &mut Bench<T>) -> Option<()> {
    exact(bench)?;
    begin(bench);
    Some(())
}

/// The same for a machine with tolerances.
pub fn new_estimator_with_tolerances<T: Number>(bench: &mut Bench<T>) -> Option<()> {
    tolerances(bench)?;
    begin(bench);
    Some(())
}

// Not inlined: the estimator passes through its frame on its way to its place.
#[inline(never)]
fn begin<T: Number>(bench: &mut Bench<T>) {
    let rig = &bench.problem.rig;
    bench.held = Held::Estimator(Estimator::new(&bench.machine, rig.nominal(), EstimatorSettings::for_rig(rig)));
}

/// One slice: what it keeps a board from doing anything else.
#[inline(never)]
pub fn slice<T: Number>(bench: &mut Bench<T>, _: usize) -> Option<bool> {
    let Bench { held: Held::Estimator(estimator), machine, poses, .. } = bench else { return None };
    match answer(estimator.advance(machine, poses.as_mut_slice())) {
        None => Some(true),
        Some(Ok(_)) => Some(false),
        Some(Err(_)) => None,
    }
}

/// What a slice ended with, if it ended the run.
fn answer<T: Number>(progress: Progress<impl Borrow<Identified<T>>>) -> Option<Result<Answer<T>, Refusal>> {
    match progress {
        Progress::Working => None,
        Progress::Identified(identified) => {
            let Identified { parameters, iterations, .. } = identified.borrow();
            Some(Ok(Answer { parameters: *parameters, steps: *iterations }))
        }
        Progress::Refused(refusal) => Some(Err(refusal)),
    }
}
