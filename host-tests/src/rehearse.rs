//! `cargo rehearse`: a whole calibration with a virtual wearer, and the truth at the end.
//!
//! The same script ([`Session`]) plays against the emulated board over its two serial lines ([`EmulatedBoard`]) and
//! against the device within this process ([`InProcess`]), which tests use: anything that is a [`Bench`].

mod bench;
mod board;
mod charts;
mod display;
mod expected;
mod inbox;
mod options;
mod replay;
mod report;
mod session;
mod verdict;

pub use bench::{Bench, BenchError, InProcess};
pub use board::EmulatedBoard;
pub use display::{Display, Stage};
pub use expected::{length_sigma_mm, sigma_mm};
pub use inbox::Inbox;
pub use options::Options;
pub use report::{Found, Report, Settings, Status};
pub use session::{Captured, Session, SessionError, Transcript};
pub use verdict::{NAMES, Verdict};

use crate::emulator::{self, Emulator};
use crate::firmware::{self, Image};
use crate::packages::Consent;
use crate::wearer::Wearer;
use glenoid::rig::{ASSUMED_BASE_RADIUS_MM, CABLES, Rig};
use std::path::Path;

/// Builds and boots the board, rehearses a calibration on it and reports.
pub fn run(options: &Options, display: &Display, plots: &Path) -> Report {
    let rig = match Rig::shoulder(ASSUMED_BASE_RADIUS_MM) {
        Ok(rig) => rig,
        Err(error) => unreachable!("the shoulder's constants make a rig: {}", error.text()),
    };
    let mut wearer = Wearer::new(rig, options.wearer());
    match boot(options, display) {
        Err(reason) => Report::failed(options, &wearer.truth(), reason),
        Ok(mut board) => {
            let mut report = rehearse(&mut board, &mut wearer, &rig, options, display, plots);
            if report.status == Status::Failed {
                report.reasons.extend(board.last_words().into_iter().map(|line| format!("board's log: {line}")));
            }
            report
        }
    }
}

fn boot(options: &Options, display: &Display) -> Result<EmulatedBoard, String> {
    let consent = if options.yes { Consent::Given } else { Consent::Ask };
    // Questions and the words of apt-get, rustup and cargo go to stderr themselves; a moving bar would mangle them.
    emulator::ensure_installed(consent).map_err(|error| error.to_string())?;
    let toolchain = firmware::choose_toolchain(consent).map_err(|error| error.to_string())?;
    let stage = display.stage("building the firmware");
    let image = firmware::build_with(toolchain, Image::EMULATED).map_err(|error| error.to_string())?;
    stage.done(&format!("{} with {toolchain:?}'s toolchain", image.display()));
    let stage = display.stage("booting the board");
    let emulator = Emulator::start(&image, &emulator::Options::default()).map_err(|error| error.to_string())?;
    let board = EmulatedBoard::connect(emulator).map_err(|error| error.to_string())?;
    stage.done("QEMU mps2-an386, Cortex-M4F");
    Ok(board)
}

/// Rehearses a calibration on a bench and holds the result against the truth. Writes the plots into `plots`.
pub fn rehearse(
    bench: &mut dyn Bench,
    wearer: &mut Wearer,
    rig: &Rig<f64>,
    options: &Options,
    display: &Display,
    plots: &Path,
) -> Report {
    let truth = wearer.truth();
    let session = Session::new(bench, wearer, rig.drum().fastest_mm_per_s, display);
    let outcome = session.calibrate(options.poses, options.verification_poses()).map_err(|error| error.to_string());
    let report = outcome.and_then(|transcript| judge(&transcript, wearer, rig, options, plots));
    report.unwrap_or_else(|reason| Report::failed(options, &truth, reason))
}

