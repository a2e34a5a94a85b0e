//! The encoders: filters, wraps, wires that are cut or stuck.

use crate::scene::{answers, beats, collect, faults, hear, is_fault, new_board, send};
use board_model::board::Board;
use board_model::peripheral::gpio::Wire;
use board_model::time::{PS_A_SECOND, PS_A_US};
use glenoid::can::{Message, Opcode};
use glenoid::procedure::{Reason, StateName};
use host_tests::rehearse::Bench;

/// The pins of the encoders' channels A and B as docs/nucleo-g474re.md has them: port (0 is A) and number.
const PINS: [[(usize, u32); 2]; 6] =
    [[(2, 0), (2, 1)], [(0, 0), (0, 1)], [(0, 6), (0, 7)], [(1, 6), (1, 7)], [(1, 2), (2, 12)], [(2, 6), (2, 7)]];

fn counts(board: &Board) -> [i32; 6] {
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

/// What was told of encoders that rest: the cable, and whether it lasts.
fn frozen(said: &[Message]) -> Vec<(u8, bool)> {
    let of_encoders = faults(said).into_iter().filter(|fault| fault.0 == Reason::EncoderFrozen);
    let mut told: Vec<_> = of_encoders.map(|(_, cable, lasts)| (cable, lasts)).collect();
    told.dedup();
    told
}

/// What the board says while a pose is asked for, and refused because of this cable's encoder. None is captured, and the run goes on.
fn refuses_a_pose(board: &mut Board, cable: u8) {
    let nonce = send(board, Opcode::Capture, 0, 0);
    let said = hear(board, 120);
    let answered: Vec<_> = answers(&said).iter().map(|answer| (answer.nonce, answer.code, answer.detail)).collect();
    assert_eq!(answered, [(nonce, Reason::EncoderFrozen, u16::from(cable))]);
    let is_taken = |message: &Message| matches!(message, Message::Pose(pose) if pose.reason != Reason::EncoderFrozen);
    assert!(!said.iter().any(is_taken), "{said:?}");
    let now = *beats(&said).last().unwrap();
    assert_eq!((now.state, now.poses), (StateName::Collecting, 0));
}

/// B14: one wire after the other is cut, or stuck at a level, while the arm moves: its encoder rests, is named, and alone; no pose is
/// captured with it. The fault is over when the wire is mended.
#[test]
fn a_cut_or_stuck_wire_is_named() {
    let mut board = new_board();
    collect(&mut board);
    let mut at = 0;
    for cable in 1..=6 {
        for (channel, fault) in [(0, Wire::Open), (1, Wire::Open), (0, Wire::High), (1, Wire::Low), (0, Wire::Low)] {
            let pin = PINS[usize::from(cable) - 1][channel];
            board.spoil(pin, Some(fault));
            at = 2_000 - at;
            board.set_counts(&[at; 6]).unwrap();
            assert_eq!(frozen(&hear(&mut board, 250)), [(cable, true)], "{cable}: {pin:?} {fault:?}");
            refuses_a_pose(&mut board, cable);
            board.spoil(pin, None);
            at = 2_000 - at;
            board.set_counts(&[at; 6]).unwrap();
            let told = frozen(&hear(&mut board, 250));
            assert_eq!(told.last(), Some(&(cable, false)), "{cable}: {pin:?} {fault:?}");
        }
    }
    assert_eq!(board.machine.resets, []);
    assert_eq!(board.complaints(), [""; 0]);
}

/// An encoder at 1 MHz is faster than its filter: it reads as one that rests, is named, and alone; no pose is captured with it.
#[test]
fn an_encoder_at_a_megahertz_is_named() {
    let mut board = new_board();
    collect(&mut board);
    for cable in 1..=6 {
        let mut told = Vec::new();
        let fast = |index: usize| index + 1 == usize::from(cable);
        let before = counts(&board);
        for _ in 0..600 {
            let [slow, quick] = [false, true].map(|is_fast| std::array::from_fn(|index| fast(index) == is_fast));
            board.machine.chip_mut().turn(slow.map(|turns| if turns { 2 } else { 0 }), 20 * PS_A_US).unwrap();
            // four counts a period
            board.machine.chip_mut().turn(quick.map(|turns| if turns { 4_000 } else { 0 }), PS_A_US / 2).unwrap();
            told.extend(hear(&mut board, 1));
        }
        assert_eq!(frozen(&told), [(cable, true)]);
        let passed: [i32; 6] = std::array::from_fn(|index| counts(&board)[index] - before[index]);
        assert_eq!(passed, std::array::from_fn(|index| if fast(index) { 0 } else { 1_200 }));
        refuses_a_pose(&mut board, cable);
        // slow again, it counts, and the fault is over
        let mut told = Vec::new();
        for _ in 0..200 {
            board.machine.chip_mut().turn([-2; 6], 20 * PS_A_US).unwrap();
            told.extend(hear(&mut board, 1));
        }
        assert_eq!(frozen(&told).last(), Some(&(cable, false)), "{:?}", faults(&told));
    }
    assert_eq!(board.machine.resets, []);
}
