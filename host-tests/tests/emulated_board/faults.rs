//! The end of a board: told when it comes by itself, and brought about by the debugger.

use std::path::Path;

use host_tests::debugger::{Debugger, Register};
use host_tests::elf::Elf;
use host_tests::emulator::{Emulator, EmulatorError, Options};
use libtest_mimic::Failed;

use crate::PATIENCE;

pub fn an_emulator_that_ends_is_told(_: &Path) -> Result<(), Failed> {
    let missing = Path::new("no such image");
    match Emulator::start(missing, &Options::default()) {
        Err(EmulatorError::Ended { complaint, .. }) if complaint.contains("no such image") => Ok(()),
        other => Err(format!("{other:?}").into()),
    }
}

/// The board with registers changed while it ran; gives its last words once it has ended with a failure.
fn last_words(image: &Path, changes: &[(Register, u32)]) -> Result<String, Failed> {
    let mut board = Emulator::start(image, &Options { debugger: true, ..Options::default() })?;
    let address = board.debugger_address().ok_or("the board serves no debugger")?;
    let mut debugger = Debugger::halt(address)?;
    for &(register, value) in changes {
        debugger.set(register, value)?;
    }
    debugger.resume()?;
    let status = board.wait_for_end(PATIENCE)?;
    assert_eq!(status.code(), Some(1), "{:?}", board.log());
    Ok(board.log().pop().unwrap_or_default())
}

/// The guard is the first whole 4 KiB above the static variables. With the stack pointer at its upper end, the next
/// function that is called, be it `main` once more, has no room to put anything down.
pub fn a_stack_overflow_ends_the_board(image: &Path) -> Result<(), Failed> {
    let elf = Elf::read(image)?;
    let guard_end = u32::try_from(elf.symbol("_stack_end")?)?.next_multiple_of(4096) + 4096;
    // the lowest bit of a function's address says Thumb and is no part of the program counter
    let main = u32::try_from(elf.symbol("main")?)? & !1;
    let changes = [(Register::StackPointer, guard_end), (Register::ProgramCounter, main)];
    let words = last_words(image, &changes)?;
    assert!(words.starts_with("fault: stack overflow"), "{words}");
    Ok(())
}

pub fn a_wild_jump_ends_the_board(image: &Path) -> Result<(), Failed> {
    // the system region may never be executed (ARMv7-M ARM, B3.1)
    let words = last_words(image, &[(Register::ProgramCounter, 0xE000_0000)])?;
    assert!(words.starts_with("fault: CFSR 0x1,"), "{words}");
    Ok(())
}
