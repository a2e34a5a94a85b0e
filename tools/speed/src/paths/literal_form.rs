//! The paper as it is printed, for comparison: the very source that the host tests hold the library against, with its
//! stacked rows in static memory.

use super::{Bench, Held};
use crate::measure::{Answer, Number};
use crate::problem::POSES;
use glenoid::rig::{CABLES, Parameters};
use paper_oracle::{Ending, Estimate, Machine, Workspace};

/// Four steps are needed.
const STEP_CAP: usize = 20;
const EPSILON_MM: f64 = 1e-3;

/// D~ and Y~ (Eq. 14), and the lengths as the literal form takes them.
pub struct Rows<T> {
    d: [[T; 6]; 3 * POSES],
    y_mm: [T; 3 * POSES],
    deviations_mm: [T; STEP_CAP + 1],
    lengths_mm: [[T; CABLES]; POSES],
}

/// Rows that are empty.
#[inline(never)]
pub fn prepare<T: Number>(bench: &mut Bench<T>) -> Option<()> {
    let zero = T::zero();
    let mut lengths_mm = [[zero; CABLES]; POSES];
    lengths_mm.iter_mut().zip(&bench.problem.poses).for_each(|(row, pose)| *row = *pose.as_mm());
    bench.held = Held::Literal(Rows {
        d: [[zero; 6]; 3 * POSES],
        y_mm: [zero; 3 * POSES],
        deviations_mm: [zero; STEP_CAP + 1],
        lengths_mm,
    });
    Some(())
}

#[inline(never)]
pub fn run<T: Number>(bench: &mut Bench<T>) -> Option<Answer<T>> {
    let problem = &bench.problem;
    let machine = Machine { base_mm: *problem.rig.base_mm(), edges_mm: *problem.rig.edges_mm() };
    let start = Estimate { centre_mm: problem.start.centre_mm, radii_mm: problem.start.radii_mm };
    let Held::Literal(Rows { d, y_mm, deviations_mm, lengths_mm }) = &mut bench.held else { return None };
    let mut workspace = Workspace { d, y_mm, deviations_mm };
    let outcome = paper_oracle::identify(&machine, lengths_mm, start, T::of(EPSILON_MM), STEP_CAP, &mut workspace);
    let parameters = Parameters { centre_mm: outcome.estimate.centre_mm, radii_mm: outcome.estimate.radii_mm };
    (outcome.ending == Ending::Converged).then_some(Answer { parameters, steps: outcome.iterations as u8 })
}
