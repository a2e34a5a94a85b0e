//! Interrupts that nobody switched on, and all of them at once.

use crate::scene::{calibrated, cause, hear, kept_board, live, query};
use glenoid::restart::ResetCause;

/// Every line of the chip becomes pending at once: those that are on are served, and nothing else happens.
#[test]
fn all_interrupts_at_once_are_borne() {
    let mut board = kept_board();
    for _ in 0..100 {
        for line in 0..102 {
            board.machine.chip_mut().nvic.pend_line(line);
        }
        hear(&mut board, 1);
    }
    assert_eq!(board.machine.resets, [], "{:?}", board.last_words());
    assert_eq!(live(&query(&mut board)), Some(calibrated().1));
    assert_eq!(board.complaints(), [""; 0]);
}

/// One that is enabled and has no handler stops the firmware by name.
#[test]
fn an_unexpected_interrupt_restarts_the_board() {
    let mut board = kept_board();
    board.machine.chip_mut().write(0xE000_E100, 4, 1);
    board.machine.chip_mut().nvic.pend_line(0);
    hear(&mut board, 100);
    let said = query(&mut board);
    assert_eq!(cause(&said), Some(ResetCause::UnexpectedInterrupt));
    assert_eq!(live(&said), Some(calibrated().1));
}

/// The core's timer interrupts the CAN controller's handler, not the other way round.
#[test]
fn the_sampling_is_more_urgent_than_the_bus() {
    let board = kept_board();
    let nvic = &board.machine.chip().nvic;
    assert!(nvic.priority_of(15) < nvic.priority_of(16 + 21));
}
