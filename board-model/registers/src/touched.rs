//! The registers that the image touches, by name.

use crate::PERIPHERALS;
use crate::lists::{self, Entries};
use std::collections::BTreeSet;
use std::io;

/// One name a line.
const LIST: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/touched.txt");

/// Their names: peripheral and register, as the vendor has them.
///
/// # Errors
/// The list cannot be read.
pub fn names() -> io::Result<BTreeSet<String>> {
    Ok(list()?.into_keys().collect())
}

/// The names, each with its line in `touched.txt`.
///
/// # Errors
/// The list cannot be read.
pub fn list() -> io::Result<Entries> {
    lists::read(LIST, parse)
}

/// The names in the text of the list `name`.
///
/// # Errors
/// A line that is no name of a register, by its number.
pub fn parse(name: &str, text: &str) -> Result<Entries, String> {
    lists::entries(name, text, |line| match line.split_once('.') {
        Some((peripheral, register)) if !register.is_empty() => {
            let is_known = PERIPHERALS.iter().any(|known| known.name == peripheral);
            is_known.then_some(line).ok_or_else(|| format!("no peripheral {peripheral} is known"))
        }
        _ => Err(format!("`{line}` is not PERIPHERAL.REGISTER")),
    })
}
