//! A recorded log: cable lengths of one pose after the other, mm.
//!
//! Two kinds of file are read: a table (`table`: CSV of the shapes that spreadsheets, loggers and scripts write), and
//! what `candump` recorded on the bus during a run (`bus_log`). What was taken for what is noted in
//! [`LengthsFile::notes`], because a guess that nobody sees cannot be corrected.
//!
//! Read by hand rather than with a CSV library, because every complaint names its line and column: the libraries drop
//! the place of a field, and count the lines of a file with CRLF or blank lines in their own way.

mod board_result;
mod bus_log;
mod foreign;
mod header;
mod number;
mod repeated;
mod table;
mod text;

pub use board_result::BoardResult;

use super::input_error::{self, InputError};
use glenoid::identification::Pose;
use glenoid::kinematics::CableLengths;
use glenoid::rig::{CABLES, Rig};
use glenoid::scalar::Real;
use std::path::Path;

/// What the cables are called in messages, in their order.
const NAMES: [&str; CABLES] = ["l1", "l2", "l3", "l4", "l5", "l6"];

/// One pose of a log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Line in the file, from 1; of a bus log the line of its last length.
    pub line: usize,
    /// L1..L6, mm, each finite and positive.
    pub lengths_mm: [f64; CABLES],
    /// How many samples they are known to be the mean of: by a bus log, or as rows that repeat one pose.
    pub samples: u16,
}

/// Where the cables stand in the lines of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Columns {
    /// First line for which this holds.
    from_line: usize,
    /// Column (from 0) of each cable.
    of_cable: [usize; CABLES],
}

/// A log with at least one pose.
#[derive(Clone, Debug, PartialEq)]
pub struct LengthsFile {
    file: String,
    columns: Vec<Columns>,
    rows: Vec<Row>,
    second_set: Vec<Row>,
    notes: Vec<String>,
    board: Option<BoardResult>,
}

impl LengthsFile {
    /// Reads a log.
    ///
    /// # Errors
    /// [`InputError`] names the first place that cannot be read.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        Self::read_of(path, CABLES)
    }

    /// Reads a table of a rig with fewer cables. The rows' lengths beyond them repeat the first.
    ///
    /// # Errors
    /// [`InputError`] names the first place that cannot be read.
    pub fn read_of(path: &Path, cables: usize) -> Result<Self, InputError> {
        let (file, bytes) = input_error::read(path)?;
        Self::parse_of(&file, &bytes, cables)
    }

    /// Reads a log from its bytes. `file` is its name for messages.
    ///
    /// # Errors
    /// [`InputError`] names the first place that cannot be read.
    pub fn parse(file: &str, bytes: &[u8]) -> Result<Self, InputError> {
        Self::parse_of(file, bytes, CABLES)
    }

    fn parse_of(file: &str, bytes: &[u8], cables: usize) -> Result<Self, InputError> {
        if let Some(kind) = foreign::kind(bytes) {
            return Err(InputError::at(file, 1, 1, foreign::complaint(kind, file)));
        }
        let text = text::decode(file, bytes)?;
        let mut log = match bus_log::is_one(&text.content) {
            true if cables == CABLES => bus_log::parse(file, &text)?,
            true => return Err(InputError::at(file, 1, 1, "what candump recorded holds the lengths of six cables")),
            false => table::parse(file, &text, cables)?,
        };
        log.notes.splice(0..0, text.encoding.note());
        Ok(log)
    }

    /// The log's name for messages.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// The poses, in the order of the file. The same pose may stand there many times over; each row keeps its line.
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// The poses of a bus log that the board held out to verify its result, as a log of their own; None when there are
    /// none.
    pub fn second_set(&self) -> Option<Self> {
        let rows = self.second_set.clone();
        (!rows.is_empty()).then(|| Self { rows, second_set: Vec::new(), notes: Vec::new(), ..self.clone() })
    }

    /// What the board itself found, if this is a recording of the bus.
    pub fn board(&self) -> Option<&BoardResult> {
        self.board.as_ref()
    }

    /// What was taken for what, and what was left out, in words. Empty for a plain table.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// A row as the library's lengths, in precision `T`.
    ///
    /// # Errors
    /// [`InputError`] for a length that precision `T` cannot hold.
    pub fn cables<T: Real>(&self, row: &Row) -> Result<CableLengths<T>, InputError> {
        CableLengths::new(row.lengths_mm.map(T::of)).map_err(|error| {
            let cable = usize::from(error.cable) - 1;
            let length = row.lengths_mm[cable];
            self.at(row.line, cable, format!("{length} mm: {}", error.fault.text()))
        })
    }

    /// A row as true lengths: what commissioning has found for `rig` is taken off, unless the board that was recorded did so.
    ///
    /// # Errors
    /// [`InputError`] for a length that precision `T` cannot hold, or that is none once corrected.
    pub fn true_lengths<T: Real>(&self, row: &Row, rig: &Rig<T>) -> Result<CableLengths<T>, InputError> {
        let read = self.cables::<T>(row)?;
        if self.board.is_some() {
            return Ok(read);
        }
        read.corrected(rig)
            .map_err(|error| self.at(row.line, usize::from(error.cable) - 1, error.fault.text().to_owned()))
    }

    /// What to say of a recording of a machine with offsets or scales of its own.
    pub fn note_of_correction(&self, rig: &Rig<f64>) -> Option<String> {
        let is_corrected = self.board.is_some() && rig.correction().is_some();
        is_corrected.then(|| {
            "the lengths are as the board corrected them, by offsets and scales of its own: [zeros] and [drum] are not taken \
             off again, and must be the board's"
                .to_owned()
        })
    }

    /// The rows as poses of a machine. `samples_a_row`: what each row of a table is the mean of, where the rig states the noise
    /// of a length; `None` gives all poses the same noise.
    ///
    /// # Errors
    /// As for [`true_lengths`](Self::true_lengths).
    pub fn poses<'r, T: Real>(
        &self,
        rows: impl Iterator<Item = &'r Row>,
        rig: &Rig<T>,
        samples_a_row: Option<u16>,
    ) -> Result<Vec<Pose<T>>, InputError> {
        rows.map(|row| {
            let pose = Pose::new(self.true_lengths(row, rig)?);
            let Some(samples_a_row) = samples_a_row else {
                // What is said of the noise of a row is all of it: nothing is left that a single sample would add.
                return Ok(pose.averaged_over(u16::MAX));
            };
            let times = if self.board.is_some() { 1 } else { samples_a_row };
            Ok(pose.averaged_over(row.samples.saturating_mul(times)))
        })
        .collect()
    }

    /// An error at a cable (from 0) of a line.
    pub fn at(&self, line: usize, cable: usize, message: String) -> InputError {
        let holds = self.columns.iter().rev().find(|columns| columns.from_line <= line);
        let column = holds.map_or(0, |columns| columns.of_cable[cable]);
        InputError::at(&self.file, line, column + 1, format!("{}: {message}", NAMES[cable]))
    }

    fn new(file: &str) -> Self {
        Self {
            file: file.to_owned(),
            columns: Vec::new(),
            rows: Vec::new(),
            second_set: Vec::new(),
            notes: Vec::new(),
            board: None,
        }
    }
}
