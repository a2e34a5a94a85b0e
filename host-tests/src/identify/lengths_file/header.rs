//! The header of a table: what separates the columns, and which of them holds which cable.

use super::{Columns, NAMES};
use crate::identify::input_error::{InputError, quoted};
use glenoid::rig::CABLES;

/// What stands between two columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Separator {
    Sign(char),
    /// Any number of blanks.
    Blanks,
}

impl Separator {
    /// All that are known. The first that finds the cables in the header is taken.
    const KNOWN: [Self; 5] = [Self::Sign(','), Self::Sign(';'), Self::Sign('\t'), Self::Sign('|'), Self::Blanks];

    /// In words, for a note.
    pub(super) fn called(self) -> &'static str {
        match self {
            Self::Sign(';') => "semicolons",
            Self::Sign('\t') => "tabs",
            Self::Sign('|') => "bars",
            Self::Sign(_) => "commas",
            Self::Blanks => "blanks",
        }
    }

    /// The cells of a line, without the blanks and quotation marks around them. A separator between quotation marks
    /// separates nothing.
    pub(super) fn cells<'a>(self, line: &'a str, cells: &mut Vec<&'a str>) {
        cells.clear();
        match self {
            Self::Blanks => cells.extend(line.split_whitespace().map(bare)),
            Self::Sign(sign) => {
                let (mut start, mut quoted) = (0, false);
                for (at, character) in line.char_indices() {
                    if character == '"' {
                        quoted = !quoted;
                    } else if character == sign && !quoted {
                        cells.push(bare(&line[start..at]));
                        start = at + character.len_utf8();
                    }
                }
                cells.push(bare(&line[start..]));
            }
        }
    }

    /// The separator that a spreadsheet's first line `sep=;` names.
    pub(super) fn named_by(line: &str) -> Option<Self> {
        let (key, sign) = line.trim_matches(|c: char| c == '"' || c == '\u{feff}').split_once('=')?;
        let mut signs = sign.chars();
        match (key.trim().eq_ignore_ascii_case("sep"), signs.next(), signs.as_str().trim()) {
            (true, Some(sign @ (',' | ';' | '\t' | '|')), "" | "\"") => Some(Self::Sign(sign)),
            (true, Some(' '), "") => Some(Self::Blanks),
            _ => None,
        }
    }
}

/// A header that names each cable once.
#[derive(Clone, Debug)]
pub(super) struct Header {
    pub(super) separator: Separator,
    pub(super) columns: Columns,
    /// Number of columns.
    pub(super) width: usize,
    /// Names of the columns that hold no cable, with their place from 1.
    pub(super) others: Vec<String>,
}

impl Header {
    /// Reads the header of so many cables from a line. The places beyond them are those of the first.
    ///
    /// # Errors
    /// [`InputError`] says which column is missing, or twice there, or not in millimetres.
    pub(super) fn parse(
        file: &str,
        line: usize,
        text: &str,
        named: Option<Separator>,
        cables: usize,
    ) -> Result<Self, InputError> {
        let known = named.map_or(Separator::KNOWN.to_vec(), |separator| vec![separator]);
        let found = known.into_iter().map(|separator| (separator, cables_in(separator, text).iter().flatten().count()));
        // Of several that find as many, the first.
        let best = found.rev().max_by_key(|(_, count)| *count);
        match best {
            Some((separator, count)) if count > 0 => Self::with(file, line, text, separator, cables),
            _ => {
                let numbers = text.split([',', ';', '\t', ' ']).all(|cell| bare(cell).parse::<f64>().is_ok());
                let message = if numbers {
                    format!(
                        "the first line holds numbers; the header {} is wanted before them",
                        NAMES[..cables].join(",")
                    )
                } else if let Some(separator) = named {
                    let called = separator.called();
                    format!("no column is called l1 to l6, if {called} separate them as the line sep= says")
                } else {
                    let wanted = NAMES[..cables].join(",");
                    format!("no header {wanted}, but {}; is this a log of cable lengths?", quoted(text.trim()))
                };
                Err(InputError::at(file, line, 1, message))
            }
        }
    }

