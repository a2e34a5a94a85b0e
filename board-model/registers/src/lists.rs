//! The two lists beside this crate: one entry a line; empty lines, and lines that begin with `#`, are left out.

use std::collections::BTreeMap;
use std::path::Path;
use std::{fs, io};

/// The entries of a list, each with the number of its line.
pub type Entries = BTreeMap<String, usize>;

/// Reads a list with `parse`, which has its name and its text.
///
/// # Errors
/// The file cannot be read, or `parse` does not understand it; the text names the file, and the line where there is one.
pub fn read(path: &str, parse: fn(&str, &str) -> Result<Entries, String>) -> io::Result<Entries> {
    let name = Path::new(path).file_name().map_or(path.into(), |name| name.to_string_lossy());
    let text = fs::read_to_string(path).map_err(|error| io::Error::new(error.kind(), format!("{name}: {error}")))?;
    parse(&name, &text).map_err(io::Error::other)
}

/// The entries of the list `name`: what `entry` makes of each line, or says against it. None may be there twice.
///
/// # Errors
/// What `entry` says, behind the list's name and the number of the line.
pub fn entries(name: &str, text: &str, entry: fn(&str) -> Result<&str, String>) -> Result<Entries, String> {
    let mut entries = Entries::new();
    for (index, line) in text.lines().enumerate().filter(|(_, line)| !line.is_empty() && !line.starts_with('#')) {
        let number = index + 1;
        let found = entry(line).map_err(|wrong| format!("{name}, line {number}: {wrong}"))?;
        if let Some(first) = entries.insert(found.to_owned(), number) {
            return Err(format!("{name}, line {number}: the same as line {first}"));
        }
    }
    Ok(entries)
}