/// Holds what the board found against the truth and against the host's own calculation.
fn judge(
    transcript: &Transcript,
    wearer: &Wearer,
    rig: &Rig<f64>,
    options: &Options,
    plots: &Path,
) -> Result<Report, String> {
    let truth = wearer.truth();
    let encoder = wearer.encoder();
    let spans_mm: Vec<_> = transcript.identification.iter().map(|captured| captured.pose.spans_mm).collect();
    let length_sigma_mm = length_sigma_mm(options.noise, encoder.mm_per_count());
    let expected_sigma_mm = sigma_mm(rig, truth, &spans_mm, length_sigma_mm)
        .map_err(|refusal| format!("these poses do not determine the centre: {}", refusal.text()))?;
    let verdict = Verdict::new(transcript.parameters.map(|p| p.value_mm), &truth, expected_sigma_mm);
    let mut reasons = verdict.objections();

    let lengths_mm: Vec<_> = transcript.identification.iter().map(|captured| captured.lengths_mm).collect();
    let rig_f32 = Rig::<f32>::shoulder(ASSUMED_BASE_RADIUS_MM as f32).map_err(|error| error.text().to_string())?;
    let disagree = |refusal: glenoid::identification::Refusal| {
        format!("the board found a centre where the host refuses the same lengths: {}", refusal.text())
    };
    let single = replay::identify(&rig_f32, &lengths_mm).map_err(disagree)?;
    let double = replay::identify(rig, &lengths_mm).map_err(disagree)?;
    let host_difference_mm = replay::difference_mm(&transcript.parameters, &single.parameters);
    if host_difference_mm != 0.0 {
        reasons.push(format!("host and board differ by {host_difference_mm:.1e} mm over the same lengths"));
    }
    let length_difference_counts = length_difference_counts(transcript, rig);
    if !(length_difference_counts <= MOST_COUNTS_OFF) {
        reasons.push(format!("the board used a length that is {length_difference_counts:.2} counts off the encoder's"));
    }

    let single: Vec<f64> = single.deviations_mm.iter().map(|d| f64::from(*d)).collect();
    let subtitle = format!(
        "{} poses, cable noise ±{} mm, tilt to {}°, seed {}",
        options.poses, options.noise, options.tilt, options.seed
    );
    let mut files = Vec::new();
    let written = || -> Result<(), crate::plot::PlotError> {
        charts::save(&charts::convergence(&single, &double.deviations_mm, &subtitle), plots, "convergence", &mut files)?;
        let (first, second) = (&transcript.identification, &transcript.verification);
        charts::save(&charts::coverage(first, second, options.tilt, &subtitle), plots, "coverage", &mut files)?;
        let [x, y, z] = [0, 1, 2].map(|k| f64::from(transcript.parameters[k].sigma_mm));
        let sigma_of_centre = (x * x + y * y + z * z).sqrt();
        if let Some(chart) = charts::prediction(first, sigma_of_centre, &subtitle) {
            charts::save(&chart, plots, "prediction", &mut files)?;
        }
        Ok(())
    };
    let mut written = written;
    written().map_err(|error| error.to_string())?;

    let found = Found::new(transcript, &verdict, single, host_difference_mm, length_difference_counts);
    Ok(Report {
        status: if reasons.is_empty() { Status::Right } else { Status::Wrong },
        reasons,
        settings: options.into(),
        true_centre_mm: truth.centre_mm.into(),
        true_radii_mm: truth.radii_mm,
        found: Some(found),
        plots: files,
    })
}

/// A pose is the mean of the counts over a short time, in which the arm may still have crept by a few counts.
const MOST_COUNTS_OFF: f64 = 3.0;

/// Largest difference between a length that the board used and the one that the encoders showed, counts.
fn length_difference_counts(transcript: &Transcript, rig: &Rig<f64>) -> f64 {
    let (home, mm_per_count) = (rig.drum().home_length_mm, rig.drum().mm_per_count());
    let captured = transcript.identification.iter().chain(&transcript.verification);
    captured
        .flat_map(|captured| {
            (0..CABLES).map(move |k| {
                let shown_mm = home[k] + f64::from(captured.pose.counts[k]) * mm_per_count;
                ((f64::from(captured.lengths_mm[k]) - shown_mm) / mm_per_count).abs()
            })
        })
        .fold(0.0, f64::max)
}
