//! The paths, one after the other.

mod device;
mod elbow;
mod in_use;
mod literal_form;
mod samples;
mod whole_runs;

use core::mem::size_of;

use glenoid::identification::hinge::HingeEstimator;
use glenoid::identification::{Estimator, Machine, PoseBuffer, PredictedAccuracy};
use glenoid::kinematics::{CableLengths, JointCentre, PlatformSolver};
use glenoid::monitor::SlipDetector;
use heapless::Vec;
use nalgebra::UnitQuaternion;

use super::held::{Part, WEIGHED, holds};
use super::measure::{self, Figures, Number};
use super::problem::{POSES, Problem};
use super::report;
use literal_form::Rows;

/// What the paths keep between their calls. All of it lies in static memory, as on the board: an estimator that works in
/// slices cannot live on the stack.
pub struct Bench<T: Number> {
    problem: Problem<T>,
    machine: Machine<T>,
    poses: PoseBuffer<T, POSES>,
    held: Held<T>,
    centre: JointCentre<T>,
    /// What the slip detector looks at.
    motion: Vec<CableLengths<T>, POSES>,
    /// Attitudes that tracking starts from, one a pose.
    before: [UnitQuaternion<T>; POSES],
}

/// The state of the path that is measured: of one at a time, for not all of them fit the board's memory together in double
/// precision.
#[allow(clippy::large_enum_variant)]
pub enum Held<T: Number> {
    Nothing,
    Literal(Rows<T>),
    Estimator(Estimator<T>),
    Accuracy(PredictedAccuracy<T>),
    Detector(SlipDetector<T>),
    Elbow(elbow::Elbow<T>),
}

impl<T: Number> Bench<T> {
    pub fn new(problem: Problem<T>) -> Self {
        let machine = Machine::new(&problem.rig);
        Self {
            centre: JointCentre::from_parameters(&problem.truth, machine.geometry()),
            machine,
            poses: PoseBuffer::new(),
            // Made by the paths that want it: an image without those holds nothing of it.
            held: Held::Nothing,
            motion: Vec::new(),
            before: [UnitQuaternion::identity(); POSES],
            problem,
        }
    }
}

/// Nothing to prepare.
fn nothing<T: Number>(_: &mut Bench<T>) -> Option<()> {
    Some(())
}

/// Calls every path of a part once, so that the image holds it. False when one failed.
fn call<T: Number>(bench: &mut Bench<T>) -> bool {
    let mut sound = true;
    if const { holds::<T>(Part::Paper) } {
        sound &= whole_runs::paper(bench).is_some();
    }
    if const { holds::<T>(Part::Free) } {
        sound &= whole_runs::exact(bench).is_some() && whole_runs::start_free(bench).is_some();
    }
    if const { holds::<T>(Part::Machine) } {
        sound &= whole_runs::tolerances(bench).is_some() && whole_runs::start_free(bench).is_some();
    }
    if const { holds::<T>(Part::Samples) } {
        sound &= samples::new_accuracy(bench).is_some() && samples::accuracy(bench, 0).is_some();
        sound &= samples::forward_kinematics(bench, 0).is_some() && samples::tracking(bench, 0).is_some();
        sound &= samples::following(bench, 0).is_some();
    }
    if const { holds::<T>(Part::InUse) } {
        sound &= in_use::new_detector(bench).is_some() && in_use::detect(bench, 0).is_some();
        sound &= samples::new_verification(bench).is_some() && samples::verify(bench, 0).is_some();
    }
    sound
}

/// Measures an elbow. False when a path failed.
fn run_elbow<T: Number>(bench: &mut Bench<T>) -> bool {
    let truth = bench.problem.truth;
    let state = size_of::<HingeEstimator<T>>();
    let mut sound = print::<T>("elbow", measure::whole(bench, state, &truth, elbow::exact, elbow::identify));
    sound &= print::<T>("elbow-slice", measure::pieces(bench, state, elbow::exact, elbow::slice));
    sound &= print::<T>("elbow-outliers-slice", measure::pieces(bench, state, elbow::outliers, elbow::slice));
    sound & print::<T>("elbow-machine-slice", measure::pieces(bench, state, elbow::machine, elbow::slice))
}

