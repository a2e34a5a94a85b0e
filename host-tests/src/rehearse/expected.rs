//! How exact an identification can be expected to be, from what is known of the wearer and nothing that the board says.

use glenoid::identification::{PaperIteration, PaperSettings, Refusal};
use glenoid::kinematics::CableLengths;
use glenoid::rig::{CABLES, Parameters, Rig};

/// A change of one length by which the change of the result is measured, mm. Small against the geometry (the result
/// is linear in it to 1e-4), large against rounding.
const STEP_MM: f64 = 0.01;

/// Standard deviation of one cable length, mm: uniform noise within ±`noise_mm`, and rounding to whole counts.
pub fn length_sigma_mm(noise_mm: f64, mm_per_count: f64) -> f64 {
    // A uniform distribution of full width w has the standard deviation w / sqrt(12).
    (2.0 * noise_mm).hypot(mm_per_count) / 12f64.sqrt()
}

/// Standard deviations of x, y, z, p1, p2, p3, mm, that lengths with a standard deviation of `length_sigma_mm` lead
/// to: the paper's least squares is run again with each single length changed, and the changes of its result are
/// added up in squares. `spans_mm` are the exact lengths.
///
/// # Errors
/// The library's [`Refusal`], when the poses do not determine the centre.
pub fn sigma_mm(
    rig: &Rig<f64>,
    truth: Parameters<f64>,
    spans_mm: &[[f64; CABLES]],
    length_sigma_mm: f64,
) -> Result<[f64; 6], Refusal> {
    let mut lengths_mm = spans_mm.to_vec();
    let mut variances = [0.0; 6];
    for pose in 0..spans_mm.len() {
        for cable in 0..CABLES {
            let mut shifted = |by_mm: f64| {
                lengths_mm[pose][cable] = spans_mm[pose][cable] + by_mm;
                let result = identify_from(rig, truth, &lengths_mm);
                lengths_mm[pose][cable] = spans_mm[pose][cable];
                result
            };
            let (more, less) = (shifted(STEP_MM)?.to_array(), shifted(-STEP_MM)?.to_array());
            for (variance, (more, less)) in variances.iter_mut().zip(more.into_iter().zip(less)) {
                *variance += ((more - less) / (2.0 * STEP_MM) * length_sigma_mm).powi(2);
            }
        }
    }
    Ok(variances.map(f64::sqrt))
}

/// The least-squares centre nearest to `start`.
fn identify_from(
    rig: &Rig<f64>,
    start: Parameters<f64>,
    lengths_mm: &[[f64; CABLES]],
) -> Result<Parameters<f64>, Refusal> {
    let settings = PaperSettings { tolerance_mm: 1e-9, ..PaperSettings::default() };
    let lengths: Result<Vec<_>, _> = lengths_mm.iter().map(|lengths| CableLengths::new(*lengths)).collect();
    let lengths =
        lengths.map_err(|error| Refusal::BadLength { pose: 0, cable: error.cable, fault: error.fault })?;
    PaperIteration::new(rig, start, settings).run(&lengths).map(|identified| identified.parameters)
}
