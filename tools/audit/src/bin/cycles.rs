//! `cargo cycles`: what the library costs on the Cortex-M4F, counted in the emulator.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use audit::cycles::profile::{self, Place};
use audit::cycles::record::Record;
use audit::cycles::trace::{self, PLACEMENTS, Trace};
use audit::cycles::{agreement, figures, flash, run, table};
use clap::Parser;
use host_tests::command_line;
use host_tests::emulator;
use host_tests::firmware::{self, Toolchain};
use host_tests::packages::Consent;

/// Count what every path of the library costs on the Cortex-M4F: instructions, estimated cycles, flash, static memory,
/// stack. Prints a table; writes it and all figures to target/cycles.
#[derive(Parser)]
#[command(name = "cargo cycles", bin_name = "cargo cycles")]
struct Arguments {
    /// Compare with the figures kept in this CSV file; exit 1 when one has grown by more than 3 %
    #[arg(long, value_name = "FILE")]
    check: Option<PathBuf>,
    /// Put the figures into this CSV file, in place of those of the same toolchain
    #[arg(long, value_name = "FILE", conflicts_with = "check")]
    keep: Option<PathBuf>,
    /// The document that shows the table of the kept figures: with --check, its table must be that of FILE; with
    /// --keep, it is put in
    #[arg(long, value_name = "DOCUMENT")]
    document: Option<PathBuf>,
    /// Print where the instructions of this path go, by function, line and symbol, instead of the table
    #[arg(long, value_name = "PATH", conflicts_with_all = ["keep", "check", "document"])]
    profile: Option<String>,
    /// With --profile: of its dearest count alone, such as the longest slice or tick
    #[arg(long, requires = "profile")]
    worst: bool,
    /// With --profile: of all its counts with more estimated cycles than this
    #[arg(long, requires = "profile", conflicts_with = "worst", value_name = "CYCLES")]
    above: Option<u64>,
    /// Install what is missing without asking
    #[arg(long)]
    yes: bool,
}

/// Lines of each list of a profile.
const PROFILE_LINES: usize = 40;
/// Lines of the list of modules.
const MODULE_LINES: usize = 12;

fn main() -> ExitCode {
    match measure(&command_line::parse::<Arguments>()) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("cargo cycles: {error}");
            ExitCode::FAILURE
        }
    }
}

fn measure(arguments: &Arguments) -> Result<bool, Box<dyn Error>> {
    let consent = if arguments.yes { Consent::Given } else { Consent::Ask };
    emulator::ensure_installed(consent)?;
    let toolchain = firmware::choose_toolchain(consent)?;
    if let Some(name) = &arguments.profile {
        profile_path(toolchain, name, arguments)?;
        return Ok(true);
    }
    // Each image takes the place of the one before.
    let mut double = run::paths(&flash::build(toolchain, flash::DOUBLE)?)?;
    let (mut device, mut traced_device) = device_events(toolchain)?;
    let mut elbow = run::paths(&flash::build(toolchain, flash::ELBOW)?)?;
    elbow.retain(|path| path.name.starts_with(flash::ELBOW));
    let image = flash::build(toolchain, flash::SINGLE)?;
    let paths = single_precision_paths(&image)?;
    double.retain(|path| path.precision == flash::DOUBLE);
    let mut traced = agreement::assign(&paths, &trace::single_precision(&image)?)?;
    let modules = flash::by_module(&image)?;
    let parts = flash::parts(toolchain)?;
    let (literal, traced_literal) = literal_for_speed(toolchain)?;
    let name = toolchain.name_and_version()?;
    // Double precision and the elbow are not traced.
    double.append(&mut elbow);
    traced.resize(paths.len() + double.len(), None);
    traced.append(&mut traced_device);
    double.append(&mut device);
    let paths = [paths, double, literal].concat();
    let record = Record::of_run(&name, &paths, &[traced, traced_literal].concat(), &parts);
    print_and_save(&record, &name, &modules)?;
    keep_or_check(arguments, &record)
}

/// Paths as the board counts them, each with what the trace says of it.
type Counted = (Vec<figures::Path>, Vec<Option<agreement::Traced>>);

/// The literal form compiled for speed, counted like everything else.
fn literal_for_speed(toolchain: Toolchain) -> Result<Counted, Box<dyn Error>> {
    let image = flash::build_literal_for_speed(toolchain)?;
    let paths = run::paths(&image)?;
    let traced = agreement::assign(&paths, &trace::single_precision(&image)?)?;
    let rows = paths.into_iter().zip(traced).filter(|(path, _)| path.name == figures::LITERAL);
    Ok(rows
        .map(|(path, traced)| (figures::Path { name: figures::LITERAL_FOR_SPEED.to_owned(), ..path }, traced))
        .unzip())
}

/// The events of the whole device.
fn device_events(toolchain: Toolchain) -> Result<Counted, Box<dyn Error>> {
    let image = flash::build(toolchain, flash::DEVICE)?;
    let mut paths = run::paths(&image)?;
    paths.retain(|path| path.name.starts_with(flash::DEVICE));
    let traced = agreement::assign(&paths, &trace::everything(&image)?)?;
    Ok((paths, traced))
}

