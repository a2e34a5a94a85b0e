//! What is to be commissioned: COMMISSION.toml.
//!
//! ```text
//! rig = "rig.toml"            # as stated, with its tolerances
//! noise = 0.058               # optional: standard deviation of a length, mm; else the rig's [noise], else it is estimated
//! homing = 0.3                # optional: what homing anew leaves of each encoder's offset, mm
//! [[log]]
//! file = "a.csv"              # one wearing: one joint centre
//! centre = [0.0, 0.0, 148.0]  # optional: a ball joint at a known place in {B}, mm
//! centre_sigma = 0.1          # how well that place is known, 1σ of each coordinate, mm
//! ```

use crate::identify::input_error::{self, InputError, Place};
use crate::identify::rig_file::source::Source;
use crate::identify::rig_file::{RigFile, default_rig};
use glenoid::identification::Machine;
use nalgebra::Vector3;
use std::path::{Path, PathBuf};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// How well the place of a ball is known when the file does not say, 1σ, mm.
const DEFAULT_CENTRE_SIGMA_MM: f64 = 0.1;

const KEYS: [&str; 4] = ["rig", "noise", "homing", "log"];
const LOG_KEYS: [&str; 3] = ["file", "centre", "centre_sigma"];

/// What is to be commissioned.
#[derive(Clone, Debug)]
pub struct Request {
    /// The rig as stated.
    pub rig: RigFile,
    /// Its file; `None` for the shoulder over its assumed base.
    pub rig_path: Option<PathBuf>,
    /// Standard deviation of a length, mm, where the file states it.
    pub noise_mm: Option<f64>,
    /// What homing anew leaves of each encoder's offset, 1σ, mm.
    pub homing_mm: f64,
    /// The logs, one a wearing.
    pub logs: Vec<LogRequest>,
}

/// A log and what is known of it.
#[derive(Clone, Debug, PartialEq)]
pub struct LogRequest {
    /// Its file.
    pub path: PathBuf,
    /// Where it is named.
    pub place: Place,
    /// Where its joint centre is known to be.
    pub known: Option<KnownCentre>,
}

/// A joint centre at a known place.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownCentre {
    /// In {B}, mm.
    pub in_base_mm: Vector3<f64>,
    /// 1σ of each coordinate, mm.
    pub sigma_mm: f64,
    /// Where it is stated.
    pub place: Place,
}

impl Request {
    /// What each row of a log is the mean of, where the rig's own noise is to be used.
    pub fn samples_a_row(&self) -> Option<u16> {
        self.rig.samples_a_row.filter(|_| self.noise_mm.is_none())
    }

    /// Standard deviation of a length where it is known, mm: stated here, or by the rig.
    pub fn known_noise_mm(&self) -> Option<f64> {
        self.noise_mm.or(self.rig.samples_a_row.map(|_| self.rig.rig.length_noise_mm()))
    }

    /// Reads COMMISSION.toml and the rig that it names.
    ///
    /// # Errors
    /// [`InputError`] names the place that cannot be.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let (file, bytes) = input_error::read(path)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        Reader { source: Source::of(&file, &bytes)?, folder }.request()
    }
}

struct Reader<'a> {
    source: Source<'a>,
    /// File names in it are relative to this.
    folder: &'a Path,
}

impl Reader<'_> {
    fn request(&self) -> Result<Request, InputError> {
        let table = &self.source.any_table()?;
        self.source.refuse_unknown(table, "the file", &KEYS)?;
        let rig_path = table.get("rig").map(|value| self.path(value, "rig")).transpose()?;
        let rig = match &rig_path {
            Some(path) => RigFile::read(path)?,
            None => RigFile::of(default_rig()?),
        };
        if Machine::new(&rig.rig).parameters() == 0 {
            let place = table.get("rig").map_or(0..0, Spanned::span);
            let message = "the rig states no [tolerance]: everything of it is exact, there is nothing to find";
            return Err(self.source.error(place, message));
        }
        Ok(Request {
            rig,
            rig_path,
            noise_mm: self.within(table, "noise", (1e-4, 10.0))?,
            homing_mm: self.within(table, "homing", (0.0, 100.0))?.unwrap_or(0.0),
            logs: self.logs(table)?,
        })
    }

    fn logs(&self, table: &DeTable) -> Result<Vec<LogRequest>, InputError> {
        let end = self.source.text.len();
        let Some(logs) = table.get("log") else {
            return Err(self
                .source
                .error(end..end, "[[log]] with file = \"a.csv\" is missing: there is nothing to go by"));
        };
        let Some(tables) = logs.get_ref().as_array().filter(|logs| !logs.is_empty()) else {
            return Err(self.source.error(logs.span(), "log: tables [[log]] are wanted, one for each wearing"));
        };
        let mut logs: Vec<LogRequest> = Vec::new();
        for value in tables.iter() {
            let log = self.log(value)?;
            let is_same = |before: &&LogRequest| {
                before.path == log.path || input_error::have_same_content(&before.path, &log.path)
            };
            if let Some(before) = logs.iter().find(is_same) {
                let message = format!(
                    "{} is the log of line {} again: the same poses would count twice",
                    log.path.display(),
                    before.place.line
                );
                return Err(InputError::At { place: log.place, message });
            }
            logs.push(log);
        }
        Ok(logs)
    }

    fn log(&self, value: &Spanned<DeValue>) -> Result<LogRequest, InputError> {
        let Some(table) = value.get_ref().as_table() else {
            return Err(self.source.error(value.span(), "log: a table [[log]] is wanted"));
        };
        self.source.refuse_unknown(table, "[[log]]", &LOG_KEYS)?;
        let Some(file) = table.get("file") else {
            return Err(self.source.error(value.span(), "[[log]]: file = \"a.csv\" is missing"));
        };
        let sigma_mm = self.within(table, "centre_sigma", (1e-4, 100.0))?;
        let known = match (table.get("centre"), table.get("centre_sigma")) {
            (Some(centre), _) => Some(KnownCentre {
                in_base_mm: Vector3::from(self.source.numbers::<3>(centre, "centre")?),
                sigma_mm: sigma_mm.unwrap_or(DEFAULT_CENTRE_SIGMA_MM),
                place: self.place(centre.span()),
            }),
            (None, Some(sigma)) => return Err(self.source.error(sigma.span(), "centre_sigma without centre")),
            (None, None) => None,
        };
        Ok(LogRequest { path: self.path(file, "file")?, place: self.place(file.span()), known })
    }

    /// A number between two limits.
    fn within(&self, table: &DeTable, key: &str, (low, high): (f64, f64)) -> Result<Option<f64>, InputError> {
        let Some(value) = table.get(key) else { return Ok(None) };
        let number = self.source.number(value, key)?;
        if (low..=high).contains(&number) {
            return Ok(Some(number));
        }
        Err(self.source.error(value.span(), format!("{key}: {number} mm is not within {low} to {high} mm")))
    }

    fn path(&self, value: &Spanned<DeValue>, key: &str) -> Result<PathBuf, InputError> {
        match value.get_ref().as_str().filter(|name| !name.is_empty()) {
            Some(name) => Ok(self.folder.join(name)),
            None => Err(self.source.error(value.span(), format!("{key}: the name of a file is wanted"))),
        }
    }

    fn place(&self, span: std::ops::Range<usize>) -> Place {
        match self.source.error(span, "") {
            InputError::At { place, .. } => place,
            _ => Place { file: self.source.file.to_owned(), line: 1, column: 1 },
        }
    }
}
