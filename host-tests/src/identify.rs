//! `cargo identify`: the board's identification on a recorded log, for the researcher's desk.
//!
//! A log and a rig are read ([`lengths_file`], [`rig_file`]; anything that cannot be read is reported by file, line and
//! column), the library's solver is run in the precision asked for ([`calculation`]), and the outcome is one [`report`]
//! that is printed as JSON or as a [`summary`] with a remedy for every refusal.

mod board_calculation;
pub mod calculation;
pub mod causes;
mod exclusive;
pub mod held_phase;
pub mod held_report;
pub mod hinge;
pub mod input_error;
mod known_keys;
pub mod lengths_file;
pub mod machine_report;
pub mod refusal;
pub mod remedy;
pub mod report;
pub mod rig_file;
pub mod selection;
pub mod summary;
pub mod units;
pub mod verification;
pub mod wording;

use glenoid::identification::joint::MAX_JOINT;
use glenoid::identification::parameters::{CENTRE_UNKNOWNS, MAX_UNKNOWNS};
use glenoid::identification::{DEFAULT_CAPACITY, JointChoice, Machine};
use glenoid::rig::Rig;
use std::path::{Path, PathBuf};

use self::calculation::Problem;
use self::input_error::InputError;
use self::lengths_file::LengthsFile;
use self::report::{Method, Precision, Report, Setting, Start};
use self::rig_file::RigFile;
use self::selection::RowsUsed;

/// Without `--noise`, residuals up to this many times the noise expected of the rig are taken for noise of the cables:
/// 0.35 mm for the shoulder, which uniform noise within ±0.6 mm gives. What is left of a rig file that is wrong by a
/// centimetre, or of a strap that slips, is larger.
const MAX_TIMES_EXPECTED_NOISE: f64 = 6.0;

/// What is to be identified, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// The log.
    pub lengths: PathBuf,
    /// The rig's file; without one, the shoulder over its assumed base.
    pub rig: Option<PathBuf>,
    /// Where the paper's method begins: x, y, z, p1, p2, p3, mm.
    pub start_mm: Option<[f64; 6]>,
    /// Which identification.
    pub method: Method,
    /// The encoders' zeros are known to this only, 1σ, mm; without it as the rig says.
    pub zero_prior_mm: Option<f64>,
    /// Which model of the joint.
    pub joint: JointChoice,
    /// A log of the held phase.
    pub still: Option<PathBuf>,
    /// Use every row.
    pub all_poses: bool,
    /// Known standard deviation of a cable length, mm. Without it, it is estimated from the residuals.
    pub noise_mm: Option<f64>,
    /// Precision of the arithmetic.
    pub precision: Precision,
    /// A second log, on which the result is verified.
    pub verify: Option<PathBuf>,
}

/// The outcome of a request that could be read.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// What was found.
    pub report: Report,
    /// The same for people.
    pub summary: String,
    /// What was asked for but not used, in words.
    pub warnings: Vec<String>,
    /// What the files were taken for, in words.
    pub notes: Vec<String>,
}

/// Reads the files and identifies.
///
/// # Errors
/// [`InputError`] names the place that cannot be read. A refusal is not an error: it is a [`Finding`].
pub fn run(request: &Request) -> Result<Finding, InputError> {
    exclusive::options(request)?;
    let machine = machine(request.rig.as_deref())?;
    let noise_mm = request.noise_mm.unwrap_or(machine.row_noise_mm());
    // What is said on the command line is the noise of every row.
    let samples_a_row = machine.samples_a_row.filter(|_| request.noise_mm.is_none());
    let log = log(&request.lengths, &machine.rig)?;
    let of_board = board_calculation::note(&log, &machine.rig).map(|note| format!("{}: {note}", log.file()));
    let second = match request.verify.as_deref() {
        Some(path) => Some(self::log(path, &machine.rig)?),
        // A recording of the bus holds the board's own second set.
        None => log.second_set(),
    };
    let still = request.still.as_deref().map(|path| self::log(path, &machine.rig)).transpose()?;
    let twice = exclusive::poses(&log, still.as_ref(), second.as_ref())?;
    let log = log.with_repeated_rows_merged(noise_mm);
    let still = still.map(|log| log.with_repeated_rows_merged(noise_mm));
    let logs = [Some(&log), still.as_ref(), second.as_ref()].into_iter().flatten();
    let mut notes: Vec<_> =
        logs.flat_map(|log| log.notes().iter().map(|note| format!("{}: {note}", log.file()))).collect();
    notes.extend(of_board);
    notes.extend(twice);
    notes.extend(log.note_of_correction(&machine.rig).map(|note| format!("{}: {note}", log.file())));
    let setting = setting(request, &machine, log.rows().len());
    let (still, second_log) = (still.as_ref(), second.as_ref());
    let problem = Problem { rig_file: &machine, log: &log, setting, still, second: second_log, samples_a_row };
    let report = problem.solve()?;
    let summary = summary::of(&report, &log, still, second.as_ref());
    Ok(Finding { report, summary, warnings: unused(request), notes })
}

