//! `cargo rehearse`: see [`host_tests::rehearse`].

use host_tests::command_line;
use host_tests::firmware::workspace;
use host_tests::rehearse::{self, Options, Status, run, run_arm};
use serde::Serialize;
use std::fmt::Display;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

/// Set by Ctrl-C and by a request to terminate: the emulator must not outlive this program.
static STOP: AtomicBool = AtomicBool::new(false);

fn main() -> ExitCode {
    let options = command_line::parse::<Options>();
    let display = rehearse::Display::choose(options.json);
    if let Err(error) = ctrlc::set_handler(|| STOP.store(true, Ordering::Relaxed)) {
        eprintln!("cargo rehearse: cannot listen for Ctrl-C: {error}");
    }
    if options.arm {
        let report = run_arm(&options, &display, &STOP);
        return show(&report, report.status, options.json);
    }
    let report = run(&options, &display, &workspace().join("target/rehearse"), &STOP);
    show(&report, report.status, options.json)
}

/// Prints a report; success only when it is right.
fn show(report: &(impl Serialize + Display), status: Status, json: bool) -> ExitCode {
    if json {
        match serde_json::to_string_pretty(report) {
            Ok(json) => println!("{json}"),
            Err(error) => {
                eprintln!("cargo rehearse: the report is no JSON: {error}");
                return ExitCode::FAILURE;
            }
        }
    } else {
        print!("{report}");
    }
    if status == Status::Right { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
