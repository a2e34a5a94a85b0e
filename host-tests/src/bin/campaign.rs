//! `cargo campaign`: long runs of chance against the device, and what came of them.

use clap::{Parser, Subcommand};
use host_tests::campaign::{accepts, telemetry};
use host_tests::command_line;
use std::process::ExitCode;
use std::time::Instant;

/// Long runs of chance against the device on the host; exits 0 when everything held.
#[derive(Parser)]
#[command(name = "cargo campaign", bin_name = "cargo campaign")]
struct Arguments {
    #[command(subcommand)]
    campaign: Campaign,
}

#[derive(Subcommand)]
enum Campaign {
    /// Two clients, a button, faults, restarts, a flash that refuses: is the centre in use always one that was chosen?
    Accepts {
        /// Random sequences of 40 steps
        #[arg(long, value_name = "N", default_value_t = 1_000_000)]
        sequences: u64,
        /// Number of the first one: others than last time, or one alone that has failed
        #[arg(long, value_name = "NUMBER", default_value_t = 0)]
        first: u64,
    },
    /// A consumer of telemetry beside 2 000 foreign frames a second: is every set that it takes whole and fresh?
    Telemetry {
        /// Sets that the device sends
        #[arg(long, value_name = "N", default_value_t = 1_000_000)]
        sets: u64,
        /// Seed of everything that is random
        #[arg(long, default_value_t = 1)]
        seed: u64,
    },
}

fn main() -> ExitCode {
    let began = Instant::now();
    let held = match command_line::parse::<Arguments>().campaign {
        Campaign::Accepts { sequences, first } => accepts::run(first..first.saturating_add(sequences)).map(|outcome| {
            println!("{outcome}");
            let unseen = outcome.unseen();
            if !unseen.is_empty() {
                println!("changes of state that no sequence has seen: {unseen:?}");
            }
            unseen.is_empty()
        }),
        Campaign::Telemetry { sets, seed } => telemetry::run(sets, seed).map(|outcome| {
            println!("{outcome}");
            outcome.holds()
        }),
    };
    println!("{:.1} s", began.elapsed().as_secs_f32());
    match held {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("cargo campaign: {error}");
            ExitCode::FAILURE
        }
    }
}
