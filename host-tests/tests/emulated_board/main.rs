//! The emulated drive board as its clients see it: bytes on two serial lines, and the log.
//!
//! Without the emulator, or without a toolchain for the board, each test is reported as ignored by its name. With
//! `GLENOID_REQUIRE_EMULATOR=1` that is an error instead.

mod arm;
mod calibration;
mod can_line;
mod elbow;
mod faults;
mod load;
mod placement;
mod restarts;
mod runs;
mod scene;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use host_tests::emulator::{self, Emulator, EmulatorError, Options};
use host_tests::firmware::{self, FirmwareError, Image};
use host_tests::packages::Consent;
use libtest_mimic::{Arguments, Failed, Trial};

/// Far longer than anything here takes, the eight seconds of the watchdog included; a loaded machine gets the time that it
/// needs.
const PATIENCE: Duration = Duration::from_secs(60);

/// Makes the absence of the emulator an error.
const REQUIRED_VARIABLE: &str = "GLENOID_REQUIRE_EMULATOR";

type Test = fn(&Path) -> Result<(), Failed>;

const TESTS: [(&str, Test); 29] = [
    ("python_can_opens_the_channel", can_line::python_can_opens_the_channel),
    ("a_closed_channel_is_silent", can_line::a_closed_channel_is_silent),
    ("frames_go_both_ways", can_line::frames_go_both_ways),
    ("a_flood_is_served_to_its_last_frame", load::a_flood_is_served_to_its_last_frame),
    ("the_clock_keeps_time_under_load", load::the_clock_keeps_time_under_load),
    ("garbage_is_survived_and_counted", can_line::garbage_is_survived_and_counted),
    ("a_client_may_vanish_and_return", can_line::a_client_may_vanish_and_return),
    ("an_emulator_that_ends_is_told", faults::an_emulator_that_ends_is_told),
    ("an_emulator_whose_owner_is_killed_ends", faults::an_emulator_whose_owner_is_killed_ends),
    ("a_stack_overflow_restarts_the_board", faults::a_stack_overflow_restarts_the_board),
    ("the_ccm_code_is_copied_and_called", placement::the_ccm_code_is_copied_and_called),
    ("a_calibration_finds_the_centre", calibration::a_calibration_finds_the_centre),
    ("zeros_are_found_and_a_slip_is_named", calibration::zeros_are_found_and_a_slip_is_named),
    ("a_machine_that_is_not_as_drawn_is_calibrated", calibration::a_machine_that_is_not_as_drawn_is_calibrated),
    ("an_arm_is_calibrated_on_three_boards", arm::an_arm_is_calibrated_on_three_boards),
    ("two_boards_at_one_place_are_named_on_the_bus", arm::two_boards_at_one_place_are_named_on_the_bus),
    ("an_elbow_is_calibrated_and_kept", elbow::an_elbow_is_calibrated_and_kept),
    ("calibrations_in_a_row", runs::calibrations_in_a_row),
    ("a_client_that_returns_is_told", runs::a_client_that_returns_is_told),
    ("a_crowded_bus_changes_nothing_but_a_counter", runs::a_crowded_bus_changes_nothing_but_a_counter),
    ("a_wild_jump_restarts_the_board", faults::a_wild_jump_restarts_the_board),
    ("a_standstill_is_ended_by_the_watchdog", faults::a_standstill_is_ended_by_the_watchdog),
    ("a_rotten_instruction_restarts_the_board", faults::a_rotten_instruction_restarts_the_board),
    ("code_that_changes_in_memory_restarts_the_board", faults::code_that_changes_in_memory_restarts_the_board),
    ("a_centre_that_changes_in_memory_restarts_the_board", faults::a_centre_that_changes_in_memory_restarts_the_board),
    ("a_restart_is_told_on_the_bus", faults::a_restart_is_told_on_the_bus),
    ("a_restart_finds_the_record", restarts::a_restart_finds_the_record),
    ("a_bad_record_is_refused_by_name", restarts::a_bad_record_is_refused_by_name),
    ("a_reset_in_any_state_keeps_the_old_centre", restarts::a_reset_in_any_state_keeps_the_old_centre),
];

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let wanted = |name: &str| arguments.filter.as_ref().is_none_or(|filter| name.contains(filter.as_str()));
    // listing, or running the tests of another file by their names, must not build anything
    let image = match !arguments.list && TESTS.iter().any(|(name, _)| wanted(name)) {
        true => image(),
        false => Err(Missing::NotWanted),
    };
    let required = std::env::var_os(REQUIRED_VARIABLE).is_some_and(|value| value == "1");
    match &image {
        Ok(_) | Err(Missing::NotWanted) => {}
        Err(Missing::Prerequisite(reason)) if !required => {
            eprintln!("the emulated board cannot run, its tests are ignored: {reason}");
        }
        Err(Missing::Prerequisite(reason)) => {
            eprintln!("error: {REQUIRED_VARIABLE} is set, and the emulated board cannot run: {reason}");
            return ExitCode::FAILURE;
        }
        Err(Missing::Broken(reason)) => {
            eprintln!("error: {reason}");
            return ExitCode::FAILURE;
        }
    }
    let image = image.ok();
    let trials = TESTS.map(|(name, test)| {
        let image = image.clone();
        let ignored = image.is_none();
        Trial::test(name, move || test(&image.ok_or("there is no image")?)).with_ignored_flag(ignored)
    });
    libtest_mimic::run(&arguments, trials.into()).exit_code()
}

/// Why there is no image to test.
enum Missing {
    /// No test was asked for.
    NotWanted,
    /// The emulator or the toolchain is not there.
    Prerequisite(String),
    /// They are there, and the firmware does not build.
    Broken(String),
}

fn image() -> Result<PathBuf, Missing> {
    emulator::ensure_installed(Consent::Refused).map_err(|error| Missing::Prerequisite(error.to_string()))?;
    firmware::build(Image::EMULATED, Consent::Refused).map_err(|error| match error {
        FirmwareError::BuildFailed(_) => Missing::Broken(error.to_string()),
        _ => Missing::Prerequisite(error.to_string()),
    })
}

fn boot(image: &Path) -> Result<Emulator, EmulatorError> {
    Emulator::start(image, &Options::default())
}
