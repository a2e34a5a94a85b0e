//! A table of lengths: one pose a line, the columns named by a header.
//!
//! The columns may stand in any order and among others; they are separated by commas, semicolons, tabs, bars or blanks;
//! the decimal sign is a point or a comma. Comments (`#`), a row of units, a header that comes again, `sep=;`, blank
//! lines and empty cells at the end are passed over.

use super::header::{Header, Separator, complaint_about_unit};
use super::number::{DecimalSign, Numbers};
use super::text::{Text, lines};
use super::{LengthsFile, NAMES, Row};
use crate::identify::input_error::InputError;
use glenoid::rig::CABLES;

/// Reads a table of the lengths of so many cables.
///
/// # Errors
/// [`InputError`] names the first place that cannot be read.
pub(super) fn parse(file: &str, text: &Text, cables: usize) -> Result<LengthsFile, InputError> {
    let mut reader = Reader::new(file, cables);
    let mut last = 0;
    let mut cells = Vec::new();
    for (line, content) in lines(&text.content) {
        if !content.trim().is_empty() {
            last = line;
            reader.take(line, content, &mut cells)?;
        }
    }
    reader.finish(last)
}

/// What was passed over, and where it stood first.
#[derive(Default)]
struct PassedOver {
    comments: usize,
    units_line: Option<usize>,
    header_again: Vec<usize>,
    empty_rows: usize,
}

struct Reader {
    log: LengthsFile,
    cables: usize,
    /// The separator that a line `sep=;` named.
    named: Option<Separator>,
    header: Option<Header>,
    /// Nothing but the header has been read: a row of units may follow.
    just_after_header: bool,
    numbers: Numbers,
    passed_over: PassedOver,
}

impl Reader {
    fn new(file: &str, cables: usize) -> Self {
        Self {
            log: LengthsFile::new(file),
            cables,
            named: None,
            header: None,
            just_after_header: false,
            numbers: Numbers::default(),
            passed_over: PassedOver::default(),
        }
    }

