//! The registers that the image touches, by name.

use std::collections::BTreeSet;
use std::{fs, io};

/// One name a line.
const LIST: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/touched.txt");

/// Their names: peripheral and register, as the vendor has them.
///
/// # Errors
/// The list cannot be read.
pub fn names() -> io::Result<BTreeSet<String>> {
    let list = fs::read_to_string(LIST)?;
    Ok(list.lines().filter(|line| !line.is_empty() && !line.starts_with('#')).map(str::to_owned).collect())
}