fn single_precision_paths(image: &Path) -> Result<Vec<figures::Path>, Box<dyn Error>> {
    let mut paths = run::paths(image)?;
    paths.retain(|path| path.precision == flash::SINGLE);
    Ok(paths)
}

/// Where the instructions of one path in single precision go, or of its dearest count. Builds that image alone.
fn profile_path(toolchain: Toolchain, name: &str, arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let is_event = name.starts_with(flash::DEVICE);
    let image = flash::build(toolchain, if is_event { flash::DEVICE } else { flash::SINGLE })?;
    let mut paths = single_precision_paths(&image)?;
    if is_event {
        paths.retain(|path| path.name.starts_with(flash::DEVICE));
    }
    let at = paths.iter().position(|path| path.name == name).ok_or_else(|| {
        let names: Vec<_> = paths.iter().map(|path| path.name.as_str()).collect();
        format!("there is no path \"{name}\"; there are:\n  {}", names.join("\n  "))
    })?;
    let trace = if is_event { trace::everything(&image)? } else { trace::single_precision(&image)? };
    let Some(traced) = agreement::assign(&paths, &trace)?.swap_remove(at) else { return Ok(()) };
    let worst = &traced.worst;
    println!("{name}: at most {} instructions, {} est. cycles", worst.instructions, worst.cycles());
    println!("{:>12}  memory that never waits", worst.core_cycles);
    for ((way, ..), cycles) in PLACEMENTS.iter().zip(worst.fetched) {
        println!("{cycles:>12}  {way}");
    }
    println!();
    let cycles_of = |count: &usize| trace.counts[*count].cycles();
    let chosen: Vec<usize> = match arguments.above {
        Some(limit) => traced.counts.iter().copied().filter(|count| cycles_of(count) > limit).collect(),
        None if arguments.worst => vec![traced.worst_at],
        None => traced.counts.clone(),
    };
    println!("{} of its {} counts:", chosen.len(), traced.counts.len());
    print_profile(&image, &trace, &chosen)
}

fn print_profile(image: &Path, trace: &Trace, counts: &[usize]) -> Result<(), Box<dyn Error>> {
    let instructions = trace.instructions(counts);
    let all: u64 = instructions.iter().map(|(_, times, _)| times).sum();
    for (title, place) in [("symbol", Place::Symbol), ("function", Place::Function), ("line", Place::Line)] {
        println!("{:>12} {:>7} {:>12} {:>12}  {title}", "instructions", "share", "est. cycles", "waits");
        for share in profile::by_place(image, &instructions, place)?.iter().take(PROFILE_LINES) {
            let percent = share.instructions as f64 / all.max(1) as f64 * 100.0;
            let profile::Share { place, instructions, cycles, waits } = share;
            println!("{instructions:>12} {percent:>5.1} % {cycles:>12} {waits:>12}  {place}");
        }
        println!();
    }
    Ok(())
}

fn print_and_save(record: &Record, toolchain: &str, modules: &[(String, u64)]) -> Result<(), Box<dyn Error>> {
    let table = table::markdown(record, toolchain);
    println!("{table}");
    println!("{:>8}  module of the whole image (inlined functions count where they ended up)", "flash, B");
    for (module, bytes) in modules.iter().take(MODULE_LINES) {
        println!("{bytes:>8}  {module}");
    }
    let folder = firmware::workspace().join("target").join("cycles");
    fs::create_dir_all(&folder)?;
    fs::write(folder.join("table.md"), table)?;
    fs::write(folder.join("cycles.csv"), record.to_csv())?;
    Ok(())
}

/// The comparison with what is kept, or the keeping. False when something has become worse.
fn keep_or_check(arguments: &Arguments, run: &Record) -> Result<bool, Box<dyn Error>> {
    if let Some(file) = &arguments.keep {
        let kept = if file.exists() { read(file)? } else { Record::default() }.updated(run);
        fs::write(file, kept.to_csv())?;
        if let Some(document) = &arguments.document {
            fs::write(document, expected_document(document, &kept)?)?;
        }
    }
    let Some(file) = &arguments.check else { return Ok(true) };
    let kept = read(file)?;
    let mut findings = kept.worsened(run);
    if let Some(document) = &arguments.document
        && fs::read_to_string(document)? != expected_document(document, &kept)?
    {
        findings.push(format!("the table in {} is not that of {}", document.display(), file.display()));
    }
    for finding in &findings {
        eprintln!("cargo cycles: {finding}");
    }
    Ok(findings.is_empty())
}

fn read(file: &Path) -> Result<Record, Box<dyn Error>> {
    let text = fs::read_to_string(file).map_err(|error| format!("{}: {error}", file.display()))?;
    Record::from_csv(&text).map_err(|error| format!("{}: {error}", file.display()).into())
}

/// The document with the table of the kept figures in it. It shows one toolchain, the first of the list.
fn expected_document(document: &Path, kept: &Record) -> Result<String, Box<dyn Error>> {
    let text = fs::read_to_string(document).map_err(|error| format!("{}: {error}", document.display()))?;
    let toolchain = kept.rows.first().map(|row| row.toolchain.clone()).unwrap_or_default();
    let table = table::markdown(kept, &toolchain);
    table::inserted(&text, &table).ok_or_else(|| format!("{}: no {}", document.display(), table::BEGIN).into())
}