    fn take<'a>(&mut self, line: usize, content: &'a str, cells: &mut Vec<&'a str>) -> Result<(), InputError> {
        if let Some(comment) = content.trim_start().strip_prefix('#') {
            return self.comment(line, comment);
        }
        let Some(header) = &self.header else {
            if let (None, Some(separator)) = (self.named, Separator::named_by(content)) {
                self.named = Some(separator);
                return Ok(());
            }
            return self.begin(self.header_of(line, content, self.named)?);
        };
        header.separator.cells(content, cells);
        if cells.iter().all(|cell| cell.is_empty()) {
            self.passed_over.empty_rows += 1;
            return Ok(());
        }
        let of_cable = header.columns.of_cable;
        // Only a cell without a number at its place can begin anything else than a row.
        let first = cells.get(of_cable[0]).copied().unwrap_or("");
        if first.starts_with(|c: char| c.is_alphabetic() || "[(".contains(c)) {
            if let Ok(again) = self.header_of(line, content, Some(header.separator)) {
                self.passed_over.header_again.push(line);
                return self.begin(again);
            }
            if self.just_after_header && is_units(cells, &of_cable) {
                return self.units(line, cells, &of_cable);
            }
        }
        self.just_after_header = false;
        let row = self.row(line, cells)?;
        self.log.rows.push(row);
        Ok(())
    }

    /// A comment is passed over, but for one that is the header: some programs write it so.
    fn comment(&mut self, line: usize, comment: &str) -> Result<(), InputError> {
        if self.header.is_none()
            && let Ok(header) = self.header_of(line, comment, self.named)
        {
            return self.begin(header);
        }
        self.passed_over.comments += 1;
        Ok(())
    }

    fn header_of(&self, line: usize, text: &str, named: Option<Separator>) -> Result<Header, InputError> {
        Header::parse(self.log.file(), line, text, named, self.cables)
    }

    fn begin(&mut self, header: Header) -> Result<(), InputError> {
        self.log.columns.push(header.columns);
        self.header = Some(header);
        self.just_after_header = true;
        Ok(())
    }

    fn units(&mut self, line: usize, cells: &[&str], of_cable: &[usize; CABLES]) -> Result<(), InputError> {
        for (cable, column) in of_cable.iter().enumerate() {
            if let Some(complaint) = cells.get(*column).and_then(|unit| complaint_about_unit(unit)) {
                return Err(self.log.at(line, cable, complaint));
            }
        }
        self.passed_over.units_line.get_or_insert(line);
        self.just_after_header = false;
        Ok(())
    }

    fn row(&mut self, line: usize, cells: &[&str]) -> Result<Row, InputError> {
        let Some(header) = &self.header else { unreachable!("rows come after the header") };
        let filled = cells.iter().rposition(|cell| !cell.is_empty()).map_or(0, |last| last + 1);
        if filled > header.width {
            let hint = if filled >= 2 * header.width { " (is the comma the decimal sign?)" } else { "" };
            let message = format!("{filled} values where the header has {}{hint}", header.width);
            return Err(InputError::at(self.log.file(), line, header.width + 1, message));
        }
        let mut lengths_mm = [0.0; CABLES];
        for (cable, length) in lengths_mm.iter_mut().enumerate() {
            *length = match cells.get(header.columns.of_cable[cable]) {
                None => return Err(self.log.at(line, cable, format!("missing; the line has {} values", cells.len()))),
                Some(&"") => return Err(self.log.at(line, cable, "empty".to_owned())),
                Some(cell) => self.numbers.read(cell).map_err(|message| self.log.at(line, cable, message))?,
            };
        }
        let row = Row { line, lengths_mm, samples: 1 };
        self.log.cables::<f64>(&row)?;
        Ok(row)
    }

    fn finish(mut self, last: usize) -> Result<LengthsFile, InputError> {
        let Some(header) = &self.header else {
            let message = format!("the file is empty; the header {} is wanted", NAMES[..self.cables].join(","));
            return Err(InputError::at(self.log.file(), 1, 1, message));
        };
        if self.log.rows.is_empty() {
            return Err(InputError::at(self.log.file(), last + 1, 1, "no pose follows the header"));
        }
        self.log.notes = notes(header, &self.numbers, &self.passed_over);
        Ok(self.log)
    }
}

/// Does this row hold a unit, or nothing, for every cable?
fn is_units(cells: &[&str], of_cable: &[usize; CABLES]) -> bool {
    of_cable.iter().all(|column| {
        let cell = cells.get(*column).copied().unwrap_or("");
        cell.len() <= 12 && cell.parse::<f64>().is_err() && !cell.contains(|c: char| c.is_ascii_digit())
    })
}

/// What was taken for what. A table in the plainest form needs no word.
fn notes(header: &Header, numbers: &Numbers, passed_over: &PassedOver) -> Vec<String> {
    let mut notes = Vec::new();
    let commas = header.separator == Separator::Sign(',');
    if !commas || numbers.sign == Some(DecimalSign::Comma) {
        let sign = match numbers.sign {
            Some(DecimalSign::Comma) => "the comma is the decimal sign",
            Some(DecimalSign::Point) => "the point is the decimal sign",
            None => "no number has decimals",
        };
        notes.push(format!("columns are separated by {}; {sign}", header.separator.called()));
    }
    if !header.others.is_empty() {
        notes.push(format!("columns left out: {}", header.others.join(", ")));
    }
    let mut passed = Vec::new();
    if passed_over.comments > 0 {
        passed.push(format!("{} comments", passed_over.comments));
    }
    if let Some(line) = passed_over.units_line {
        passed.push(format!("the units in line {line}"));
    }
    if let Some(line) = passed_over.header_again.first() {
        passed.push(format!("the header again, {} times, first in line {line}", passed_over.header_again.len()));
    }
    if passed_over.empty_rows > 0 {
        passed.push(format!("{} rows of empty cells", passed_over.empty_rows));
    }
    if !passed.is_empty() {
        notes.push(format!("passed over: {}", passed.join(", ")));
    }
    notes
}
