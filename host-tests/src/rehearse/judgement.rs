//! Holds what the board found against the truth, against the host's own calculation and against the encoders.

use super::charts::{self, Convergence, Descent};
use super::expected::{self, Expected};
use super::machine::KnownMachine;
use super::options::Options;
use super::replay;
use super::report::{Found, HostsView, Report, Status};
use super::restart;
use super::transcript::Transcript;
use super::verdict::Verdict;
use super::zeros;
use crate::wearer::Wearer;
use glenoid::can::result::Parameter;
use glenoid::identification::Refusal;
use glenoid::kinematics::CableLengths;
use glenoid::procedure::Settings;
use glenoid::rig::{CABLES, Rig, Tolerance};
use std::path::Path;

/// How far a length may be off what the encoders showed in the end, counts: an eighth of the band in which the arm counts as
/// still.
///
/// A pose is the mean of the counts since the arm came into the band. A minimum-jerk movement nears its end by a cube, and so
/// is a quarter of the band off on average; the hold that follows is at least as long as what is left of the movement.
fn most_counts_off(mm_per_count: f64) -> f64 {
    f64::from(Settings::default().still_band_mm) / mm_per_count / 8.0
}

/// Judges a calibration, and writes the plots into the folder `plots`, if there is one.
///
/// # Errors
/// Why it cannot be judged: the poses determine no centre, the host refuses what the board accepted, a plot cannot be
/// written.
pub fn judge(
    transcript: &Transcript,
    after_restart: &[Parameter; 6],
    wearer: &Wearer,
    known: &KnownMachine,
    options: &Options,
    plots: Option<&Path>,
) -> Result<Report, String> {
    let rotations: Vec<_> = transcript.identification.iter().map(|captured| captured.pose.rotation).collect();
    let length_sigma_mm = expected::length_sigma_mm(options.noise, wearer.encoder().mm_per_count());
    let rig = &known.double;
    // Homing is never better than its tolerance.
    let zero_prior_mm = options.zero_prior_mm().max(rig.tolerance().offset_mm);
    let tolerance = Tolerance { offset_mm: zero_prior_mm, ..*rig.tolerance() };
    let expected = Expected::new(rig, wearer.arm(), &rotations, length_sigma_mm, &tolerance)
        .ok_or("these poses do not determine the centre")?;
    let truth = wearer.truth();
    let verdict = Verdict::new(&transcript.parameters, &truth, expected.parameters);

    let lengths_mm: Vec<_> = transcript.identification.iter().map(|captured| captured.lengths_mm).collect();
    let taken: Vec<_> =
        transcript.identification.iter().map(|captured| (captured.lengths_mm, captured.samples)).collect();
    let refuses = |refusal: Refusal| format!("the host refuses the poses that the board accepted: {}", refusal.text());
    let single = replay::identify(&known.single, &taken, zero_prior_mm).map_err(refuses)?;
    let double = replay::identify(rig, &taken, zero_prior_mm).map_err(refuses)?;
    let host_difference_mm = replay::difference_mm(&transcript.parameters, &single.parameters);
    let length_difference_counts = length_difference_counts(transcript, rig);

    let mut reasons = verdict.objections();
    let zeros = zeros::judge(transcript, wearer, rig, zero_prior_mm, &expected.offsets, &mut reasons);
    if host_difference_mm != 0.0 {
        reasons.push(format!("host and board differ by {host_difference_mm:.1e} mm over the same lengths"));
    }
    if !(length_difference_counts <= most_counts_off(rig.drum().mm_per_count())) {
        let off = format!("{length_difference_counts:.2} counts");
        reasons.push(format!("the board used a length that is {off} off what the encoders showed"));
    }

    let (live, found) =
        (transcript.live_centre_mm.map(f32::to_bits), transcript.parameters.map(|p| p.value_mm.to_bits()));
    if live != found[..3] {
        reasons.push("the centre in use after the acceptance is not the one that was accepted".to_string());
    }
    if restart::differs(transcript, after_restart) {
        reasons.push("the centre in use after a restart is not the one that was accepted".to_string());
    }

    // The paper's method knows the 3-3 machine only.
    let is_three_three = rig.cables().is_none();
    let paper = match is_three_three {
        true => replay::identify_as_the_paper(rig, &double.parameters, &lengths_mm).ok(),
        false => None,
    };
    let convergence = Convergence { single: Descent::of(&single), double: Descent::of(&double), paper };
    let files = match plots {
        Some(folder) => charts::write(transcript, &convergence, options, folder).map_err(|error| error.to_string())?,
        None => Vec::new(),
    };
    let deviation_mm = is_three_three
        .then(|| replay::deviation_mm(rig, &transcript.parameters, &transcript.zeros_mm(), &lengths_mm))
        .transpose()
        .map_err(refuses)?;
    let hosts = HostsView {
        deviation_mm,
        deviations_mm: convergence.single.deviations_mm,
        difference_mm: host_difference_mm,
        length_difference_counts,
    };
    let found = Found::new(transcript, after_restart, &verdict, hosts, zeros);
    Ok(Report {
        status: if reasons.is_empty() { Status::Right } else { Status::Wrong },
        reasons,
        settings: options.into(),
        true_centre_mm: truth.centre_mm.into(),
        true_radii_mm: truth.radii_mm,
        found: Some(found),
        parameters_told: None,
        slip: None,
        shoulder: None,
        plots: files,
    })
}

/// Largest difference between a length that the board used and the one that the encoders showed, counts.
fn length_difference_counts(transcript: &Transcript, rig: &Rig<f64>) -> f64 {
    let mm_per_count = rig.drum().mm_per_count();
    let captured = transcript.identification.iter().chain(&transcript.verification);
    captured
        .flat_map(|captured| {
            let shown = CableLengths::from_counts(rig, &captured.pose.counts);
            let shown_mm = shown.map_or([f64::NAN; CABLES], |shown| *shown.as_mm());
            (0..CABLES).map(move |k| ((f64::from(captured.lengths_mm[k]) - shown_mm[k]) / mm_per_count).abs())
        })
        .fold(0.0, f64::max)
}
