//! Poses, numbers, lengths and directions as people read them.

use super::lengths_file::LengthsFile;

/// A pose by its number and its line in the log.
pub fn pose(pose: usize, log: &LengthsFile) -> String {
    match log.rows().get(pose) {
        Some(row) => format!("pose {pose} (line {})", row.line),
        None => format!("pose {pose}"),
    }
}

/// A direction in the base's frame.
pub fn direction(unit: &[f64; 3]) -> String {
    let [x, y, z] = unit.map(|component| fixed(component, 2));
    format!("({x}, {y}, {z}) in {{B}}")
}

/// A number of things.
pub fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// A length in mm; one that would print as zero is printed as small.
pub fn small(value: f64) -> String {
    if value > 0.0 && value < 5e-5 { "<0.0001".to_owned() } else { fixed(value, 4) }
}

/// Fixed decimals, and no minus before a zero.
pub fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(zero) if zero.chars().all(|c| c == '0' || c == '.') => zero.to_owned(),
        _ => text,
    }
}
