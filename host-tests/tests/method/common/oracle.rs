//! Runs the literal iteration in memory of its own.

use host_tests::literal::{Estimate, Lengths, Machine, Outcome, Workspace, identify};
use nalgebra::RealField;

/// The outcome and `δE` of the start and of every estimate after it.
pub fn run<T: RealField + Copy>(
    machine: &Machine<T>,
    poses: &[Lengths<T>],
    start: Estimate<T>,
    epsilon_mm: T,
    cap: usize,
) -> (Outcome<T>, Vec<T>) {
    let mut d = vec![[T::zero(); 6]; 3 * poses.len()];
    let mut y = vec![T::zero(); 3 * poses.len()];
    let mut deviations = vec![T::zero(); cap + 1];
    let mut workspace = Workspace { d: &mut d, y_mm: &mut y, deviations_mm: &mut deviations };
    let outcome = identify(machine, poses, start, epsilon_mm, cap, &mut workspace);
    deviations.truncate(outcome.deviations);
    (outcome, deviations)
}
