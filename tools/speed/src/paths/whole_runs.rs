//! Identifications from beginning to end.

use core::borrow::Borrow;

use glenoid::identification::zeros::Zeros;
use glenoid::identification::{Identified, PaperIteration, PaperSettings, Progress, Refusal, Solver, SolverSettings};

use super::Bench;
use crate::measure::{Answer, Number};
use crate::problem::{POSES, Problem};

/// How well the encoders' zeros are known where nobody has homed them, 1σ, mm.
const ZERO_PRIOR_MM: f64 = 10.0;

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
    let poses = problem.poses.as_slice();
    let mut paper = PaperIteration::new(&problem.rig, problem.start, PaperSettings::default());
    loop {
        if let Some(answer) = answer(paper.advance(poses)) {
            return answer.ok();
        }
    }
}

/// The start-free path: from raw lengths to centre, weights and covariance.
#[inline(never)]
pub fn start_free<T: Number>(bench: &mut Bench<T>) -> Option<Answer<T>> {
    begin(&bench.problem, &mut bench.solver, T::zero());
    finish(&bench.problem, bench.solver.as_mut()?)
}

/// The same with the zeros of all six encoders unknown by 10 mm.
#[inline(never)]
pub fn zeros<T: Number>(bench: &mut Bench<T>) -> Option<Answer<T>> {
    begin(&bench.problem, &mut bench.solver_with_zeros, T::of(ZERO_PRIOR_MM));
    finish(&bench.problem, bench.solver_with_zeros.as_mut()?)
}

/// The start-free solver at its beginning.
pub fn new_solver<T: Number>(bench: &mut Bench<T>) -> Option<()> {
    begin(&bench.problem, &mut bench.solver, T::zero());
    Some(())
}

// Not inlined: the solver passes through its frame on its way to its place.
#[inline(never)]
fn begin<T: Number, Z: Zeros<T>>(problem: &Problem<T>, slot: &mut Option<Solver<T, POSES, Z>>, zero_prior_mm: T) {
    let settings = SolverSettings { zero_prior_mm, ..SolverSettings::for_rig(&problem.rig) };
    *slot = Some(Solver::new(&problem.rig, settings));
}

fn finish<T: Number, Z: Zeros<T>>(problem: &Problem<T>, solver: &mut Solver<T, POSES, Z>) -> Option<Answer<T>> {
    let poses = problem.poses.as_slice();
    loop {
        if let Some(answer) = answer(solver.advance(poses)) {
            return answer.ok();
        }
    }
}

/// One slice of the start-free path: what it keeps a board from doing anything else.
#[inline(never)]
pub fn slice<T: Number>(bench: &mut Bench<T>, _: usize) -> Option<bool> {
    let solver = bench.solver.as_mut()?;
    match answer(solver.advance(bench.problem.poses.as_slice())) {
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