    fn with(file: &str, line: usize, text: &str, separator: Separator, cables: usize) -> Result<Self, InputError> {
        let error = |column: usize, message: String| Err(InputError::at(file, line, column + 1, message));
        let mut cells = Vec::new();
        separator.cells(text, &mut cells);
        let width = cells.len();
        let named = cells.iter().rposition(|cell| !cell.is_empty()).map_or(0, |last| last + 1);
        let (mut columns, mut others) = ([None; CABLES], Vec::new());
        for (column, cell) in cells.iter().enumerate().take(named) {
            let Some((cable, unit)) = cable_named(cell).filter(|(cable, _)| *cable < cables) else {
                others.push(if cell.is_empty() { format!("column {}", column + 1) } else { quoted(cell) });
                continue;
            };
            if columns[cable].replace(column).is_some() {
                return error(column, format!("the column {} appears twice", NAMES[cable]));
            }
            if let Some(complaint) = unit.and_then(complaint_about_unit) {
                return error(column, format!("{}: {complaint}", NAMES[cable]));
            }
        }
        let mut of_cable = [columns[0].unwrap_or(0); CABLES];
        for (cable, column) in columns.into_iter().enumerate().take(cables) {
            match column {
                Some(column) => of_cable[cable] = column,
                None => return error(named, format!("the column {} is missing", NAMES[cable])),
            }
        }
        Ok(Self { separator, columns: Columns { from_line: line, of_cable }, width, others })
    }
}

/// The cable (from 0) and the unit that a column's name speaks of: `l1`, `L_1`, `length 1`, `l1 [mm]`, `l1_mm`.
fn cable_named(name: &str) -> Option<(usize, Option<&str>)> {
    let rest = name.trim_start();
    let letters = rest.find(|c: char| !c.is_ascii_alphabetic())?;
    if !matches!(rest[..letters].to_ascii_lowercase().as_str(), "l" | "length") {
        return None;
    }
    let rest = rest[letters..].trim_start_matches([' ', '_', '-']);
    let cable = match rest.as_bytes().first() {
        Some(digit @ b'1'..=b'6') => usize::from(digit - b'1'),
        _ => return None,
    };
    match rest[1..].trim() {
        "" => Some((cable, None)),
        unit if unit.starts_with(['[', '(', '/', '_', ' ']) || rest[1..].starts_with(' ') => Some((cable, Some(unit))),
        _ => None,
    }
}

fn cables_in(separator: Separator, text: &str) -> [Option<usize>; CABLES] {
    let mut cells = Vec::new();
    separator.cells(text, &mut cells);
    let mut found = [None; CABLES];
    for (column, cell) in cells.iter().enumerate() {
        if let Some((cable, _)) = cable_named(cell) {
            found[cable] = Some(column);
        }
    }
    found
}

/// A unit that is not the millimetre. What is no unit at all says nothing.
pub(super) fn complaint_about_unit(unit: &str) -> Option<String> {
    let unit = unit.trim_matches(|c: char| c.is_whitespace() || "[](){}/_".contains(c)).to_lowercase();
    let called = match unit.as_str() {
        "m" | "metre" | "metres" | "meter" | "meters" => "metres",
        "cm" => "centimetres",
        "in" | "inch" | "inches" | "\"" => "inches",
        "µm" | "um" => "micrometres",
        "count" | "counts" | "ticks" => "counts",
        _ => return None,
    };
    Some(format!("the column is in {called}; millimetres are wanted"))
}

/// A cell without the blanks and one pair of quotation marks around it.
fn bare(cell: &str) -> &str {
    let cell = cell.trim();
    cell.strip_prefix('"').and_then(|inner| inner.strip_suffix('"')).map_or(cell, str::trim)
}
