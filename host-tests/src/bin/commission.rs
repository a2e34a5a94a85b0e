//! `cargo commission`: the machine as it is built, from logs of it.

use std::error::Error;
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use host_tests::command_line;
use host_tests::commission::{self, Request};

/// The exit code of a refusal. Unreadable input and a wrong command line are 1.
const REFUSED: u8 = 2;

/// Find the geometry, encoder offsets and drum scales of a machine from recorded logs of it.
///
/// Exit status: 0 commissioned, 2 refused, 1 unreadable input.
#[derive(Parser)]
#[command(name = "cargo commission", bin_name = "cargo commission --")]
struct Arguments {
    /// What is to be commissioned: rig = "rig.toml", and `[[log]]` tables with file = "a.csv" and, of a ball at a known
    /// place, centre = [x, y, z] and centre_sigma = 0.1, mm
    #[arg(value_name = "COMMISSION.toml")]
    request: PathBuf,
    /// Where the rig as found is written; without it, it is printed
    #[arg(long, value_name = "RIG.toml")]
    output: Option<PathBuf>,
    /// Print one JSON object about what was found
    #[arg(long)]
    json: bool,
}

fn main() -> ExitCode {
    let arguments = command_line::parse::<Arguments>();
    match run(&arguments) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("cargo commission: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<ExitCode, Box<dyn Error>> {
    let request = Request::read(&arguments.request)?;
    let found = commission::run(&request)?;
    for note in &found.notes {
        eprintln!("cargo commission: {note}");
    }
    if let (Some(path), Some(text)) = (&arguments.output, &found.rig_text) {
        commission::write(&request, path, text)?;
        eprintln!("cargo commission: written to {}", path.display());
    }
    let summary = found.report.summary();
    let out = if arguments.json {
        serde_json::to_string(&found.report)? + "\n"
    } else if let (None, Some(text)) = (&arguments.output, &found.rig_text) {
        // The rig alone on the standard output: it can be redirected into a file.
        eprint!("{summary}");
        text.clone()
    } else {
        summary
    };
    // The reader of a pipe may have gone; the exit status still tells the outcome.
    let _ = std::io::stdout().lock().write_all(out.as_bytes());
    Ok(if found.rig_text.is_some() { ExitCode::SUCCESS } else { ExitCode::from(REFUSED) })
}
