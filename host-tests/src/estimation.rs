//! The library's estimator run to its end on a list of lengths.

use glenoid::identification::joint::HeldCentre;
use glenoid::identification::{Estimator, EstimatorSettings, Identified, Machine, Pose, Progress, Refusal};
use glenoid::kinematics::CableLengths;
use glenoid::rig::Rig;
use glenoid::scalar::Real;

/// An estimator at its end, with the poses that it has worked on.
pub struct Estimation<T: Real> {
    /// The result, or why there is none.
    pub outcome: Result<Identified<T>, Refusal>,
    /// The estimator.
    pub estimator: Estimator<T>,
    /// The poses, each with its state, rotation and χ².
    pub poses: Vec<Pose<T>>,
}

/// Runs the estimator slice by slice, as the device does.
pub fn estimate<T: Real>(
    machine: &Machine<T>,
    rig: &Rig<T>,
    settings: EstimatorSettings<T>,
    lengths: &[CableLengths<T>],
) -> Estimation<T> {
    estimate_poses(machine, rig, settings, None, lengths.iter().copied().map(Pose::new).collect())
}

/// The same of poses, each with the noise of its own; after a held phase, if there was one.
pub fn estimate_poses<T: Real>(
    machine: &Machine<T>,
    rig: &Rig<T>,
    settings: EstimatorSettings<T>,
    held: Option<HeldCentre<T>>,
    mut poses: Vec<Pose<T>>,
) -> Estimation<T> {
    let mut estimator = Estimator::new(machine, rig.nominal(), settings);
    if let Some(held) = held {
        estimator.set_held(held);
    }
    let outcome = loop {
        match estimator.advance(machine, &mut poses) {
            Progress::Working => {}
            Progress::Identified(identified) => break Ok(identified.clone()),
            Progress::Refused(refusal) => break Err(refusal),
        }
    };
    Estimation { outcome, estimator, poses }
}
