//! The differences that are known, each with the reason for which it does not matter.

use crate::lists::{self, Entries};
use std::io;

/// One difference a line, its reason behind ` # `.
const LIST: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/differences.txt");

/// The differences as [`crate::compare::Difference`] writes them, each with its line in `differences.txt`.
///
/// # Errors
/// The list cannot be read.
pub fn list() -> io::Result<Entries> {
    lists::read(LIST, parse)
}

/// The differences in the text of the list `name`.
///
/// # Errors
/// A line without a reason, by its number.
pub fn parse(name: &str, text: &str) -> Result<Entries, String> {
    lists::entries(name, text, |line| match line.split_once(" # ") {
        Some((difference, reason)) if !reason.trim().is_empty() => Ok(difference.trim()),
        _ => Err("no reason behind ` # `".to_owned()),
    })
}
