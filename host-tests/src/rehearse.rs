//! `cargo rehearse`: a whole calibration with a virtual wearer, and the truth at the end.
//!
//! The same script ([`Session`]) plays against the emulated board over its two serial lines ([`EmulatedBoard`]) and
//! against the device within this process ([`InProcess`]), which tests use: anything that is a [`Bench`].

pub mod arm;
mod bench;
mod board;
mod charts;
mod client;
mod display;
mod expected;
mod in_motion;
mod inbox;
mod judgement;
mod machine;
mod options;
mod parameters;
pub(crate) mod replay;
mod report;
mod restart;
mod session;
mod shoulder;
mod shoulder_report;
mod slip;
mod slip_charts;
mod transcript;
mod verdict;
mod zeros;

pub use bench::{Bench, BenchError, InProcess};
pub use board::EmulatedBoard;
pub use display::{Display, Stage};
pub use expected::{Expected, length_sigma_mm};
pub use inbox::Inbox;
pub use machine::KnownMachine;
pub use options::{ArmFault, Options};
pub use report::{Found, Report, Settings, Status};
pub use session::{Person, Session};
pub use shoulder_report::ShoulderReport;
pub use slip::{Exercise, Slip, SlipReport};
pub use transcript::{Captured, SessionError, Transcript};
pub use verdict::{NAMES, Verdict};
pub use zeros::Zeros;

use self::arm::{ArmReport, EmulatedBus, rehearse_arm};
use crate::anatomy::Shoulder;
use crate::emulator::{self, Emulator};
use crate::firmware::{self, Image};
use crate::packages::Consent;
use crate::wearer::Wearer;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// Builds and boots the board, rehearses a calibration on it and reports. Gives up as soon as `stop` is set.
pub fn run(options: &Options, display: &Display, plots: &Path, stop: &'static AtomicBool) -> Report {
    let known = KnownMachine::of(options);
    let machines = known.and_then(|known| Ok((known.as_built(options.rig_error, options.seed)?, known)));
    let (built, known) = match machines {
        Ok(machines) => machines,
        Err(reason) => return Report::without_machine(options, reason),
    };
    let mut wearer = Wearer::new(built, options.wearer());
    match boot(options, display, stop) {
        Err(reason) => Report::failed(options, &wearer.truth(), reason),
        Ok(mut board) => {
            let mut report = rehearse(&mut board, &mut wearer, &known, options, display, Some(plots));
            if report.status == Status::Failed && !stop.load(Ordering::Relaxed) {
                report.reasons.extend(board.crash_record().into_iter().map(|line| format!("board's log: {line}")));
            }
            report
        }
    }
}

/// Builds the firmware and rehearses an arm on three boards of it. Gives up as soon as `stop` is set.
pub fn run_arm(options: &Options, display: &Display, stop: &'static AtomicBool) -> ArmReport {
    match build(options, display) {
        Err(reason) => ArmReport::empty(options).failed(reason),
        Ok(image) => {
            let mut bus = EmulatedBus::new(image).until(stop);
            let mut report = rehearse_arm(&mut bus, options, display);
            if report.status == Status::Failed && options.arm_fault.is_none() && !stop.load(Ordering::Relaxed) {
                report.reasons.extend(bus.logs());
            }
            report
        }
    }
}

/// Builds the firmware, and makes sure that the emulator is there.
fn build(options: &Options, display: &Display) -> Result<PathBuf, String> {
    let consent = if options.yes { Consent::Given } else { Consent::Ask };
    // Questions and the words of apt-get, rustup and cargo go to stderr themselves; a moving bar would mangle them.
    emulator::ensure_installed(consent).map_err(|error| error.to_string())?;
    let toolchain = firmware::choose_toolchain(consent).map_err(|error| error.to_string())?;
    let stage = display.stage("building the firmware");
    let image = firmware::build_with(toolchain, Image::EMULATED).map_err(|error| error.to_string())?;
    let shown = image.strip_prefix(firmware::workspace()).unwrap_or(&image);
    stage.done(&format!("{} by {toolchain:?}'s toolchain", shown.display()));
    Ok(image)
}

fn boot(options: &Options, display: &Display, stop: &'static AtomicBool) -> Result<EmulatedBoard, String> {
    let image = build(options, display)?;
    let stage = display.stage("booting the board");
    let emulator = Emulator::start(&image, &emulator::Options::default()).map_err(|error| error.to_string())?;
    let board = EmulatedBoard::connect(emulator).map_err(|error| error.to_string())?;
    stage.done("QEMU mps2-an386, Cortex-M4F");
    Ok(board.until(stop))
}

/// Rehearses a calibration on a bench and holds the result against the truth. Writes the plots into the folder
/// `plots`, if there is one.
pub fn rehearse(
    bench: &mut dyn Bench,
    wearer: &mut Wearer,
    known: &KnownMachine,
    options: &Options,
    display: &Display,
    plots: Option<&Path>,
) -> Report {
    if let Some(person) = options.shoulder {
        wearer.wear(Shoulder::new(person, options.follow));
        return shoulder::rehearse(bench, wearer, known, options, display);
    }
    let truth = wearer.truth();
    let rig = &known.double;
    let mut session = Session::new(bench, wearer, rig.drum().fastest_mm_per_s, display);
    let told = known.told.as_ref().map(|set| session.become_machine(set)).transpose();
    let calibrated = told.and_then(|told| {
        let transcript = session.calibrate(options.poses, options.verification_poses(), options.zero_prior_steps())?;
        Ok((transcript, told))
    });
    let outcome = calibrated.and_then(|(transcript, told)| {
        let after_restart = session.restart()?;
        let exercise = options.slip.map(|slip_mm| session.exercise(options, slip_mm)).transpose()?;
        Ok((transcript, told, after_restart, exercise))
    });
    let report = outcome.map_err(|error| error.to_string()).and_then(|(transcript, told, after_restart, exercise)| {
        let mut report = judgement::judge(&transcript, &after_restart, wearer, known, options, plots)?;
        report.parameters_told = told;
        if let Some(exercise) = exercise {
            let slip = exercise.judge();
            report.object(&slip.objections);
            report.slip = Some(slip);
            if let Some(folder) = plots {
                let zeros_mm = transcript.zeros_mm();
                let files = slip_charts::write(&exercise, rig, &transcript.parameters, &zeros_mm, folder);
                report.plots.extend(files.map_err(|error| error.to_string())?);
            }
        }
        Ok(report)
    });
    report.unwrap_or_else(|reason| Report::failed(options, &truth, reason))
}
