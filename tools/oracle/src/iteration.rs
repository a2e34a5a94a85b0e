//! The iteration of Fig. 4: model, deviation metric, least squares, update, until the metric is small.

use super::{Estimate, Failure, Lengths, Machine, least_squares, pose_model, root_mean_square};
use nalgebra::RealField;

/// The memory of one identification of `m` poses, supplied by the caller.
#[derive(Debug)]
pub struct Workspace<'a, T> {
    /// `D̃` of Eq. 14: at least `3m` rows.
    pub d: &'a mut [[T; 6]],
    /// `Ỹ` of Eq. 14: at least `3m` residues, in mm.
    pub y_mm: &'a mut [T],
    /// Receives `δE` of the start and of every estimate after it: at least one more than the cap on iterations, in mm.
    pub deviations_mm: &'a mut [T],
}

/// Why the iteration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// `δE < ε`.
    Converged,
    /// The cap on iterations was reached with `δE` still at or above `ε`.
    IterationCap,
    /// The model or the step could not be calculated at the last estimate.
    Failed(Failure),
}

/// What an identification left behind.
#[derive(Clone, Copy, Debug)]
pub struct Outcome<T: RealField + Copy> {
    /// The last estimate, also after a failure.
    pub estimate: Estimate<T>,
    /// Number of updates (Eq. 16) made.
    pub iterations: usize,
    /// Number of values in `deviations_mm`: one more than `iterations`, or as many when the model failed at the
    /// last estimate.
    pub deviations: usize,
    /// Why it ended.
    pub ending: Ending,
}

/// Fig. 4 from `start`, until `δE < epsilon_mm` or `cap` updates were made.
pub fn identify<T: RealField + Copy>(
    machine: &Machine<T>,
    poses_mm: &[Lengths<T>],
    start: Estimate<T>,
    epsilon_mm: T,
    cap: usize,
    workspace: &mut Workspace<'_, T>,
) -> Outcome<T> {
    let mut outcome = Outcome { estimate: start, iterations: 0, deviations: 0, ending: Ending::IterationCap };
    let rows = 3 * poses_mm.len();
    if workspace.d.len() < rows || workspace.y_mm.len() < rows || workspace.deviations_mm.len() <= cap {
        outcome.ending = Ending::Failed(Failure::TooLittleRoom);
        return outcome;
    }
    let d = &mut workspace.d[..rows];
    let y_mm = &mut workspace.y_mm[..rows];
    loop {
        if let Err(failure) = stack(machine, &outcome.estimate, poses_mm, d, y_mm) {
            outcome.ending = Ending::Failed(failure);
            return outcome;
        }
        let deviation = root_mean_square(y_mm);
        workspace.deviations_mm[outcome.deviations] = deviation;
        outcome.deviations += 1;
        if deviation < epsilon_mm {
            outcome.ending = Ending::Converged;
            return outcome;
        }
        if outcome.iterations == cap {
            return outcome;
        }
        match least_squares(d, y_mm) {
            Ok(x) => update(&mut outcome.estimate, &x),
            Err(failure) => {
                outcome.ending = Ending::Failed(failure);
                return outcome;
            }
        }
        outcome.iterations += 1;
    }
}

/// Eq. 14: the models of all poses one below the other.
fn stack<T: RealField + Copy>(
    machine: &Machine<T>,
    estimate: &Estimate<T>,
    poses_mm: &[Lengths<T>],
    d: &mut [[T; 6]],
    y_mm: &mut [T],
) -> Result<(), Failure> {
    for (pose, lengths) in poses_mm.iter().enumerate() {
        let model = pose_model(machine, estimate, lengths, pose)?;
        d[3 * pose..3 * pose + 3].copy_from_slice(&model.d);
        y_mm[3 * pose..3 * pose + 3].copy_from_slice(&model.y_mm);
    }
    Ok(())
}

/// Eq. 16.
fn update<T: RealField + Copy>(estimate: &mut Estimate<T>, x: &[T; 6]) {
    for axis in 0..3 {
        estimate.centre_mm[axis] += x[axis];
        estimate.radii_mm[axis] += x[3 + axis];
    }
}
