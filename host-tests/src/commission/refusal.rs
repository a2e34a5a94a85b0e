//! Why nothing was commissioned, by name.

use crate::identify::input_error::Place;
use std::fmt;

/// What is refused, and where it is stated.
#[derive(Clone, Debug, PartialEq)]
pub struct Refused {
    /// Where it stands.
    pub place: Option<Place>,
    /// Why, in words.
    pub reason: String,
}

impl Refused {
    /// Something that stands at a place of COMMISSION.toml.
    pub fn at(place: Place, reason: impl Into<String>) -> Self {
        Self { place: Some(place), reason: reason.into() }
    }

    /// Something that stands nowhere in particular.
    pub fn everywhere(reason: impl Into<String>) -> Self {
        Self { place: None, reason: reason.into() }
    }
}

impl fmt::Display for Refused {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(Place { file, line, .. }) = &self.place {
            write!(out, "{file}, line {line}: ")?;
        }
        out.write_str(&self.reason)
    }
}
