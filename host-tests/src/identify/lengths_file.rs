//! A recorded log: a table of cable lengths with the header `l1,l2,l3,l4,l5,l6`, one pose a line, mm.
//!
//! Read by hand rather than with a CSV library, because every complaint names its line and column: the libraries drop
//! the place of a field, and count the lines of a file with CRLF or blank lines in their own way.

use super::input_error::{self, InputError, quoted};
use glenoid::kinematics::CableLengths;
use glenoid::rig::CABLES;
use glenoid::scalar::Real;
use std::path::Path;

/// The columns of a log, in the order of the cables.
const HEADER: [&str; CABLES] = ["l1", "l2", "l3", "l4", "l5", "l6"];

/// One pose of a log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Line in the file, from 1.
    pub line: usize,
    /// L1..L6, mm, each finite and positive.
    pub lengths_mm: [f64; CABLES],
}

/// A log with at least one pose.
#[derive(Clone, Debug, PartialEq)]
pub struct LengthsFile {
    file: String,
    /// Column (from 0) of each cable.
    columns: [usize; CABLES],
    rows: Vec<Row>,
}

impl LengthsFile {
    /// Reads a log.
    ///
    /// # Errors
    /// [`InputError`] names the first place that cannot be read.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let (file, bytes) = input_error::read(path)?;
        Self::parse(&file, &bytes)
    }

    /// Reads a log from its bytes. `file` is its name for messages.
    ///
    /// # Errors
    /// [`InputError`] names the first place that cannot be read.
    pub fn parse(file: &str, bytes: &[u8]) -> Result<Self, InputError> {
        let text = as_text(file, bytes)?;
        // Blank lines separate nothing; a file that ends in one has no pose there.
        let mut lines = lines(&text).filter(|(_, line)| !line.trim().is_empty());
        let Some((line, header)) = lines.next() else {
            return Err(InputError::at(file, 1, 1, "the file is empty; the header l1,l2,l3,l4,l5,l6 is wanted"));
        };
        let mut log = Self { file: file.to_owned(), columns: columns(file, line, header)?, rows: Vec::new() };
        let mut last = line;
        for (line, text) in lines {
            let row = log.row(line, text)?;
            log.rows.push(row);
            last = line;
        }
        if log.rows.is_empty() {
            return Err(InputError::at(file, last + 1, 1, "no pose follows the header"));
        }
        Ok(log)
    }

    /// The log's name for messages.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// The poses, in the order of the file.
    pub fn rows(&self) -> &[Row] {
        &self.rows
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

    /// An error at a cable (from 0) of a line.
    pub fn at(&self, line: usize, cable: usize, message: String) -> InputError {
        let name = HEADER[cable];
        InputError::at(&self.file, line, self.columns[cable] + 1, format!("{name}: {message}"))
    }

    fn row(&self, line: usize, text: &str) -> Result<Row, InputError> {
        let fields: Vec<&str> = fields(text).collect();
        if fields.len() > CABLES {
            let hint = if fields.len() == 2 * CABLES { " (is the comma the decimal sign?)" } else { "" };
            let message = format!("{} values where the header has {CABLES}{hint}", fields.len());
            return Err(InputError::at(&self.file, line, CABLES + 1, message));
        }
        let mut lengths_mm = [0.0; CABLES];
        for (cable, length) in lengths_mm.iter_mut().enumerate() {
            *length = match fields.get(self.columns[cable]) {
                None => return Err(self.at(line, cable, format!("missing; the line has {} values", fields.len()))),
                Some(&"") => return Err(self.at(line, cable, "empty".to_owned())),
                Some(field) => {
                    field.parse().map_err(|_| self.at(line, cable, format!("{} is not a number", quoted(field))))?
                }
            };
        }
        let row = Row { line, lengths_mm };
        self.cables::<f64>(&row)?;
        Ok(row)
    }
}

/// Which column holds which cable. Any order will do, as the header names them.
fn columns(file: &str, line: usize, header: &str) -> Result<[usize; CABLES], InputError> {
    let error = |column: usize, message: String| Err(InputError::at(file, line, column + 1, message));
    let wanted = HEADER.join(",");
    let names: Vec<String> = fields(header).map(str::to_lowercase).collect();
    if names.iter().all(|name| name.parse::<f64>().is_ok()) {
        return error(0, format!("the first line holds numbers; the header {wanted} is wanted before them"));
    }
    if names.len() == 1 {
        for (sign, called) in [(';', "semicolons"), ('\t', "tabs"), (' ', "blanks")] {
            if header.trim().contains(sign) {
                return error(0, format!("the columns are separated by {called}; commas are wanted"));
            }
        }
    }
    let mut columns = [None; CABLES];
    for (column, name) in names.iter().enumerate() {
        let Some(cable) = HEADER.iter().position(|known| known == name) else {
            return error(column, format!("unknown column {}; the header is {wanted}", quoted(name)));
        };
        if columns[cable].replace(column).is_some() {
            return error(column, format!("the column {name} appears twice"));
        }
    }
    let mut found = [0; CABLES];
    for (cable, column) in columns.into_iter().enumerate() {
        match column {
            Some(column) => found[cable] = column,
            None => return error(names.len(), format!("the column {} is missing", HEADER[cable])),
        }
    }
    Ok(found)
}

/// The fields of a line, without blanks and quotation marks around them. Numbers hold no comma, so a quoted one need
/// not be looked for.
fn fields(line: &str) -> impl Iterator<Item = &str> {
    line.split(',').map(|field| {
        let field = field.trim();
        field.strip_prefix('"').and_then(|inner| inner.strip_suffix('"')).map_or(field, str::trim)
    })
}

/// The lines of a text with their numbers from 1, whether they end in LF, CRLF or (an old spreadsheet's) CR.
fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    text.split('\n')
        .flat_map(|line| line.strip_suffix('\r').unwrap_or(line).split('\r'))
        .enumerate()
        .map(|(index, line)| (index + 1, line))
}

/// UTF-8 without its byte order mark.
fn as_text(file: &str, bytes: &[u8]) -> Result<String, InputError> {
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err(InputError::at(file, 1, 1, "the file is UTF-16; save it as CSV in UTF-8"));
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    match std::str::from_utf8(bytes) {
        Ok(text) => Ok(text.to_owned()),
        Err(error) => {
            // Everything before the place is sound, so its line and column can be counted.
            let before = String::from_utf8_lossy(&bytes[..error.valid_up_to()]);
            let (line, text) = lines(&before).last().unwrap_or((1, ""));
            let byte = bytes.get(error.valid_up_to()).copied().unwrap_or(0);
            Err(InputError::at(file, line, fields(text).count(), format!("the byte 0x{byte:02x} is not UTF-8 text")))
        }
    }
}
