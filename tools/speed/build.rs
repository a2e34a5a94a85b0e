//! The link arguments of the speed image, and its problem as Rust constants.

use std::fmt::Write;
use std::path::PathBuf;
use std::{env, fs, io};

/// cortex-m-rt asks for this file by name. It would hold default handlers; the vector table names its handler itself.
const DEVICE_X: &str = "/* every vector is given in startup.rs */\n";

/// The code that a board keeps in its core-coupled memory, in one piece: this image runs it where it is stored, and `cargo
/// cycles` counts no wait for it.
const CCM_X: &str = "SECTIONS { .ccm_code : ALIGN(8) { *(.ccm_code .ccm_code.*) } > FLASH } INSERT AFTER .rodata;\n";

/// The problem that the speed figures are measured on: cable lengths, and the rig with start and truth.
const PROBLEM: [&str; 2] = ["host-tests/data/speed-problem.csv", "host-tests/data/speed-problem.toml"];

fn main() -> io::Result<()> {
    println!("cargo::rerun-if-changed=build.rs");
    if env::var_os("CARGO_FEATURE_IMAGE").is_none() {
        return Ok(());
    }
    // `memory.x` is that of the boards, at the root of the workspace
    let root = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default()).join("../..");
    let out_dir = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    println!("cargo::rerun-if-changed={}", root.join("memory.x").display());
    fs::write(out_dir.join("device.x"), DEVICE_X)?;
    fs::write(out_dir.join("ccm_in_place.x"), CCM_X)?;
    for argument in [
        format!("-L{}", out_dir.display()),
        format!("-L{}", root.display()),
        "--defsym=FLASH_ORIGIN=0".to_owned(),
        // More than a board has: 100 poses and the estimator in double precision, in which no board computes.
        "--defsym=RAM_LENGTH=1M".to_owned(),
        "--defsym=CCM_ORIGIN=0x20100000".to_owned(),
        // Before link.x: of two scripts that could place a function, the first one does.
        "-Tccm_in_place.x".to_owned(),
        "-Tlink.x".to_owned(),
    ] {
        println!("cargo::rustc-link-arg-bins={argument}");
    }
    let [lengths, rig] = PROBLEM.map(|file| root.join(file));
    println!("cargo::rerun-if-changed={}", lengths.display());
    println!("cargo::rerun-if-changed={}", rig.display());
    let problem = problem(&fs::read_to_string(lengths)?, &fs::read_to_string(rig)?);
    fs::write(out_dir.join("speed_problem.rs"), problem.ok_or_else(|| io::Error::other("malformed speed problem"))?)
}

/// The problem as Rust constants, in mm. The digits are handed over as they stand: the image's own compiler reads them.
fn problem(lengths: &str, rig: &str) -> Option<String> {
    let rows: Vec<&str> = lengths.lines().skip(1).map(str::trim).filter(|row| !row.is_empty()).collect();
    let mut text = format!("pub const POSES: usize = {};\n", rows.len());
    writeln!(text, "pub const LENGTHS_MM: [[f64; 6]; POSES] = [").ok()?;
    for row in rows {
        writeln!(text, "    [{row}],").ok()?;
    }
    writeln!(text, "];").ok()?;
    // the TOML is this project's own and has one list a line
    let mut section = "";
    for line in rig.lines().map(|line| line.split_once('#').map_or(line, |(before, _)| before).trim()) {
        if let Some(name) = line.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
            section = name;
        } else if let Some((name, list)) = line.split_once('=') {
            let (constant, shape) = match (section, name.trim()) {
                ("", "base") => ("BASE_MM", "[[f64; 3]; 3]"),
                ("", "edges") => ("EDGES_MM", "[f64; 3]"),
                ("start", "values") => ("START_MM", "[f64; 6]"),
                ("truth", "values") => ("TRUTH_MM", "[f64; 6]"),
                _ => return None,
            };
            writeln!(text, "pub const {constant}: {shape} = {};", list.trim()).ok()?;
        }
    }
    Some(text)
}
