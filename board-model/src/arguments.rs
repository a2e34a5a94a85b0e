//! The command lines of this package's programs, under the names by which they are called.

use clap::{CommandFactory, FromArgMatches, Parser};
use host_tests::rehearse::Options;
use std::ffi::OsString;

/// The options of `cargo rehearse` that make another board, machine or wearer, which the program does not have; and what is not asked
/// for here or can only stand beside them.
const REFUSED: [&str; 5] = ["arm", "rig", "rig_error", "pulley", "shoulder"];
const BESIDE: [&str; 7] =
    ["yes", "arm_fault", "machine_tolerance", "follow", "two_phase", "free_motion", "slow_slides"];

/// The options of a calibration on the model: those of `cargo rehearse`, as far as they mean something here.
///
/// # Errors
/// Something wrong with the line, or the help that was asked for.
pub fn rehearsal(line: impl Iterator<Item = OsString>) -> Result<Options, clap::Error> {
    let about =
        "The real image on the model of its chip: a calibration over CAN, one by the button, and a restart behind each";
    let name = "board-model/run run --";
    let mut command = Options::command().name(name).bin_name(name).about(about).long_about(about);
    for option in REFUSED.iter().chain(&BESIDE).chain(&["json"]) {
        command = command.mut_arg(option, |argument| argument.hide(true));
    }
    let matches = command.try_get_matches_from_mut(line)?;
    let options = Options::from_arg_matches(&matches)?;
    let given = |option: &&&str| matches.value_source(option) == Some(clap::parser::ValueSource::CommandLine);
    match REFUSED.iter().chain(&["json"]).find(given) {
        None => Ok(options),
        Some(option) => {
            let wrong = format!("--{} is not for the model of the chip", option.replace('_', "-"));
            Err(command.error(clap::error::ErrorKind::ArgumentConflict, wrong))
        }
    }
}

/// Cuts the power in the flash operations of the real image, on the model of its chip, on all processors of the host: in each
/// operation of a calibration's store and of a save of parameters, and again in the recovery.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Parser)]
#[command(name = "power-cut", bin_name = "board-model/run run --release --bin power-cut --")]
pub struct PowerCuts {
    /// Power cuts; each processor goes through whole rounds of the operations, so there may be a few more.
    #[arg(value_name = "CUTS", default_value_t = 1_000, allow_negative_numbers = true, value_parser = cuts)]
    pub cuts: u32,
    /// Seed of the chances.
    #[arg(value_name = "SEED", default_value_t = 1, allow_negative_numbers = true, value_parser = seed)]
    pub seed: u64,
}

fn cuts(text: &str) -> Result<u32, String> {
    let number = text.parse().ok().filter(|number| *number != 0);
    number.ok_or_else(|| format!("CUTS is how often the power is cut, 1 to {}", u32::MAX))
}

fn seed(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| format!("SEED is a number, 0 to {}", u64::MAX))
}

/// Takes what was read; what was wrong, or the help, ends the process.
pub fn or_exit<T>(read: Result<T, clap::Error>) -> T {
    read.unwrap_or_else(|error| error.exit())
}
