//! Two phases: first poses with the shoulder blade held, which fix the joint centre in the platform, then free ones.

use crate::estimation::{Estimation, estimate_poses};
use glenoid::identification::joint::{HeldCentre, MIN_HELD_POSES};
use glenoid::identification::{EstimatorSettings, JointChoice, Machine, Noise, Pose, Refusal};
use glenoid::rig::Rig;
use glenoid::scalar::Real;

/// Noise of a length that takes in what the head scatters in its socket while the blade is held, mm: what a ball leaves out
/// beyond it was misread.
const SCATTER_AS_NOISE_MM: f64 = 0.5;
/// At most one held pose in so many is called misread; with more, it is the blade.
const MAX_MISREAD: usize = 4;

/// What the held poses give.
pub struct HeldPhase<T> {
    /// The joint centre in the platform, or why there is none.
    pub centre: Result<HeldCentre<T>, Refusal>,
    /// The poses, from 0, that the fit has left out; of a refusal those without which the others would do.
    pub left_out: Vec<usize>,
}

/// The joint centre in the platform from held poses.
///
/// # Errors
/// The estimator's [`Refusal`].
pub fn identify<T: Real>(
    machine: &Machine<T>,
    rig: &Rig<T>,
    settings: EstimatorSettings<T>,
    held: Vec<Pose<T>>,
) -> Result<HeldCentre<T>, Refusal> {
    run(machine, rig, settings, held).centre
}

/// The same, with the poses that are left out.
pub fn run<T: Real>(
    machine: &Machine<T>,
    rig: &Rig<T>,
    settings: EstimatorSettings<T>,
    held: Vec<Pose<T>>,
) -> HeldPhase<T> {
    if held.len() < MIN_HELD_POSES {
        let refusal = Refusal::TooFewPoses { poses: held.len() as u32 };
        return HeldPhase { centre: Err(refusal), left_out: Vec::new() };
    }
    let estimation = fit(machine, rig, settings, held.clone());
    match estimation.outcome {
        Ok(_) => HeldPhase {
            left_out: unused(&estimation),
            centre: estimation.estimator.held_centre().ok_or(Refusal::Singular),
        },
        Err(refusal) => HeldPhase { left_out: misread(machine, rig, settings, held), centre: Err(refusal) },
    }
}

fn fit<T: Real>(
    machine: &Machine<T>,
    rig: &Rig<T>,
    settings: EstimatorSettings<T>,
    held: Vec<Pose<T>>,
) -> Estimation<T> {
    estimate_poses(machine, rig, EstimatorSettings { joint: JointChoice::Held, ..settings }, None, held)
}

fn unused<T: Real>(estimation: &Estimation<T>) -> Vec<usize> {
    estimation.poses.iter().enumerate().filter(|(_, pose)| !pose.is_used()).map(|(index, _)| index).collect()
}

/// The poses without which the held phase is accepted, where a ball that may scatter a little leaves them out. Empty when
/// there are none.
fn misread<T: Real>(
    machine: &Machine<T>,
    rig: &Rig<T>,
    settings: EstimatorSettings<T>,
    held: Vec<Pose<T>>,
) -> Vec<usize> {
    let (count, noise) = (held.len(), Noise::Known(T::of(SCATTER_AS_NOISE_MM)));
    let ball = EstimatorSettings { joint: JointChoice::Ball, noise, ..settings };
    let estimation = estimate_poses(machine, rig, ball, None, held.clone());
    let misread = unused(&estimation);
    if estimation.outcome.is_err() || misread.is_empty() || misread.len() > count / MAX_MISREAD {
        return Vec::new();
    }
    let rest: Vec<_> = held.into_iter().enumerate().filter(|(index, _)| !misread.contains(index)).collect();
    let rest: Vec<_> = rest.into_iter().map(|(_, pose)| pose).collect();
    let is_enough = rest.len() >= MIN_HELD_POSES && fit(machine, rig, settings, rest).outcome.is_ok();
    if is_enough { misread } else { Vec::new() }
}
