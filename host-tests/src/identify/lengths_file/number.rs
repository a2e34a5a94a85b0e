//! A length in a cell of a table.

use crate::identify::input_error::quoted;

/// What stands between the digits before and after the unit's place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DecimalSign {
    Point,
    Comma,
}

/// Reads the numbers of one file, in which the decimal sign is one and the same.
#[derive(Debug, Default)]
pub(super) struct Numbers {
    /// None until a number had one.
    pub(super) sign: Option<DecimalSign>,
}

impl Numbers {
    /// A number.
    ///
    /// # Errors
    /// What is wrong with it, in words.
    pub(super) fn read(&mut self, cell: &str) -> Result<f64, String> {
        let sign = match (cell.contains('.'), cell.contains(',')) {
            (false, false) => None,
            (true, false) => Some(DecimalSign::Point),
            (false, true) => Some(DecimalSign::Comma),
            // Thousands and decimals: which is which, nobody said.
            (true, true) => return Err(format!("{} is not a number", quoted(cell))),
        };
        match (sign, self.sign) {
            (Some(DecimalSign::Comma), Some(DecimalSign::Point)) => {
                return Err(format!("{} has a decimal comma, the numbers before it have a point", quoted(cell)));
            }
            (Some(DecimalSign::Point), Some(DecimalSign::Comma)) => {
                return Err(format!("{} has a decimal point, the numbers before it have a comma", quoted(cell)));
            }
            _ => {}
        }
        let parsed = if sign == Some(DecimalSign::Comma) { cell.replace(',', ".").parse() } else { cell.parse() };
        let number = parsed.map_err(|_| format!("{} is not a number", quoted(cell)))?;
        self.sign = self.sign.or(sign);
        Ok(number)
    }
}
