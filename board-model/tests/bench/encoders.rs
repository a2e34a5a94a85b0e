//! The encoders: filters, wraps, cut wires.

use crate::scene::{hear, is_fault, new_board};
use board_model::time::{PS_A_SECOND, PS_A_US};
use glenoid::can::Message;
use glenoid::procedure::Reason;
use host_tests::rehearse::Bench;

fn counts(board: &board_model::board::Board) -> [i32; 6] {
    let chip = board.machine.chip();
    std::array::from_fn(|cable| {
        let timer = &chip.timers[cable];
        let counter = timer.file.at(timer.file.offset("CNT"));
        if timer.is_wide() { counter as i32 } else { i32::from(counter as u16 as i16) }
    })
}

/// B10: pulses shorter than 1.5 us count nothing, longer ones count, and nothing is lost at 65 kHz.
#[test]
fn the_filters_are_right() {
    let mut board = new_board();
    for (level_ps, counted) in [(PS_A_US / 2, 0), (PS_A_US, 0), (2 * PS_A_US, 1), (5 * PS_A_US, 1)] {
        let before = counts(&board);
        board.machine.chip_mut().turn([1; 6], level_ps).unwrap();
        assert_eq!(counts(&board).map(i32::wrapping_abs), before.map(|count| count + counted), "{level_ps} ps");
        board.machine.chip_mut().turn([-1; 6], level_ps).unwrap();
    }
    // a level is half a period
    for _ in 0..1_000 {
        board.machine.chip_mut().turn([10; 6], PS_A_SECOND / 65_000 / 2).unwrap();
    }
    assert_eq!(counts(&board), [10_000; 6]);
}

/// B11: forty turns one way pass the wraps of the timers with 16 bits, and come back to 0.
#[test]
fn the_counts_pass_their_wraps() {
    let mut board = new_board();
    let mut said = Vec::new();
    for target in [163_840, 0, -163_840, 0] {
        board.set_counts(&[target; 6]).unwrap();
        said.extend(hear(&mut board, 6_000));
        assert!(board.holds_counts("sampling6LATEST", [target; 6]), "{target}");
    }
    assert!(!is_fault(&said, Reason::EncoderJumped), "{said:?}");
    assert_eq!(board.complaints(), [""; 0]);
}

/// B14: one channel after the other is cut while the arm moves: the encoder rests, and is named.
#[test]
fn a_cut_wire_is_named() {
    for cable in 0..6 {
        let mut board = new_board();
        let mut told = Vec::new();
        for step in 1..=20 {
            let mut target = [step * 400; 6];
            target[cable] = 0;
            board.set_counts(&target).unwrap();
            told.extend(hear(&mut board, 200));
        }
        let named = told.iter().any(|message| {
            matches!(message, Message::Fault(fault) if fault.code == Reason::EncoderFrozen
                && usize::from(fault.cable) == cable + 1)
        });
        assert!(named, "cable {}: {told:?}", cable + 1);
    }
}

/// An encoder at 1 MHz is faster than its filter: it reads as one that rests, and no pose is taken with it.
#[test]
fn an_encoder_at_a_megahertz_is_named() {
    let mut board = new_board();
    let mut told = Vec::new();
    for _ in 0..4_000 {
        // four counts a period
        board.machine.chip_mut().turn([2, 2, 2, 2, 2, 0], 20 * PS_A_US).unwrap();
        board.machine.chip_mut().turn([0, 0, 0, 0, 0, 4_000], PS_A_US / 2).unwrap();
        told.extend(hear(&mut board, 1));
    }
    assert!(is_fault(&told, Reason::EncoderFrozen), "{told:?}");
    assert_eq!(board.machine.resets, []);
}

/// A button that is stuck is a fault, and does nothing else.
#[test]
fn a_stuck_button_is_told() {
    let mut board = new_board();
    board.press(true);
    let told = hear(&mut board, 40_000);
    assert!(is_fault(&told, Reason::ButtonStuck), "{told:?}");
    assert_eq!(board.machine.resets, []);
}
