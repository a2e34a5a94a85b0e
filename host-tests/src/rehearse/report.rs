//! What a rehearsal found, for people (text) and for programs (JSON).

use super::options::Options;
use super::shoulder_report::ShoulderReport;
use super::slip::SlipReport;
use super::transcript::Transcript;
use super::verdict::{NAMES, Verdict};
use super::zeros::Zeros;
use glenoid::can::result::Parameter;
use glenoid::rig::Parameters;
use serde::Serialize;
use std::fmt;
use std::path::PathBuf;

/// How the rehearsal ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// The board identified the centre, and it is right.
    Right,
    /// The board identified a centre, and it is wrong.
    Wrong,
    /// There is no centre.
    Failed,
}

/// Everything that a rehearsal found. Arrays of six are x, y, z, p1, p2, p3.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// How it ended.
    pub status: Status,
    /// Why it did not end right; one entry for each objection.
    pub reasons: Vec<String>,
    /// What was asked for.
    pub settings: Settings,
    /// The wearer's joint centre, mm.
    pub true_centre_mm: [f64; 3],
    /// The wearer's radii, mm.
    pub true_radii_mm: [f64; 3],
    /// What the board identified, when it did.
    #[serde(flatten)]
    pub found: Option<Found>,
    /// How many parameters made the board this machine, when it was told.
    pub parameters_told: Option<usize>,
    /// What slipped after the acceptance and what the board said, when something was to slip.
    pub slip: Option<SlipReport>,
    /// The path of a joint centre that moves, when it does.
    pub shoulder: Option<ShoulderReport>,
    /// Files that were written.
    pub plots: Vec<PathBuf>,
}

/// The settings of the rehearsal.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs, reason = "the fields are those of `Options`")]
pub struct Settings {
    pub seed: u64,
    pub poses: u8,
    pub verification_poses: u8,
    pub noise_mm: f64,
    pub tilt_deg: f64,
    pub zero_error_mm: f64,
    pub rig_error_mm: f64,
    pub pulley_mm: f64,
    pub rig: Option<PathBuf>,
}

impl From<&Options> for Settings {
    fn from(options: &Options) -> Self {
        Self {
            seed: options.seed,
            poses: options.poses,
            verification_poses: options.verification_poses(),
            noise_mm: options.noise,
            tilt_deg: options.tilt,
            zero_error_mm: options.zero_error,
            rig_error_mm: options.rig_error.unwrap_or(0.0),
            pulley_mm: options.pulley.unwrap_or(0.0),
            rig: options.rig.clone(),
        }
    }
}

/// What the board identified, beside the truth.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Found {
    /// Version of the firmware.
    pub firmware: String,
    /// Number of the run.
    pub run_id: u16,
    /// Joint centre, mm.
    pub centre_mm: [f64; 3],
    /// Radii, mm.
    pub radii_mm: [f64; 3],
    /// Joint centre in use after the board was restarted, mm. It has it from its record.
    pub centre_after_restart_mm: [f64; 3],
    /// Standard deviations that the board states, mm.
    pub sigma_mm: [f64; 6],
    /// Identified minus true, mm.
    pub error_mm: [f64; 6],
    /// Distance of the identified from the true centre, mm.
    pub centre_error_mm: f64,
    /// Standard deviations that the noise, the rounding to counts and the machine's tolerances make one expect, mm.
    pub expected_sigma_mm: [f64; 6],
    /// Largest errors that count as right, mm.
    pub tolerance_mm: [f64; 6],
    /// What is left of the residuals of the first set, in terms of cable lengths, as the board states it, mm.
    pub residual_mm: f64,
    /// δE of the second set (Eq. 17, over the platform's edges), as the board states it, mm.
    pub verification_deviation_mm: f64,
    /// Iterations on the board.
    pub iterations: u8,
    /// Zero errors of the encoders, when they were set as unknown.
    #[serde(flatten)]
    pub zeros: Option<Zeros>,
    /// The host's view of the same lengths.
    pub host: HostsView,
    /// Poses refused by the board as too near to others.
    pub refused_poses: u32,
}

/// What the host calculates from the lengths that were read out of the board.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HostsView {
    /// δE of the first set (Eq. 17, over the platform's edges) at the board's parameters, mm; of the 3-3 machine only.
    pub deviation_mm: Option<f64>,
    /// What the firmware's solver leaves of the residuals after each step, mm.
    pub deviations_mm: Vec<f64>,
    /// Largest difference between the board's parameters and the host's in the same precision, mm; 0 is to the bit.
    pub difference_mm: f64,
    /// Largest difference between a length that the board used and the one that the encoders showed, counts.
    pub length_difference_counts: f64,
}

impl Found {
    /// From what the session brought to light.
    pub fn new(
        transcript: &Transcript,
        after_restart: &[Parameter; 6],
        verdict: &Verdict,
        host: HostsView,
        zeros: Option<Zeros>,
    ) -> Self {
        let [x, y, z, p1, p2, p3] = transcript.parameters.map(|parameter| f64::from(parameter.value_mm));
        let [major, minor, patch] = transcript.versions.firmware;
        Self {
            firmware: format!("{major}.{minor}.{patch}"),
            run_id: transcript.run_id,
            centre_mm: [x, y, z],
            radii_mm: [p1, p2, p3],
            centre_after_restart_mm: std::array::from_fn(|k| f64::from(after_restart[k].value_mm)),
            sigma_mm: transcript.parameters.map(|parameter| f64::from(parameter.sigma_mm)),
            error_mm: verdict.error_mm,
            centre_error_mm: verdict.centre_error_mm,
            expected_sigma_mm: verdict.expected_sigma_mm,
            tolerance_mm: verdict.tolerance_mm,
            residual_mm: f64::from(transcript.quality.deviation_mm),
            verification_deviation_mm: f64::from(transcript.verified.deviation_mm),
            iterations: transcript.quality.iterations,
            zeros,
            host,
            refused_poses: transcript.refused_poses,
        }
    }
}

