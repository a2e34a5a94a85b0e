//! A RIG.toml of a commissioned machine, as `cargo identify --rig` reads it.

use super::constants::packed;
use crate::identify::rig_file::RigFile;
use glenoid::identification::Machine;
use glenoid::identification::machine::MachineParameter;
use nalgebra::{DMatrix, Vector3};
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

/// The file's text. `heading`: what it comes from, a comment a line.
pub fn text(heading: &[String], found: &RigFile, machine: &Machine<f64>, covariance: &DMatrix<f64>) -> String {
    let rig = &found.rig;
    let mut text = String::new();
    for line in heading {
        let _ = writeln!(text, "# {}", line.replace('\n', " "));
    }
    let point = |p: &Vector3<f64>| list(p.as_slice());
    let _ = writeln!(text, "home = {}", list(&rig.drum().home_length_mm));
    if rig.cables().is_none() {
        let base: Vec<_> = rig.base_mm().iter().map(point).collect();
        let _ = writeln!(text, "base = [{}]", base.join(", "));
        let _ = writeln!(text, "edges = {}", list(rig.edges_mm()));
    }
    for cable in rig.cables().into_iter().flatten() {
        let _ = writeln!(text, "\n[[cable]]\nbase = {}\nend = {}", point(&cable.base_mm), point(&cable.end_mm));
        if cable.pulley.radius_mm > 0.0 {
            let (radius, axis) = (cable.pulley.radius_mm, point(&cable.pulley.axis));
            let _ = writeln!(text, "pulley_radius = {radius:?}\npulley_axis = {axis}");
        }
    }
    if let Some(samples) = found.samples_a_row {
        let (pose, sample) = (rig.length_noise_mm(), rig.sample_noise_mm());
        let _ = writeln!(text, "\n[noise]\npose = {pose:?}\nsample = {sample:?}\nsamples = {samples}");
    }
    let tolerance = rig.tolerance();
    let _ = writeln!(text, "\n# As it was before; [covariance] says what is left of it.\n[tolerance]");
    for (key, value) in [
        ("base", tolerance.base_mm),
        ("edges", tolerance.edges_mm),
        ("zero", tolerance.offset_mm),
        ("drum", tolerance.drum),
    ] {
        if value > 0.0 {
            let _ = writeln!(text, "{key} = {value:?}");
        }
    }
    if let Some(correction) = rig.correction() {
        let _ = writeln!(text, "\n# What each reading is too much, mm.\n[zeros]\nmm = {}", list(&correction.offset_mm));
        let _ = writeln!(text, "\n# Cable paid out for 1 mm stated.\n[drum]\nscale = {}", list(&correction.scale));
    }
    let _ = writeln!(text, "\n# Lower triangle, row by row; {}.\n[covariance]", parameters(machine));
    let triangle = packed(covariance);
    let _ = writeln!(text, "triangle = [");
    let mut rest = &triangle[..];
    for row in 1..=covariance.nrows() {
        let (entries, after) = rest.split_at(row);
        let entries: Vec<_> = entries.iter().map(|entry| format!("{entry:e}")).collect();
        let _ = writeln!(text, "  {},", entries.join(", "));
        rest = after;
    }
    text.push_str("]\n");
    text
}

/// What the rows of the covariance are.
fn parameters(machine: &Machine<f64>) -> String {
    let of = |is: fn(&MachineParameter) -> bool| {
        (0..machine.parameters()).filter(|index| is(&machine.parameter(*index))).count()
    };
    let kinds = [
        (of(|p| matches!(p, MachineParameter::Base(_))), "modes of the base's shape (mm)"),
        (of(|p| matches!(p, MachineParameter::Ends(_))), "platform edges, or modes of its shape (mm)"),
        (of(|p| matches!(p, MachineParameter::Offset(_))), "encoder offsets (mm)"),
        (of(|p| matches!(p, MachineParameter::Scale(_))), "drum scales (per cent)"),
    ];
    let kinds: Vec<_> = kinds.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}")).collect();
    kinds.join(", ")
}

fn list(numbers: &[f64]) -> String {
    let numbers: Vec<_> = numbers.iter().map(|number| format!("{number:?}")).collect();
    format!("[{}]", numbers.join(", "))
}

/// Writes a file whole or not at all: a temporary file beside it takes its place.
///
/// # Errors
/// What the operating system says; the file is as it was then.
pub fn write_whole(path: &Path, text: &str) -> std::io::Result<()> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let temporary = path.with_file_name(format!(".{name}.{}.tmp", std::process::id()));
    let written = std::fs::File::create(&temporary)
        .and_then(|mut file| file.write_all(text.as_bytes()).and_then(|()| file.sync_all()))
        .and_then(|()| std::fs::rename(&temporary, path));
    if written.is_err() {
        let _ = std::fs::remove_file(&temporary);
    }
    written
}
