//! Counting instructions: the image's ticks, read and turned.

use std::path::Path as FilePath;

use super::emulation::{self, RunError};
use super::figures::Path;

/// One instruction takes 2^6 = 64 ns of the emulator's virtual time.
const ICOUNT: [&str; 2] = ["-icount", "shift=6"];
const NS_PER_INSTRUCTION: u64 = 64;
/// The image's timer counts the core clock of 25 MHz.
const NS_PER_TICK: u64 = 40;

/// What the image counts to show that it counts right, and by how much a count may be off: the two readings of the
/// timer are rounded, and the call of the loop is counted too.
const LOOP_INSTRUCTIONS: u64 = 2_000_000;
const LOOP_SLACK: u64 = 16;

/// Runs the image and gives its paths in the order of its lines.
///
/// # Errors
/// [`RunError`].
pub fn paths(image: &FilePath) -> Result<Vec<Path>, RunError> {
    understand(&emulation::run(image, &ICOUNT, "all", |_| {})?)
}

/// Turns the image's lines into paths.
///
/// # Errors
/// [`RunError::Line`], [`RunError::Path`], [`RunError::Loop`].
pub fn understand(printed: &str) -> Result<Vec<Path>, RunError> {
    let mut empty_ticks = 0;
    let mut paths = Vec::new();
    let mut ended = false;
    for line in printed.lines() {
        let unknown = || RunError::Line(line.to_owned());
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        match words[..] {
            ["calibration", "empty", ticks] => empty_ticks = number("ticks", ticks).ok_or_else(unknown)?,
            ["calibration", "loop", ticks] => {
                let count = instructions(number("ticks", ticks).ok_or_else(unknown)?, empty_ticks);
                if count.abs_diff(LOOP_INSTRUCTIONS) > LOOP_SLACK {
                    return Err(RunError::Loop(count));
                }
            }
            ["path", name, precision, ref figures @ ..] => {
                paths.push(path(name, precision, figures, empty_ticks).ok_or_else(unknown)?);
            }
            ["failed", name, precision] => return Err(RunError::Path(format!("{name} {precision}"))),
            ["end"] => ended = true,
            _ => return Err(unknown()),
        }
    }
    if ended { Ok(paths) } else { Err(RunError::Line(printed.lines().last().unwrap_or_default().to_owned())) }
}

fn path(name: &str, precision: &str, figures: &[&str], empty_ticks: u64) -> Option<Path> {
    let [counts, ticks, worst, state, stack, steps, error] = figures else { return None };
    let counts = number("counts", counts)?;
    Some(Path {
        name: name.to_owned(),
        precision: precision.to_owned(),
        counts,
        instructions: instructions(number("ticks", ticks)?, empty_ticks * counts),
        worst: instructions(number("worst", worst)?, empty_ticks),
        state_bytes: number("state", state)?,
        stack_bytes: number("stack", stack)?,
        steps: number("steps", steps)?,
        error_nm: number("error", error)?,
    })
}

/// The value in `name=value`.
fn number(name: &str, word: &str) -> Option<u64> {
    word.strip_prefix(name)?.strip_prefix('=')?.parse().ok()
}

fn instructions(ticks: u64, empty_ticks: u64) -> u64 {
    (ticks.saturating_sub(empty_ticks) * NS_PER_TICK).div_ceil(NS_PER_INSTRUCTION)
}

#[cfg(test)]
mod tests {
    use super::*;

    const BEGIN: &str = "calibration empty ticks=16\ncalibration loop ticks=3200024\n";

    #[test]
    fn ticks_become_instructions_less_those_of_counting() {
        let line = "path tracking f32 counts=2 ticks=192 worst=112 state=8 stack=24 steps=0 error=7";
        let paths = understand(&format!("{BEGIN}{line}\nend\n")).unwrap();
        // 192 - 2·16 = 160 ticks of 40 ns are 100 instructions of 64 ns; 112 - 16 = 96 are 60
        assert_eq!(paths.len(), 1);
        assert_eq!((paths[0].instructions, paths[0].worst, paths[0].counts), (100, 60, 2));
        assert_eq!((paths[0].state_bytes, paths[0].stack_bytes, paths[0].error_nm), (8, 24, 7));
    }

    #[test]
    fn a_failed_path_a_wrong_loop_and_a_missing_end_are_errors() {
        let failed = understand(&format!("{BEGIN}failed tracking f32\nend\n"));
        assert!(matches!(failed, Err(RunError::Path(name)) if name == "tracking f32"));
        let wrong = understand("calibration empty ticks=16\ncalibration loop ticks=4000016\n");
        assert!(matches!(wrong, Err(RunError::Loop(2_500_000))));
        assert!(matches!(understand(BEGIN), Err(RunError::Line(_))));
        assert!(matches!(understand(&format!("{BEGIN}hello\nend\n")), Err(RunError::Line(line)) if line == "hello"));
    }
}
