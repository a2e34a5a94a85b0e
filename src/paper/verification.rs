//! Verification on a second set of poses (step 4 of the paper's procedure, section III).

use super::model::{Contradiction, Model};
use crate::identification::outcome::{Refusal, rms_residual};
use crate::kinematics::{BaseEdges, CableLengths};
use crate::rig::{Parameters, Rig};
use crate::scalar::Real;

/// δE over poses that were not used to identify, mm.
///
/// # Errors
/// [`Refusal::TooFewPoses`] for an empty set, [`Refusal::BadLength`] or [`Refusal::NotClosing`] for a pose that
/// contradicts the parameters altogether.
pub fn verify<T: Real>(rig: &Rig<T>, parameters: &Parameters<T>, poses: &[CableLengths<T>]) -> Result<T, Refusal> {
    if poses.is_empty() {
        return Err(Refusal::TooFewPoses { poses: 0 });
    }
    let base = BaseEdges::new(rig);
    let model = Model::new(&base, rig.edges_mm(), parameters);
    let mut squares_mm2 = T::zero();
    for (index, lengths) in poses.iter().enumerate() {
        let pose = index as u32;
        let evaluated = model.evaluate(&base, lengths).map_err(|contradiction| match contradiction {
            Contradiction::Length(error) => Refusal::BadLength { pose, cable: error.cable, fault: error.fault },
            Contradiction::NotClosing(error) => Refusal::NotClosing { pose, end_point: error.end_point, iteration: 0 },
        })?;
        squares_mm2 += evaluated.squares_mm2();
    }
    Ok(rms_residual(squares_mm2, poses.len()))
}
