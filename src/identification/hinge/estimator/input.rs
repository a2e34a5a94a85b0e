//! What is wrong with the poses before anything is computed.

use super::work::Work;
use crate::identification::hinge::joint::{AXIS, AXIS_IN_PLATFORM, FOOT, FOOT_IN_PLATFORM};
use crate::identification::hinge::judge::MIN_POSES;
use crate::identification::hinge::pose::HingePose;
use crate::identification::hinge::refusal::{HingePart, HingeRefusal};
use crate::identification::settings::Noise;
use crate::kinematics::LengthFault;
use crate::linear_algebra::non_negative_root;
use crate::scalar::Real;

/// Lengths that vary by less than this, in standard deviations of the noise, show no motion.
const NO_MOTION: f64 = 4.0;
/// Fewer than four cables follow a drawing, which must be as good as this, 1σ: about a vaguer one the problem is too far from
/// linear for a standard deviation to be true.
const VAGUE_RAD: f64 = 0.07;
const VAGUE_MM: f64 = 4.0;

/// Refuses what cannot be identified from.
///
/// # Errors
/// The [`HingeRefusal`] that names the cause.
pub fn require_input<T: Real>(work: &Work<T>, poses: &[HingePose<T>]) -> Result<(), HingeRefusal> {
    let cables = work.rig.cables().len();
    require_lengths(poses, cables)?;
    if cables < 4 {
        require_drawing(work, cables)?;
    }
    if poses.len() < MIN_POSES {
        return Err(HingeRefusal::TooFewPoses { poses: poses.len() as u32, wanted: MIN_POSES as u32 });
    }
    let spread = (0..cables).map(|cable| spread(poses, cable)).fold(T::zero(), |most, next| most.max(next));
    let noise = match work.settings.noise {
        Noise::Known(noise) => noise,
        Noise::EstimatedUpTo(_) => work.rig.length_noise_mm(),
    };
    if spread < noise * T::of(NO_MOTION) {
        return Err(HingeRefusal::TooLittleFlexion { range_rad: 0.0 });
    }
    Ok(())
}

fn require_lengths<T: Real>(poses: &[HingePose<T>], cables: usize) -> Result<(), HingeRefusal> {
    for (index, pose) in poses.iter().enumerate() {
        for (cable, length) in pose.lengths_mm.iter().enumerate().take(cables) {
            let fault = if !length.is_a_number() {
                LengthFault::NotFinite
            } else if *length <= T::zero() {
                LengthFault::NotPositive
            } else {
                continue;
            };
            return Err(HingeRefusal::BadLength { pose: index as u32, cable: cable as u8 + 1, fault });
        }
    }
    Ok(())
}

/// Fewer than four cables need a drawing, and a good one.
fn require_drawing<T: Real>(work: &Work<T>, cables: usize) -> Result<(), HingeRefusal> {
    let Some((_, sigma)) = work.fit.prior() else {
        // Two cables determine five combinations of the nine, three determine eight.
        let determined = if cables == 2 { 5 } else { 8 };
        return Err(HingeRefusal::TooFewCables { cables: cables as u8, determined });
    };
    let vague = |part, of: usize, limit: f64| {
        let sigma = sigma.get(of).copied().unwrap_or_else(T::zero);
        if sigma > T::of(limit) { Err(HingeRefusal::Weak { part, sigma: sigma.to_f32() }) } else { Ok(()) }
    };
    vague(HingePart::Axis, AXIS, VAGUE_RAD)?;
    vague(HingePart::AxisInPlatform, AXIS_IN_PLATFORM, VAGUE_RAD)?;
    vague(HingePart::Place, FOOT, VAGUE_MM)?;
    vague(HingePart::PlaceInPlatform, FOOT_IN_PLATFORM, VAGUE_MM)
}

/// Standard deviation of the lengths of a cable (from 0), mm.
fn spread<T: Real>(poses: &[HingePose<T>], cable: usize) -> T {
    let count = T::of_integer(poses.len().max(1) as i32);
    let length = |pose: &HingePose<T>| pose.lengths_mm.get(cable).copied().unwrap_or_else(T::zero);
    let mean = poses.iter().fold(T::zero(), |sum, pose| sum + length(pose)) / count;
    let squares = poses.iter().fold(T::zero(), |sum, pose| sum + (length(pose) - mean) * (length(pose) - mean));
    non_negative_root(squares / count)
}
