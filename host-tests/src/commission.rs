//! `cargo commission`: the machine as it is built, from logs of it.
//!
//! Each log is one wearing with a joint centre of its own; the machine is the same in all (`normal_equations`). They are
//! fitted together (`fit`), judged (`judgement`), and written as a rig with corrected geometry and the covariance that
//! is left (`correction`, `rig_text`). What they determine and what they do not is said in words (`determined`).

mod constants;
mod correction;
mod determined;
mod fit;
mod judgement;
mod normal_equations;
mod refusal;
pub mod report;
mod request;
mod rig_text;
mod wearing;

pub use refusal::Refused;
pub use request::{KnownCentre, LogRequest, Request};

use self::determined::Determined;
use self::fit::Fit;
use self::report::Report;
use self::wearing::{Unusable, Wearing};
use crate::identify::input_error::{InputError, Place};
use crate::identify::rig_file::RigFile;
use glenoid::identification::Machine;
use glenoid::rig::CABLES;
use nalgebra::Vector3;
use std::path::{Path, PathBuf};

/// Poses of a log from which on its reading is told.
const LONG_LOG: usize = 50_000;

/// What was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The outcome.
    pub report: Report,
    /// The rig's file; `None` when refused.
    pub rig_text: Option<String>,
    /// What the logs were taken for, in words.
    pub notes: Vec<String>,
}

/// Reads the logs and commissions. Nothing is written.
///
/// # Errors
/// [`InputError`] names the place that cannot be read. A refusal is not an error: it is a [`Finding`].
pub fn run(request: &Request) -> Result<Finding, InputError> {
    let rig = &request.rig.rig;
    let machine: Machine<f64> = request.rig.machine(rig);
    let mut wearings = Vec::with_capacity(request.logs.len());
    let mut notes = Vec::new();
    for log in &request.logs {
        match Wearing::read(log, &machine, &request.rig, request.samples_a_row()) {
            Ok(wearing) => {
                if wearing.poses.len() >= LONG_LOG {
                    eprintln!("{}: {} poses read and placed", wearing.file, wearing.poses.len());
                }
                notes.extend(wearing.notes.iter().map(|note| format!("{}: {note}", wearing.file)));
                wearings.push(wearing);
            }
            Err(Unusable::Input(error)) => return Err(error),
            Err(Unusable::Refused(refused)) => return Ok(Finding::refused(&refused, notes)),
        }
    }
    let found = commission(request, &machine, wearings);
    Ok(match found {
        Ok((report, text)) => Finding { report, rig_text: Some(text), notes },
        Err(refused) => Finding::refused(&refused, notes),
    })
}

/// Commissions from readings that are in no file, for simulations: of each wearing its readings, mm, and its joint centre
/// with its 1σ where that is known. The rig as found.
///
/// # Errors
/// [`Refused`].
pub fn of_readings(rig: &RigFile, wearings: &[Readings]) -> Result<RigFile, Refused> {
    let machine: Machine<f64> = rig.machine(&rig.rig);
    let request = |(index, wearing): (usize, &Readings)| {
        let place = Place { file: "the simulation".to_owned(), line: index + 1, column: 1 };
        let known =
            wearing.known.map(|(in_base_mm, sigma_mm)| KnownCentre { in_base_mm, sigma_mm, place: place.clone() });
        LogRequest { path: PathBuf::from(format!("wearing {}", index + 1)), place, known }
    };
    let logs: Vec<LogRequest> = wearings.iter().enumerate().map(request).collect();
    let placed = logs
        .iter()
        .zip(wearings)
        .map(|(log, wearing)| Wearing::of_readings(log, &wearing.readings_mm, &machine, &rig.rig));
    let placed = placed.collect::<Result<Vec<_>, _>>()?;
    let request =
        Request { rig: rig.clone(), rig_path: None, noise_mm: Some(rig.rig.length_noise_mm()), homing_mm: 0.0, logs };
    let (_, text) = commission(&request, &machine, placed)?;
    RigFile::parse("the rig found", text.as_bytes()).map_err(|error| Refused::everywhere(error.to_string()))
}

