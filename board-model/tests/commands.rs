//! The programs' command lines: what they are called, and what is said of a wrong one. Nothing is built or run for that.

use std::process::Command;

/// Exit code, and what was written to stdout and stderr.
fn called(program: &str, arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = Command::new(program).args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

const RUN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/run");
const BOARD_MODEL: &str = env!("CARGO_BIN_EXE_board-model");
const POWER_CUT: &str = env!("CARGO_BIN_EXE_power-cut");

#[test]
fn help_has_the_name_by_which_the_program_is_called() {
    for (program, arguments, usage) in [
        (RUN, &["--help"][..], "board-model/run run -- [OPTIONS]"),
        (RUN, &["--", "--help"], "board-model/run run -- [OPTIONS]"),
        (BOARD_MODEL, &["--help"], "Usage: board-model/run run -- [OPTIONS]"),
        (POWER_CUT, &["--help"], "Usage: board-model/run run --release --bin power-cut -- [CUTS] [SEED]"),
    ] {
        let (code, out, err) = called(program, arguments);
        assert_eq!((code, err.as_str()), (Some(0), ""), "{program} {arguments:?}");
        assert!(out.contains(usage) && !out.contains("cargo rehearse"), "{program} {arguments:?}: {out}");
    }
}

#[test]
fn a_wrong_number_of_power_cuts_is_named() {
    for (arguments, wrong) in [
        (&["0"][..], "invalid value '0' for '[CUTS]': CUTS is how often the power is cut, 1 to 4294967295"),
        (&["abc"], "invalid value 'abc' for '[CUTS]': CUTS is how often the power is cut"),
        (&["-5"], "invalid value '-5' for '[CUTS]': CUTS is how often the power is cut"),
        (&["1e4"], "invalid value '1e4' for '[CUTS]': CUTS is how often the power is cut"),
        (&["5", "abc"], "invalid value 'abc' for '[SEED]': SEED is a number"),
        (&["5", "1", "1"], "unexpected argument '1'"),
    ] {
        let (code, out, err) = called(POWER_CUT, arguments);
        assert_eq!((code, out.as_str()), (Some(2), ""), "{arguments:?}");
        assert!(err.contains(wrong), "{arguments:?}: {err}");
    }
}

#[test]
fn an_option_that_would_do_nothing_is_refused() {
    for option in [&["--json"][..], &["--arm"], &["--shoulder", "3"], &["--rig", "RIG.toml"], &["--rig-error", "1"]] {
        let (code, _, err) = called(BOARD_MODEL, option);
        assert_eq!(code, Some(2), "{option:?}");
        assert!(err.contains(&format!("{} is not for the model of the chip", option[0])), "{option:?}: {err}");
    }
}

#[test]
fn without_a_word_the_words_are_named() {
    for arguments in [&[][..], &["--"]] {
        let (code, _, err) = called(RUN, arguments);
        assert_eq!(code, Some(2));
        assert!(err.contains("board-model/run test"), "{err}");
    }
}