/// Tells six numbers that cannot be a start: x, y, z, p1, p2, p3, mm.
pub fn start_complaint(start_mm: &[f64; 6]) -> Option<String> {
    let [.., p1, p2, p3] = start_mm;
    if start_mm.iter().any(|number| !number.is_finite()) {
        Some("the start x, y, z, p1, p2, p3 must be finite numbers".to_owned())
    } else if [p1, p2, p3].into_iter().any(|radius| *radius <= 0.0) {
        Some("the radii p1, p2, p3 of the start must be positive".to_owned())
    } else {
        None
    }
}

fn machine(path: Option<&Path>) -> Result<RigFile, InputError> {
    match path {
        Some(path) => RigFile::read(path),
        None => Ok(RigFile::of(rig_file::default_rig()?)),
    }
}

/// A log in millimetres.
///
/// # Errors
/// [`InputError`] names the first place that cannot be read.
pub fn log(path: &Path, rig: &Rig<f64>) -> Result<LengthsFile, InputError> {
    let log = LengthsFile::read(path)?;
    match (units::complaint_about_lengths(log.rows(), rig.base_mm()), log.rows().first()) {
        (Some(complaint), Some(row)) => Err(log.at(row.line, 0, complaint)),
        _ => Ok(log),
    }
}

/// How to compute, for a log of so many rows.
fn setting(request: &Request, machine: &RigFile, rows: usize) -> Setting {
    let expected_noise_mm = machine.rig.length_noise_mm();
    // What the rig's file states is known.
    let stated_noise_mm = machine.samples_a_row.map(|_| expected_noise_mm);
    let full = request.method == Method::Full;
    Setting {
        rows_used: RowsUsed::of(rows, if request.all_poses { usize::MAX } else { DEFAULT_CAPACITY }),
        method: request.method,
        precision: request.precision,
        zero_prior_mm: request.zero_prior_mm.filter(|_| full),
        joint: request.joint,
        has_no_room_for_motion: Machine::new(&machine.rig).parameters() + MAX_JOINT + CENTRE_UNKNOWNS > MAX_UNKNOWNS,
        start: (!full).then(|| start(request, machine)),
        given_noise_mm: request.noise_mm.or(stated_noise_mm).filter(|_| full),
        expected_noise_mm,
        noise_limit_mm: expected_noise_mm * MAX_TIMES_EXPECTED_NOISE,
    }
}

/// Where the paper's method begins: what was asked for, else what the rig's file says, else the nominal centre.
fn start(request: &Request, machine: &RigFile) -> Start {
    match (request.start_mm, machine.start_mm) {
        (Some(values_mm), _) => Start { from: "--start", values_mm },
        (None, Some(values_mm)) => Start { from: "[start] of the rig file", values_mm },
        (None, None) => {
            Start { from: "the shoulder's nominal centre and radii", values_mm: machine.rig.nominal().to_array() }
        }
    }
}

/// Options that the method has no use for.
fn unused(request: &Request) -> Vec<String> {
    let mut warnings = Vec::new();
    if request.method == Method::Full && request.start_mm.is_some() {
        warnings.push("--start is not used: the full method needs none (--method paper begins there)".to_owned());
    }
    if request.method == Method::Paper && request.zero_prior_mm.is_some() {
        warnings.push("--zeros is not used: the paper's method takes the zeros for known".to_owned());
    }
    if request.method == Method::Paper && request.noise_mm.is_some() {
        warnings.push(
            "--noise is not used: the paper's method takes its standard deviation from its own residuals".to_owned(),
        );
    }
    warnings
}