impl Report {
    /// Adds what is wrong besides the centre.
    pub fn object(&mut self, objections: &[String]) {
        self.reasons.extend_from_slice(objections);
        if !objections.is_empty() && self.status == Status::Right {
            self.status = Status::Wrong;
        }
    }

    /// A report of a machine that cannot be.
    pub fn without_machine(options: &Options, reason: String) -> Self {
        Self::failed(options, &Parameters::from_array([f64::NAN; 6]), reason)
    }

    /// A report without a result.
    pub fn failed(options: &Options, truth: &Parameters<f64>, reason: String) -> Self {
        Self {
            status: Status::Failed,
            reasons: vec![reason],
            settings: options.into(),
            true_centre_mm: truth.centre_mm.into(),
            true_radii_mm: truth.radii_mm,
            found: None,
            parameters_told: None,
            slip: None,
            shoulder: None,
            plots: Vec::new(),
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(found) = &self.found {
            self.write_table(f, found)?;
            writeln!(f)?;
            self.write_figures(f, found)?;
        }
        if let Some(shoulder) = &self.shoulder {
            write!(f, "{shoulder}")?;
        }
        if let Some(slip) = &self.slip {
            writeln!(f, "{slip}")?;
        }
        for plot in &self.plots {
            writeln!(f, "  plot                 {}", plot.display())?;
        }
        match self.status {
            Status::Right if self.shoulder.is_some() => {
                writeln!(f, "\nright: the centre is where the board says in every pose that identified nothing")
            }
            Status::Right => {
                let slip = if self.slip.is_some() { ", and what slipped was named" } else { "" };
                writeln!(f, "\nright: the identified joint centre is the true one within the tolerance{slip}")
            }
            Status::Wrong => writeln!(f, "\nWRONG: {}", self.reasons.join("\n       ")),
            Status::Failed => writeln!(f, "\nFAILED: {}", self.reasons.join("\n        ")),
        }
    }
}

impl Report {
    fn write_figures(&self, f: &mut fmt::Formatter<'_>, found: &Found) -> fmt::Result {
        let Settings { poses, verification_poses, .. } = self.settings;
        let mut line = |title: &str, text: String| writeln!(f, "  {title:<20} {text}");
        if let Some(told) = self.parameters_told {
            line("the board was told", format!("its machine by {told} parameters over CAN"))?;
        }
        line("off the true centre", format!("{:.4} mm", found.centre_error_mm))?;
        line("residual of lengths", format!("{:.4} mm, {} iterations", found.residual_mm, found.iterations))?;
        let second =
            format!("{:.4} mm over {verification_poses} others that verified", found.verification_deviation_mm);
        match found.host.deviation_mm {
            Some(first) => {
                line("deviation δE", format!("{first:.4} mm over the {poses} poses that identified"))?;
                line("", second)?;
            }
            None => line("deviation", second)?,
        }
        let agreement = match found.host.difference_mm {
            0.0 => "agree to the bit".to_string(),
            mm => format!("differ by {mm:.1e} mm"),
        };
        line("host and board", format!("{agreement}, from the lengths read out of the board"))?;
        if let Some(zeros) = &found.zeros {
            let row = |mm: &[f64; 6]| mm.map(|mm| format!("{mm:+8.3}")).join("");
            line("encoder zeros", format!("{} mm found", row(&zeros.zeros_mm)))?;
            line("", format!("{} mm true", row(&zeros.true_zeros_mm)))?;
            line("", format!("{} mm, one sigma", zeros.zero_sigmas_mm.map(|mm| format!("{mm:8.3}")).join("")))?;
        }
        let kept = found.centre_after_restart_mm;
        let same = if kept == found.centre_mm { "the same" } else { "ANOTHER" };
        let [x, y, z] = kept;
        line("after a restart", format!("{x:.4}, {y:.4}, {z:.4} mm in use, {same} centre, from the record"))
    }

    fn write_table(&self, f: &mut fmt::Formatter<'_>, found: &Found) -> fmt::Result {
        let identified = [found.centre_mm, found.radii_mm].concat();
        let truth = [self.true_centre_mm, self.true_radii_mm].concat();
        writeln!(f)?;
        writeln!(f, "  mm    identified      true     error   board's σ   expected σ   tolerance")?;
        for (k, name) in NAMES.iter().enumerate() {
            writeln!(
                f,
                "  {name:<2} {:>13.4} {:>9.4} {:>+9.4} {:>11.4} {:>12.4} {:>11.4}",
                identified[k],
                truth[k],
                found.error_mm[k],
                found.sigma_mm[k],
                found.expected_sigma_mm[k],
                found.tolerance_mm[k]
            )?;
        }
        Ok(())
    }
}