/// The readings of one wearing.
#[derive(Clone, Debug, PartialEq)]
pub struct Readings {
    /// Of each pose, mm.
    pub readings_mm: Vec<[f64; CABLES]>,
    /// The joint centre in {B} and its 1σ, mm, where it is known.
    pub known: Option<(Vector3<f64>, f64)>,
}

impl Finding {
    fn refused(refused: &Refused, notes: Vec<String>) -> Self {
        Self { report: Report::refused(refused), rig_text: None, notes }
    }
}

fn commission(request: &Request, machine: &Machine<f64>, wearings: Vec<Wearing>) -> Result<(Report, String), Refused> {
    let mut fit = Fit::new(machine, wearings, request.known_noise_mm());
    let mut solution = fit.run().map_err(|found| judgement::undetermined(&fit, found))?;
    judgement::require_sound_logs(&fit)?;
    if fit.wearings.iter().any(|wearing| wearing.known.is_some()) {
        judgement::require_centres_where_stated(&fit, &solution)?;
        solution = fit.run_with_known_centres().map_err(|found| judgement::undetermined(&fit, found))?;
        judgement::require_centres_agree(&fit, &solution)?;
        judgement::require_sound_logs(&fit)?;
    }
    let precision = normal_equations::prior(machine, &fit.estimate, 1.0).machine;
    let singular = || Refused::everywhere("the covariance of the machine's constants is singular");
    let before = constants::prior_covariance(&precision).ok_or_else(singular)?;
    let after = &solution.machine_covariance * (fit.noise_mm * fit.noise_mm);
    let named = constants::named(machine, &fit.estimate, &before, &after);
    let worst = named.iter().max_by(|a, b| a.times_off().total_cmp(&b.times_off()));
    let worst = worst.map_or(String::new(), |c| format!("{}, {:.1} times its sigma", c.name, c.times_off()));
    judgement::require_within_tolerances(&fit, &before, &worst)?;

    let impossible =
        |error: glenoid::rig::RigError| Refused::everywhere(format!("the machine found: {}", error.text()));
    let rig = correction::corrected(&request.rig.rig, &fit.estimate).map_err(impossible)?;
    let corrected = Machine::new(&rig);
    let found = RigFile { samples_a_row: request.rig.samples_a_row, ..RigFile::of(rig) };
    let left = correction::covariance(machine, &fit.estimate, &corrected, &after, request.homing_mm);
    let determined = Determined::of(&fit, &named, &before, &left);
    let report = Report::commissioned(&fit, &solution, named, determined);
    let text = rig_text::text(&heading(request, &report), &found, &corrected, &left);
    // What cannot be read back is not written.
    RigFile::parse("the rig found", text.as_bytes()).map_err(|error| Refused::everywhere(error.to_string()))?;
    Ok((report, text))
}

/// What the file comes from.
fn heading(request: &Request, report: &Report) -> Vec<String> {
    let mut lines =
        vec!["A machine as commissioned, mm. {B} is the frame best fitted to the stated attachment points.".to_owned()];
    if let Some(path) = &request.rig_path {
        lines.push(format!("from {}", path.display()));
    }
    lines.extend(report.logs.iter().map(|log| format!("and {}: {} of {} poses", log.file, log.used, log.poses)));
    if request.homing_mm > 0.0 {
        lines.push(format!("homed anew each time, to {} mm", request.homing_mm));
    }
    lines
}

/// Writes the rig's file whole or not at all.
///
/// # Errors
/// [`InputError`] when the file is one of those that the rig comes from, or with the operating system's words.
pub fn write(request: &Request, path: &Path, text: &str) -> Result<(), InputError> {
    let same = |other: &Path| match (path.canonicalize(), other.canonicalize()) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    };
    let sources = request.logs.iter().map(|log| log.path.as_path()).chain(request.rig_path.as_deref());
    if let Some(source) = sources.into_iter().find(|source| same(source)) {
        let message = format!("--output {}: the rig comes from this file, give it another name", source.display());
        return Err(InputError::Request(message));
    }
    rig_text::write_whole(path, text)
        .map_err(|error| InputError::File { file: path.display().to_string(), message: error.to_string() })
}
