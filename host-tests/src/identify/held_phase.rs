//! Two phases: first poses with the shoulder blade held, which fix the joint centre in the platform, then free ones.

use crate::estimation::{Estimation, estimate_with_held};
use glenoid::identification::joint::{HeldCentre, MIN_HELD_POSES};
use glenoid::identification::{EstimatorSettings, Identified, JointChoice, Machine, Refusal};
use glenoid::kinematics::CableLengths;
use glenoid::rig::Rig;
use glenoid::scalar::Real;

/// The joint centre in the platform from held poses.
///
/// # Errors
/// The estimator's [`Refusal`].
pub fn identify<T: Real>(
    machine: &Machine<T>,
    rig: &Rig<T>,
    settings: EstimatorSettings<T>,
    held: &[CableLengths<T>],
) -> Result<HeldCentre<T>, Refusal> {
    if held.len() < MIN_HELD_POSES {
        return Err(Refusal::TooFewPoses { poses: held.len() as u32 });
    }
    let settings = EstimatorSettings { joint: JointChoice::Held, ..settings };
    let estimation = estimate_with_held(machine, rig, settings, None, held);
    let _: &Identified<T> = &estimation.outcome?;
    estimation.estimator.held_centre().ok_or(Refusal::Singular)
}

/// The estimation of the free poses with what the held ones gave.
pub fn estimate<T: Real>(
    machine: &Machine<T>,
    rig: &Rig<T>,
    settings: EstimatorSettings<T>,
    held: Option<HeldCentre<T>>,
    poses: &[CableLengths<T>],
) -> Estimation<T> {
    estimate_with_held(machine, rig, settings, held, poses)
}
