//! The text of a rig file: values by key, numbers, and places for complaints.

use crate::identify::input_error::{InputError, quoted};
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The text of a rig file, for places in it.
pub struct Source<'a> {
    /// Its name.
    pub file: &'a str,
    /// All of it.
    pub text: &'a str,
}

impl<'a> Source<'a> {
    /// The value of a key of the file.
    pub fn value<'t>(
        &self,
        table: &'t DeTable<'a>,
        key: &str,
        shape: &str,
    ) -> Result<&'t Spanned<DeValue<'a>>, InputError> {
        let end = self.text.len();
        table.get(key).ok_or_else(|| self.error(end..end, format!("{key} = {shape}, in mm, is missing")))
    }

    /// The `N` items of an array.
    /// The items of an array of a known length.
    pub fn items<'t, const N: usize>(
        &self,
        value: &'t Spanned<DeValue<'a>>,
        name: &str,
        what: &str,
    ) -> Result<&'t [Spanned<DeValue<'a>>; N], InputError> {
        let Some(array) = value.get_ref().as_array() else {
            let found = value.get_ref().type_str();
            return Err(self.error(value.span(), format!("{name}: {N} {what} are wanted, not {found}")));
        };
        let items: &[_] = array;
        items
            .try_into()
            .map_err(|_| self.error(value.span(), format!("{name}: {N} {what} are wanted, there are {}", items.len())))
    }

    /// A value of a table that begins at `span`.
    pub fn value_at<'t>(
        &self,
        span: Range<usize>,
        table: &'t DeTable<'a>,
        key: &str,
        shape: &str,
    ) -> Result<&'t Spanned<DeValue<'a>>, InputError> {
        table.get(key).ok_or_else(|| self.error(span, format!("{key} = {shape}, in mm, is missing")))
    }

    /// A finite number.
    pub fn number(&self, item: &Spanned<DeValue<'a>>, name: &str) -> Result<f64, InputError> {
        let parsed: Option<f64> = match item.get_ref() {
            DeValue::Float(float) => float.as_str().parse().ok(),
            DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str().parse().ok(),
            DeValue::Integer(integer) => {
                i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|integer| integer as f64)
            }
            _ => None,
        };
        parsed.filter(|number| number.is_finite()).ok_or_else(|| {
            let found = quoted(self.text.get(item.span()).unwrap_or(""));
            self.error(item.span(), format!("{name}: {found} is not a finite number"))
        })
    }

    /// An array of `N` finite numbers.
    pub fn numbers<const N: usize>(&self, value: &Spanned<DeValue<'a>>, name: &str) -> Result<[f64; N], InputError> {
        let mut numbers = [0.0; N];
        for (number, item) in numbers.iter_mut().zip(self.items::<N>(value, name, "numbers")?) {
            *number = self.number(item, name)?;
        }
        Ok(numbers)
    }

    /// An error where `span` begins.
    pub fn error(&self, span: Range<usize>, message: impl Into<String>) -> InputError {
        let before = self.text.get(..span.start).unwrap_or(self.text);
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
        InputError::at(self.file, line, column, message)
    }
}
