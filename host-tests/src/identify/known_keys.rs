//! What a rig file may hold. Anything else is refused: a key that was misspelt must not be passed over.

use super::input_error::quoted;
use std::ops::Range;
use toml::de::{DeTable, DeValue};

/// The keys of the file itself, beside its sections.
const VALUES: &[&str] = &["base", "edges", "home", "joint"];

/// The sections, and the keys that each may hold. [`ANYTHING`] is for people and other programs, and is not read.
const SECTIONS: &[(&str, &[&str])] = &[
    ("cable", &["base", "end", "pulley_radius", "pulley_axis"]),
    ("noise", &["pose", "sample", "samples"]),
    ("tolerance", &["base", "edges", "zero", "drum"]),
    ("zeros", &["mm"]),
    ("drum", &["scale"]),
    ("covariance", &["parameters", "triangle"]),
    (
        "hinge",
        &[
            "axis",
            "point",
            "axis_in_platform",
            "point_in_platform",
            "range_deg",
            "sigma_deg",
            "sigma_mm",
            "sigma_in_platform_deg",
            "sigma_in_platform_mm",
            "sigma_along_mm",
        ],
    ),
    ("start", &["values"]),
    ("truth", ANYTHING),
];

const ANYTHING: &[&str] = &[];

/// The first key of the file that is not known: where it stands, and a complaint.
pub fn unknown(file: &DeTable) -> Option<(Range<usize>, String)> {
    let of_file: Vec<&str> = VALUES.iter().copied().chain(SECTIONS.iter().map(|(name, _)| *name)).collect();
    let in_sections = SECTIONS.iter().filter(|(_, keys)| *keys != ANYTHING).flat_map(|(name, keys)| {
        let of_section = file.get(*name).map(|section| tables(section.get_ref())).unwrap_or_default();
        of_section.into_iter().flat_map(move |table| unknown_of(table, name, keys))
    });
    unknown_of(file, "the file", &of_file).into_iter().chain(in_sections).min_by_key(|(place, _)| place.start)
}

/// Every key of one table that is not among those known.
fn unknown_of(table: &DeTable, name: &str, known: &[&str]) -> Vec<(Range<usize>, String)> {
    let complaint = |key: &str| format!("unknown key {}: {name} may hold {}", quoted(key), known.join(", "));
    let keys = table.iter().map(|(key, _)| key).filter(|key| !known.contains(&key.get_ref().as_ref()));
    keys.map(|key| (key.span(), complaint(key.get_ref()))).collect()
}

/// A section's table, or the tables of a section that may be given several times (`[[name]]`).
fn tables<'t, 'a>(section: &'t DeValue<'a>) -> Vec<&'t DeTable<'a>> {
    match section {
        DeValue::Table(table) => vec![table],
        DeValue::Array(items) => items.iter().filter_map(|item| item.get_ref().as_table()).collect(),
        _ => Vec::new(),
    }
}
