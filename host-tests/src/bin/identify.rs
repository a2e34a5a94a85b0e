//! `cargo identify`: the joint centre from a recorded log of cable lengths.

use std::error::Error;
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, ValueEnum};
use glenoid::identification::JointChoice;
use host_tests::command_line;
use host_tests::identify::report::{Method, Precision, Status};
use host_tests::identify::{self, Request};
use serde::Serialize;

/// The exit code of a refusal. Unreadable input and a wrong command line are 1.
const REFUSED: u8 = 2;

/// Identify the joint centre from a recorded log of cable lengths, as the drive board does.
///
/// Exit status: 0 accepted, 2 refused, 1 unreadable input.
#[derive(Parser)]
#[command(name = "cargo identify", bin_name = "cargo identify --")]
struct Arguments {
    /// The log: CSV with the columns l1 to l6, one pose a line, mm; or what candump recorded of a run
    #[arg(value_name = "LOG")]
    lengths: PathBuf,
    /// The rig: base = [[x, y, z], ..] and edges = [p12, p23, p31], mm; without it, the shoulder over a 150 mm base
    #[arg(long, value_name = "RIG.toml")]
    rig: Option<PathBuf>,
    /// Where --method paper begins, mm; without it, [start] of the rig file, else the shoulder's nominal centre
    #[arg(long, value_name = "x,y,z,p1,p2,p3", allow_hyphen_values = true, value_parser = start)]
    start: Option<Start>,
    /// The paper's iteration from a start, or the full identification of the drive board, which needs none
    #[arg(long, value_enum, default_value_t = MethodName::Full)]
    method: MethodName,
    /// The machine was not homed: identify the zeros of the six encoders as well, known to so many mm (1 sigma)
    #[arg(long, value_name = "MM", num_args = 0..=1, default_missing_value = "10", value_parser = zeros)]
    zeros: Option<f64>,
    /// The model of the joint: a ball, a centre that moves with the arm, or the ball while it explains the poses
    #[arg(long, value_enum, default_value_t = JointName::Auto)]
    joint: JointName,
    /// A first log of the same wearing in which the shoulder blade was held
    #[arg(long, value_name = "STILL.csv")]
    still: Option<PathBuf>,
    /// Use every row of the log, not only as many as the drive board has room for
    #[arg(long)]
    all_poses: bool,
    /// Known standard deviation of a cable length; without it, it is estimated from the residuals
    #[arg(long, value_name = "MM", allow_hyphen_values = true, value_parser = noise)]
    noise: Option<f64>,
    /// Precision of the arithmetic: the drive board's, or double
    #[arg(long, value_enum, default_value_t = PrecisionName::F64)]
    precision: PrecisionName,
    /// A second log that the result is verified on
    #[arg(long, value_name = "SECOND.csv")]
    verify: Option<PathBuf>,
    /// Print one JSON object instead of a table
    #[arg(long)]
    json: bool,
}

/// A type of its own: clap takes an array for a list of options.
#[derive(Clone, Copy)]
struct Start([f64; 6]);

#[derive(Clone, Copy, ValueEnum)]
enum JointName {
    Auto,
    Ball,
    Moving,
}

#[derive(Clone, Copy, ValueEnum)]
enum MethodName {
    Paper,
    Full,
}

#[derive(Clone, Copy, ValueEnum)]
enum PrecisionName {
    F32,
    F64,
}

fn main() -> ExitCode {
    let arguments = command_line::parse::<Arguments>();
    match run(arguments) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("cargo identify: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: Arguments) -> Result<ExitCode, Box<dyn Error>> {
    let request = Request {
        lengths: arguments.lengths,
        rig: arguments.rig,
        start_mm: arguments.start.map(|start| start.0),
        method: match arguments.method {
            MethodName::Paper => Method::Paper,
            MethodName::Full => Method::Full,
        },
        zero_prior_mm: arguments.zeros,
        joint: match arguments.joint {
            JointName::Auto => JointChoice::Auto,
            JointName::Ball => JointChoice::Ball,
            JointName::Moving => JointChoice::Moving,
        },
        still: arguments.still,
        all_poses: arguments.all_poses,
        noise_mm: arguments.noise,
        precision: match arguments.precision {
            PrecisionName::F32 => Precision::F32,
            PrecisionName::F64 => Precision::F64,
        },
        verify: arguments.verify,
    };
    let json = arguments.json;
    if let Some(found) = identify::hinge::run(&request)? {
        return print(&found.report, found.report.status, found.summary, json, &found.notes, &found.warnings);
    }
    let found = identify::run(&request)?;
    print(&found.report, found.report.status, found.summary, json, &found.notes, &found.warnings)
}

fn print(
    report: &impl Serialize,
    status: Status,
    summary: String,
    json: bool,
    notes: &[String],
    warnings: &[String],
) -> Result<ExitCode, Box<dyn Error>> {
    for note in notes {
        eprintln!("cargo identify: {note}");
    }
    for warning in warnings {
        eprintln!("cargo identify: warning: {warning}");
    }
    let text = if json { serde_json::to_string(report)? + "\n" } else { summary };
    // The reader of a pipe may have gone; the exit status still tells the outcome.
    let _ = std::io::stdout().lock().write_all(text.as_bytes());
    Ok(match status {
        Status::Accepted => ExitCode::SUCCESS,
        Status::Refused => ExitCode::from(REFUSED),
    })
}

fn start(text: &str) -> Result<Start, String> {
    let numbers: Vec<f64> = text
        .split(',')
        .map(|number| number.trim().parse().map_err(|_| format!("{:?} is not a number", number.trim())))
        .collect::<Result<_, String>>()?;
    let start: [f64; 6] = numbers
        .try_into()
        .map_err(|numbers: Vec<f64>| format!("six numbers x,y,z,p1,p2,p3 are wanted, there are {}", numbers.len()))?;
    match identify::start_complaint(&start) {
        Some(complaint) => Err(complaint),
        None => Ok(Start(start)),
    }
}

fn zeros(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(prior) if (1e-4..=100.0).contains(&prior) => Ok(prior),
        Ok(_) => Err("a standard deviation of 0.0001 to 100 mm is wanted".to_owned()),
        Err(_) => Err(format!("{text:?} is not a number")),
    }
}

fn noise(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(noise) if (1e-4..=10.0).contains(&noise) => Ok(noise),
        Ok(_) => Err("a standard deviation of 0.0001 to 10 mm is wanted".to_owned()),
        Err(_) => Err(format!("{text:?} is not a number")),
    }
}
