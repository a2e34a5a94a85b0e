//! The paper as it is printed, for comparison: the very source that the host tests hold the library against, with its
//! stacked rows in static memory.

use super::Bench;
use crate::measure::{Answer, Number};
use crate::problem::POSES;
use glenoid::rig::Parameters;
use paper_oracle::{Ending, Estimate, Machine, Workspace};

/// Four steps are needed.
const STEP_CAP: usize = 20;
const EPSILON_MM: f64 = 1e-3;

/// D~ and Y~ (Eq. 14).
pub struct Rows<T> {
    d: [[T; 6]; 3 * POSES],
    y_mm: [T; 3 * POSES],
    deviations_mm: [T; STEP_CAP + 1],
}

impl<T: Number> Rows<T> {
    pub fn new() -> Self {
        let zero = T::zero();
        Self { d: [[zero; 6]; 3 * POSES], y_mm: [zero; 3 * POSES], deviations_mm: [zero; STEP_CAP + 1] }
    }
}

#[inline(never)]
pub fn run<T: Number>(bench: &mut Bench<T>) -> Option<Answer<T>> {
    let problem = &bench.problem;
    let machine = Machine { base_mm: *problem.rig.base_mm(), edges_mm: *problem.rig.edges_mm() };
    let start = Estimate { centre_mm: problem.start.centre_mm, radii_mm: problem.start.radii_mm };
    let Rows { d, y_mm, deviations_mm } = &mut bench.rows;
    let mut workspace = Workspace { d, y_mm, deviations_mm };
    let outcome =
        paper_oracle::identify(&machine, &problem.lengths_mm, start, T::of(EPSILON_MM), STEP_CAP, &mut workspace);
    let parameters = Parameters { centre_mm: outcome.estimate.centre_mm, radii_mm: outcome.estimate.radii_mm };
    (outcome.ending == Ending::Converged).then_some(Answer { parameters, steps: outcome.iterations as u8 })
}
