//! The paths, one after the other.

mod device;
mod in_use;
mod literal_form;
mod samples;
mod whole_runs;

use core::mem::size_of;

use glenoid::identification::zeros::{KnownZeros, UnknownZeros};
use glenoid::identification::{PoseBuffer, Solver, Survey};
use glenoid::kinematics::{CableLengths, Octahedron, Pivot, RigPoints};
use glenoid::watch::Watch;
use nalgebra::UnitQuaternion;

use super::held::{Part, WEIGHED, holds};
use super::measure::{self, Figures, Number};
use super::problem::{POSES, Problem};
use super::report;
use literal_form::Rows;

/// What the paths keep between their calls. All of it lies in static memory, as on the board: a solver that works in
/// slices cannot live on the stack.
pub struct Bench<T: Number> {
    problem: Problem<T>,
    solver: Option<Solver<T, POSES, KnownZeros>>,
    solver_with_zeros: Option<Solver<T, POSES, UnknownZeros<T>>>,
    survey: Option<Survey<T>>,
    geometry: Option<Geometry<T>>,
    watch: Option<Watch<T>>,
    /// What the watch looks at.
    motion: PoseBuffer<T, POSES>,
    /// Attitudes that tracking starts from, one a pose.
    before: [UnitQuaternion<T>; POSES],
    rows: Rows<T>,
}

/// What forward kinematics needs of the rig and the identified centre.
pub struct Geometry<T> {
    octahedron: Octahedron<T>,
    points: RigPoints<T>,
    pivot: Pivot<T>,
}

impl<T: Number> Bench<T> {
    pub fn new(problem: Problem<T>) -> Self {
        Self {
            // All made by the paths that want them: an image without those holds nothing of them.
            solver: None,
            solver_with_zeros: None,
            survey: None,
            geometry: None,
            watch: None,
            motion: PoseBuffer::new(),
            before: [UnitQuaternion::identity(); POSES],
            rows: Rows::new(),
            problem,
        }
    }

    fn poses(&self) -> &[CableLengths<T>] {
        self.problem.poses.as_slice()
    }
}

/// Calls every path of a part once, so that the image holds it. False when one failed.
fn call<T: Number>(bench: &mut Bench<T>) -> bool {
    let mut sound = true;
    if const { holds::<T>(Part::Paper) } {
        sound &= whole_runs::paper(bench).is_some();
    }
    if const { holds::<T>(Part::Free) } {
        sound &= whole_runs::start_free(bench).is_some();
    }
    if const { holds::<T>(Part::Zeros) } {
        sound &= whole_runs::zeros(bench).is_some();
    }
    if const { holds::<T>(Part::Samples) } {
        sound &= samples::new_survey(bench).is_some() && samples::survey(bench, 0).is_some();
        sound &= samples::geometry(bench).is_some();
        sound &= samples::octahedron(bench, 0).is_some() && samples::tracking(bench, 0).is_some();
    }
    if const { holds::<T>(Part::InUse) } {
        sound &= in_use::new_watch(bench).is_some() && in_use::watch(bench, 0).is_some();
        sound &= samples::verify(bench, 0).is_some();
    }
    sound
}

/// Measures every path that the image holds and prints each as soon as it is through. False when one failed.
pub fn run<T: Number>(bench: &mut Bench<T>) -> bool {
    if WEIGHED {
        return call(bench);
    }
    let truth = bench.problem.truth;
    // Always there: what measuring and printing take is then in every image alike.
    let mut sound = print::<T>("empty", measure::whole(bench, 0, &truth, whole_runs::empty));
    if const { holds::<T>(Part::Literal) } {
        sound &= print::<T>("literal", measure::whole(bench, size_of::<Rows<T>>(), &truth, literal_form::run));
    }
    if const { holds::<T>(Part::Paper) } {
        sound &= print::<T>("paper", measure::whole(bench, 0, &truth, whole_runs::paper));
    }
    if const { holds::<T>(Part::Free) } {
        let state = size_of::<Solver<T, POSES, KnownZeros>>();
        sound &= print::<T>("start-free", measure::whole(bench, state, &truth, whole_runs::start_free));
        sound &=
            print::<T>("start-free-slice", measure::pieces(bench, state, whole_runs::new_solver, whole_runs::slice));
    }
    if const { holds::<T>(Part::Zeros) } {
        let state = size_of::<Solver<T, POSES, UnknownZeros<T>>>();
        sound &= print::<T>("start-free-zeros", measure::whole(bench, state, &truth, whole_runs::zeros));
    }
    if const { holds::<T>(Part::Samples) } {
        let survey = size_of::<Survey<T>>();
        sound &= print::<T>("survey", measure::pieces(bench, survey, samples::new_survey, samples::survey));
        let octahedron = size_of::<Octahedron<T>>();
        sound &= print::<T>("octahedron", measure::pieces(bench, octahedron, samples::geometry, samples::octahedron));
        let arm = size_of::<Geometry<T>>();
        sound &= print::<T>("tracking", measure::pieces(bench, arm, samples::arm_before, samples::tracking));
    }
    if const { holds::<T>(Part::InUse) } {
        let watch = size_of::<Watch<T>>();
        sound &= print::<T>("watch", measure::pieces(bench, watch, in_use::new_watch, in_use::watch));
        sound &= print::<T>("verify", measure::pieces(bench, 0, samples::nothing, samples::verify));
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
