//! `cargo arm`: where the hand is, from one log of each module and the lengths of one posture.

use clap::Parser;
use host_tests::{arm, command_line};
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Identify shoulder, elbow and wrist, and carry the hand through all three.
///
/// Exit status: 0 accepted, 2 refused, 1 unreadable input.
#[derive(Parser)]
#[command(name = "cargo arm", bin_name = "cargo arm --")]
struct Arguments {
    /// The arm: the tables `shoulder`, `elbow` and `wrist` with log, rig and posture; `upper_arm`, `forearm`; `hand`
    #[arg(value_name = "ARM.toml")]
    arm: PathBuf,
    /// Print one JSON object instead of a table
    #[arg(long)]
    json: bool,
}

fn main() -> ExitCode {
    let arguments = command_line::parse::<Arguments>();
    let report = match arm::run(&arguments.arm) {
        Ok(report) => report,
        Err(error) => {
            eprintln!("cargo arm: {error}");
            return ExitCode::FAILURE;
        }
    };
    let text = if arguments.json {
        serde_json::to_string(&report).map_or_else(|error| error.to_string(), |json| json + "\n")
    } else {
        report.text()
    };
    // The reader of a pipe may have gone; the exit status still tells the outcome.
    let _ = std::io::stdout().lock().write_all(text.as_bytes());
    if arm::is_accepted(&report) { ExitCode::SUCCESS } else { ExitCode::from(2) }
}
