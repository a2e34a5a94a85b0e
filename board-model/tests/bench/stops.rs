//! The firmware can no longer be trusted: it restarts, and says why.

use crate::scene::{calibrated, cause, hear, image, kept_board, last_stop, live, query};
use board_model::board::Board;
use board_model::peripheral::rcc::Cause;
use board_model::time::PS_A_US;
use glenoid::restart::ResetCause;
use unicorn_engine::RegisterARM;

/// Unused core-coupled memory, near its end.
const UNUSED_CCM: u32 = 0x1000_7FF0;
/// `b .`
const BRANCH_TO_ITSELF: u32 = 0xE7FE_E7FE;

/// Whatever happens ends within `ms` in a restart with the old centre in use.
fn restarts(mut board: Board, ms: u32, by: Cause) -> (Option<ResetCause>, Option<u32>) {
    let before = board.now_ms();
    while board.machine.resets.is_empty() && board.now_ms() < before + u64::from(ms) {
        hear(&mut board, 1);
    }
    assert_eq!(board.machine.resets, [by]);
    hear(&mut board, 50);
    let said = query(&mut board);
    assert_eq!(live(&said), Some(calibrated().1));
    assert_eq!(board.complaints(), [""; 0]);
    (cause(&said), last_stop(&said).map(|stop| stop.address))
}

/// B7: the sampling dies; the watchdog bites within 0.7 s.
#[test]
fn the_watchdog_bites_when_the_sampling_dies() {
    let mut board = kept_board();
    board.machine.chip_mut().write(0xE000_E010, 4, 0);
    let (cause, _) = restarts(board, 700, Cause::Watchdog);
    assert_eq!(cause, Some(ResetCause::Watchdog));
}

/// B8: a main loop that stands still is named with its address, after 0.3 s.
#[test]
fn a_standing_loop_is_named() {
    let mut board = kept_board();
    board.machine.set_word(UNUSED_CCM, BRANCH_TO_ITSELF);
    board.machine.jump(UNUSED_CCM);
    let told = restarts(board, 310, Cause::Software);
    assert_eq!(told, (Some(ResetCause::Watchdog), Some(UNUSED_CCM)));
}

/// B9: the guard catches a full stack.
#[test]
fn the_guard_catches_a_full_stack() {
    let mut board = kept_board();
    let static_end = board.image.symbol("_stack_end").unwrap();
    board.machine.set(RegisterARM::SP, static_end + 4096);
    let (cause, _) = restarts(board, 10, Cause::Software);
    assert_eq!(cause, Some(ResetCause::StackOverflow));
}

/// B17: a word of the code in the core-coupled memory changes.
#[test]
fn changed_code_is_noticed() {
    let mut board = kept_board();
    board.machine.set_word(0x1000_0400, 0);
    let told = restarts(board, 1_000, Cause::Software);
    assert_eq!(told, (Some(ResetCause::MemoryError), Some(0x1000_0400)));
}

/// A jump to where no code is.
#[test]
fn a_wild_jump_is_a_fault() {
    let mut board = kept_board();
    board.machine.jump(0x3000_0000);
    let (cause, _) = restarts(board, 10, Cause::Software);
    assert_eq!(cause, Some(ResetCause::Fault));
}

/// A word of the program that cannot be corrected any more: the NMI says so, and the chip starts anew.
#[test]
fn a_bad_word_of_the_program_is_a_memory_error() {
    let mut board = kept_board();
    board.machine.chip_mut().spoil_program_word(0x0800_1000);
    let (cause, _) = restarts(board, 10, Cause::Software);
    assert_eq!(cause, Some(ResetCause::MemoryError));
}

/// The same while the board starts: the code for the core-coupled memory is read from the flash then, and the reset that follows is
/// not taken for the power-up before it.
#[test]
fn a_bad_word_met_while_starting_is_a_memory_error() {
    for us in [200, 500, 1_000, 2_000] {
        let mut board = Board::power_on(image(), calibrated().0, 3);
        board.machine.run_until(us * PS_A_US);
        board.machine.chip_mut().spoil_program_word(0x0800_2000);
        let (cause, _) = restarts(board, 50, Cause::Software);
        assert_eq!(cause, Some(ResetCause::MemoryError), "at {us} us");
    }
}
