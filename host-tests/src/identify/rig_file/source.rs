//! The text of a TOML file (a rig's, an arm's, a commissioning's): values by key, numbers, and places for complaints.

use crate::identify::input_error::{InputError, quoted};
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The text of a TOML file, for places in it.
pub struct Source<'a> {
    /// Its name.
    pub file: &'a str,
    /// All of it.
    pub text: &'a str,
}

impl<'a> Source<'a> {
    /// The text of a file from its bytes, without a byte order mark. `file` is its name for messages.
    ///
    /// # Errors
    /// [`InputError`] names the place of the first byte that is no UTF-8.
    pub fn of(file: &'a str, bytes: &'a [u8]) -> Result<Self, InputError> {
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        match std::str::from_utf8(bytes) {
            Ok(text) => Ok(Self { file, text }),
            Err(error) => {
                let before = String::from_utf8_lossy(&bytes[..error.valid_up_to()]);
                Err(Source { file, text: &before }.error(before.len()..before.len(), "not UTF-8 text"))
            }
        }
    }

    /// The file's keys and sections, whatever they are called.
    ///
    /// # Errors
    /// [`InputError`] names the place that is no TOML.
    pub fn any_table(&self) -> Result<DeTable<'a>, InputError> {
        let end = self.text.len();
        DeTable::parse(self.text)
            .map(Spanned::into_inner)
            .map_err(|error| self.error(error.span().unwrap_or(end..end), error.message()))
    }

    /// Refuses the first key of `table` that is not among those known. `name` is what the table is called in messages.
    ///
    /// # Errors
    /// [`InputError`] names the key, its place and what may be there.
    pub fn refuse_unknown(&self, table: &DeTable, name: &str, known: &[&str]) -> Result<(), InputError> {
        match table.iter().map(|(key, _)| key).find(|key| !known.contains(&key.get_ref().as_ref())) {
            None => Ok(()),
            Some(key) => {
                let complaint = format!("unknown key {}: {name} may hold {}", quoted(key.get_ref()), known.join(", "));
                Err(self.error(key.span(), complaint))
            }
        }
    }

    /// The value of a key of the file. `shape` is what is wanted of it.
    pub fn value<'t>(
        &self,
        table: &'t DeTable<'a>,
        key: &str,
        shape: &str,
    ) -> Result<&'t Spanned<DeValue<'a>>, InputError> {
        let end = self.text.len();
        self.value_at(end..end, table, key, shape)
    }

    /// The `N` items of an array.
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

    /// The value of a key of a table that begins at `span`. `shape` is what is wanted of it.
    pub fn value_at<'t>(
        &self,
        span: Range<usize>,
        table: &'t DeTable<'a>,
        key: &str,
        shape: &str,
    ) -> Result<&'t Spanned<DeValue<'a>>, InputError> {
        table.get(key).ok_or_else(|| self.error(span, format!("{key} = {shape} is missing")))
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
            let written = self.text.get(item.span()).unwrap_or("");
            let message = match item.get_ref() {
                DeValue::String(_) => format!("{name}: a number is wanted, not the text {written}"),
                _ => format!("{name}: {} is not a finite number", quoted(written)),
            };
            self.error(item.span(), message)
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
