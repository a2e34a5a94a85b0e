//! Two phases: first poses with the shoulder blade held, which fix the joint centre in the platform, then free ones.

use crate::estimation::estimate_poses;
use glenoid::identification::joint::{HeldCentre, MIN_HELD_POSES};
use glenoid::identification::{EstimatorSettings, Identified, JointChoice, Machine, Pose, Refusal};
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
    held: Vec<Pose<T>>,
) -> Result<HeldCentre<T>, Refusal> {
    if held.len() < MIN_HELD_POSES {
        return Err(Refusal::TooFewPoses { poses: held.len() as u32 });
    }
    let settings = EstimatorSettings { joint: JointChoice::Held, ..settings };
    let estimation = estimate_poses(machine, rig, settings, None, held);
    let _: &Identified<T> = &estimation.outcome?;
    estimation.estimator.held_centre().ok_or(Refusal::Singular)
}
