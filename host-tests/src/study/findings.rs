//! What a study is given, and its findings.

use crate::plot::{Figure, PlotError};
use glenoid::rig::RigError;
use std::fmt;

/// What a study is given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Plan {
    /// Seed of all its random numbers.
    pub seed: u64,
    /// How many trials; what one trial is, the study says.
    pub trials: u64,
}

/// What a study found.
#[derive(Default)]
pub struct Findings {
    /// What was done, in a few sentences.
    pub method: String,
    /// Tables, in reading order.
    pub tables: Vec<Table>,
    /// What was aimed at, and whether it was met.
    pub targets: Vec<Target>,
    /// Charts, each with the name of its files.
    pub figures: Vec<(&'static str, Box<dyn Figure>)>,
    /// Figures and single cases worth a line of their own.
    pub remarks: Vec<String>,
}

/// A table of figures.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Table {
    /// Name of its file.
    pub name: &'static str,
    /// What it shows.
    pub title: String,
    /// Names of the columns, with units.
    pub columns: Vec<&'static str>,
    /// Rows, one cell a column.
    pub rows: Vec<Vec<String>>,
    /// Whether it is short enough to be read; long ones are only filed.
    pub printed: bool,
}

impl Table {
    /// An empty table.
    pub fn new(name: &'static str, title: impl Into<String>, columns: &[&'static str]) -> Self {
        Self { name, title: title.into(), columns: columns.to_vec(), rows: Vec::new(), printed: true }
    }

    /// The same, only filed.
    #[must_use]
    pub fn filed_only(mut self) -> Self {
        self.printed = false;
        self
    }

    /// Adds a row.
    pub fn push<const N: usize>(&mut self, row: [String; N]) {
        self.rows.push(row.to_vec());
    }
}

/// A figure that was aimed at.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Target {
    /// What is measured.
    pub what: String,
    /// The limit, in words.
    pub limit: String,
    /// What was measured.
    pub measured: String,
    /// Whether the limit was kept.
    pub holds: bool,
}

impl Target {
    /// At most `limit` (in the unit that `what` names).
    pub fn at_most(what: impl Into<String>, limit: f64, measured: f64) -> Self {
        let limit_text = if limit == 0.0 { "0".to_string() } else { format!("at most {}", short(limit)) };
        // A NaN keeps no limit.
        Self { what: what.into(), limit: limit_text, measured: short(measured), holds: measured <= limit }
    }

    /// At least `limit`.
    pub fn at_least(what: impl Into<String>, limit: f64, measured: f64) -> Self {
        let limit_text = format!("at least {}", short(limit));
        Self { what: what.into(), limit: limit_text, measured: short(measured), holds: measured >= limit }
    }

    /// Between two limits.
    pub fn between(what: impl Into<String>, (low, high): (f64, f64), measured: f64) -> Self {
        let limit_text = format!("{} to {}", short(low), short(high));
        let holds = (low..=high).contains(&measured);
        Self { what: what.into(), limit: limit_text, measured: short(measured), holds }
    }
}

/// A number with four significant digits, as a person writes it; a dash where there is none.
pub fn short(value: f64) -> String {
    if value.is_nan() {
        return "-".to_string();
    }
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let power = libm::floor(libm::log10(value.abs())) as i32;
    if (-4..7).contains(&power) {
        let decimals = (3 - power).max(0) as usize;
        let text = format!("{value:.decimals$}");
        if !text.contains('.') {
            return text;
        }
        return text.trim_end_matches('0').trim_end_matches('.').to_string();
    }
    let text = format!("{value:.2e}");
    match text.split_once('e') {
        Some((mantissa, power)) => format!("{}e{power}", mantissa.trim_end_matches('0').trim_end_matches('.')),
        None => text,
    }
}

/// A share as a percentage with enough digits to tell it from 0 and 100.
pub fn percent(part: usize, whole: usize) -> String {
    if whole == 0 {
        return "-".to_string();
    }
    format!("{} %", short(100.0 * part as f64 / whole as f64))
}

/// Why a study could not be done.
#[derive(Debug)]
pub enum Problem {
    /// Its rig is none.
    Rig(RigError),
    /// A chart or a file could not be made.
    Plot(PlotError),
    /// Too few trials for any statistics.
    TooFewTrials(u64),
    /// A file could not be written.
    Writing(std::path::PathBuf, std::io::Error),
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rig(error) => write!(f, "the study's rig: {}", error.text()),
            Self::Plot(error) => error.fmt(f),
            Self::TooFewTrials(least) => write!(f, "too few trials: this study needs at least {least}"),
            Self::Writing(path, error) => write!(f, "cannot write {}: {error}", path.display()),
        }
    }
}

impl std::error::Error for Problem {}

impl From<RigError> for Problem {
    fn from(error: RigError) -> Self {
        Self::Rig(error)
    }
}

impl From<PlotError> for Problem {
    fn from(error: PlotError) -> Self {
        Self::Plot(error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_four_digits_and_no_more() {
        assert_eq!(short(0.0), "0");
        assert_eq!(short(0.057_735), "0.05774");
        assert_eq!(short(99.987_654), "99.99");
        assert_eq!(short(1_000_000.0), "1000000");
        assert_eq!(short(1.25e-9), "1.25e-9");
        assert_eq!(short(1e-6), "1e-6");
        assert_eq!(short(-3.0), "-3");
        assert_eq!(short(f64::NAN), "-");
    }

    #[test]
    fn nothing_measured_keeps_no_limit() {
        assert!(!Target::at_most("x", 1.0, f64::NAN).holds);
        assert!(!Target::at_least("x", 1.0, f64::NAN).holds);
        assert!(!Target::between("x", (0.0, 1.0), f64::NAN).holds);
        assert!(Target::at_most("x", 0.0, 0.0).holds);
    }
}
