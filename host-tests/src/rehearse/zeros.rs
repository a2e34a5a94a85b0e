//! The encoder zeros that the board found, beside the true ones.

use super::transcript::Transcript;
use crate::wearer::Wearer;
use glenoid::rig::{CABLES, Rig};
use serde::Serialize;

/// An error may be this many times its expected standard deviation, and this much more, mm: as for the centre.
const SIGMAS: f64 = 5.0;
const GRANTED_MM: f64 = 0.05;

/// The zero errors of the six encoders: what each length reads too much, mm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Zeros {
    /// As the board found them.
    pub zeros_mm: [f64; CABLES],
    /// Standard deviations that the board states.
    pub zero_sigmas_mm: [f64; CABLES],
    /// As they are.
    pub true_zeros_mm: [f64; CABLES],
}

/// Holds the zeros against the truth; objections go to `reasons`. None when the board took the zeros for known, as it
/// must when `prior_mm` is 0 and must not when it is more.
pub(super) fn judge(
    transcript: &Transcript,
    wearer: &Wearer,
    rig: &Rig<f64>,
    prior_mm: f64,
    expected_sigma_mm: &[f64; CABLES],
    reasons: &mut Vec<String>,
) -> Option<Zeros> {
    let Some(found) = transcript.zeros else {
        if prior_mm > 0.0 {
            reasons.push("the board reports no encoder zeros, though they were set as unknown".to_string());
        }
        return None;
    };
    // Offsets that are known are reported as zero, exactly.
    if prior_mm == 0.0 && found.iter().any(|zero| zero.value_mm != 0.0 || zero.sigma_mm != 0.0) {
        reasons.push("the board reports encoder zeros, though they were set as known".to_string());
    }
    if prior_mm == 0.0 {
        return None;
    }
    let zeros = Zeros {
        zeros_mm: found.map(|zero| f64::from(zero.value_mm)),
        zero_sigmas_mm: found.map(|zero| f64::from(zero.sigma_mm)),
        // What the board knows of them already is taken off the readings.
        true_zeros_mm: std::array::from_fn(|k| {
            wearer.encoder().offsets_mm()[k] - rig.correction().map_or(0.0, |known| known.offset_mm[k])
        }),
    };
    for k in 0..CABLES {
        let (error, tolerance) =
            (zeros.zeros_mm[k] - zeros.true_zeros_mm[k], SIGMAS * expected_sigma_mm[k] + GRANTED_MM);
        // NaN is never right.
        if !(error.abs() <= tolerance) {
            let cable = k + 1;
            reasons.push(format!("the zero of cable {cable} is off by {error:+.3} mm, more than {tolerance:.3} mm"));
        }
    }
    Some(zeros)
}