/// Measures every path that the image holds and prints each as soon as it is through. False when one failed.
pub fn run<T: Number>(bench: &mut Bench<T>) -> bool {
    if WEIGHED {
        return call(bench);
    }
    let truth = bench.problem.truth;
    // Always there: what measuring and printing take is then in every image alike.
    let mut sound = print::<T>("empty", measure::whole(bench, 0, &truth, nothing, whole_runs::empty));
    if const { holds::<T>(Part::Literal) } {
        let rows = size_of::<Rows<T>>();
        sound &= print::<T>("literal", measure::whole(bench, rows, &truth, literal_form::prepare, literal_form::run));
    }
    if const { holds::<T>(Part::Paper) } {
        sound &= print::<T>("paper", measure::whole(bench, 0, &truth, nothing, whole_runs::paper));
    }
    let estimator = size_of::<Estimator<T>>() + size_of::<Machine<T>>();
    if const { holds::<T>(Part::Free) } {
        for (name, begin) in [
            ("start-free", whole_runs::exact as fn(&mut Bench<T>) -> Option<()>),
            ("start-free-noise", whole_runs::noise),
            ("start-free-outlier", whole_runs::outlier),
            ("start-free-outliers", whole_runs::outliers),
        ] {
            sound &= print::<T>(name, measure::whole(bench, estimator, &truth, begin, whole_runs::start_free));
        }
        let slices = measure::pieces(bench, estimator, whole_runs::new_estimator, whole_runs::slice);
        sound &= print::<T>("start-free-slice", slices);
    }
    if const { holds::<T>(Part::Machine) } {
        for (name, begin) in [
            ("start-free-offsets", whole_runs::offsets as fn(&mut Bench<T>) -> Option<()>),
            ("start-free-machine", whole_runs::tolerances),
            ("shoulder", whole_runs::shoulder_on_exact),
            ("shoulder-machine", whole_runs::shoulder),
        ] {
            sound &= print::<T>(name, measure::whole(bench, estimator, &truth, begin, whole_runs::start_free));
        }
        let slices = measure::pieces(bench, estimator, whole_runs::new_estimator_with_tolerances, whole_runs::slice);
        sound &= print::<T>("start-free-machine-slice", slices);
        let slices = measure::pieces(bench, estimator, whole_runs::new_estimator_of_shoulder, whole_runs::slice);
        sound &= print::<T>("shoulder-machine-slice", slices);
    }
    if const { holds::<T>(Part::Samples) } {
        let accuracy = size_of::<PredictedAccuracy<T>>();
        let exact = measure::pieces(bench, accuracy, samples::new_accuracy, samples::accuracy);
        sound &= print::<T>("predicted-accuracy", exact);
        let machine = measure::pieces(bench, accuracy, samples::new_accuracy_with_tolerances, samples::accuracy);
        sound &= print::<T>("predicted-accuracy-machine", machine);
        let platform = size_of::<PlatformSolver<T>>();
        let kinematics = measure::pieces(bench, platform, whole_runs::exact, samples::forward_kinematics);
        sound &= print::<T>("forward-kinematics", kinematics);
        let centre = size_of::<JointCentre<T>>();
        sound &= print::<T>("tracking", measure::pieces(bench, centre, samples::attitudes_before, samples::tracking));
        let follow = measure::pieces(bench, centre, samples::attitudes_just_before, samples::following);
        sound &= print::<T>("following", follow);
    }
    if const { holds::<T>(Part::Elbow) } {
        sound &= run_elbow(bench);
    }
    if const { holds::<T>(Part::InUse) } {
        let detector = size_of::<SlipDetector<T>>();
        sound &= print::<T>("slip-detection", measure::pieces(bench, detector, in_use::new_detector, in_use::detect));
        sound &= print::<T>("verify", measure::pieces(bench, 0, samples::new_verification, samples::verify));
    }
    sound
}

/// Measures what an event costs the whole device. False when the calibration did not end as it should.
#[inline(never)]
pub fn run_device(problem: &Problem<f32>) -> bool {
    if const { !holds::<f32>(Part::Device) } {
        return true;
    }
    let Some(costs) = device::costs(problem) else {
        report::failed("device", f32::NAME);
        return false;
    };
    for (name, figures) in costs {
        report::path(name, f32::NAME, &figures);
    }
    true
}

fn print<T: Number>(name: &str, figures: Option<Figures>) -> bool {
    match &figures {
        Some(figures) => report::path(name, T::NAME, figures),
        None => report::failed(name, T::NAME),
    }
    figures.is_some()
}
