//! Two phases: first poses with the shoulder blade held, which fix the joint centre in the platform, then free ones.

use crate::estimation::{Estimation, estimate_with_held};
use glenoid::identification::joint::HeldCentre;
use glenoid::identification::{EstimatorSettings, Identified, JointChoice, Machine, Refusal};
use glenoid::kinematics::CableLengths;
use glenoid::rig::Rig;
use glenoid::scalar::Real;

/// Minimum number of poses of a held phase.
const MIN_HELD_POSES: usize = 8;

/// Squared Mahalanobis distance between the joint centres of held and free poses beyond which they belong to two
/// wearings: of one wearing at most 8 in 400.
const MAX_DISTANCE: f64 = 12.0;

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

/// The estimation of the free poses with what the held ones gave, unless the two contradict each other.
pub fn estimate<T: Real>(
    machine: &Machine<T>,
    rig: &Rig<T>,
    settings: EstimatorSettings<T>,
    held: Option<HeldCentre<T>>,
    poses: &[CableLengths<T>],
) -> Estimation<T> {
    let alone = estimate_with_held(machine, rig, settings, None, poses);
    let Some(held) = held else { return alone };
    if alone.outcome.is_ok() {
        let free = alone.estimator.centre_in_platform();
        let distance = held.in_platform_mm - free.in_platform_mm;
        let covariance = held.covariance_mm2 + free.covariance_mm2;
        let squared =
            covariance.try_inverse().map_or(f64::INFINITY, |inverse| distance.dot(&(inverse * distance)).to_f64());
        if squared > MAX_DISTANCE {
            let distance_mm = distance.norm().to_f32();
            return Estimation { outcome: Err(Refusal::HeldOfAnotherWearing { distance_mm }), ..alone };
        }
    }
    estimate_with_held(machine, rig, settings, Some(held), poses)
}
