//! Interrupts that nobody switched on, and all of them at once.

use crate::scene::{answers, beats, calibrated, cause, counters, faults, health, hear, kept_board, live, query, send};
use crate::scene::{state, wearer};
use board_model::board::Board;
use board_model::time::PS_A_US;
use glenoid::can::{Message, Opcode};
use glenoid::procedure::{Reason, StateName};
use glenoid::restart::ResetCause;
use host_tests::rehearse::Bench;

/// Interrupts of the chip (RM0440, "Interrupt and exception vectors").
const LINES: usize = 102;
/// When a run begins, the arm moves, the run ends, and that has been told, ms.
const BEGINS: usize = 650;
const MOVES: usize = 900;
const ENDS: usize = 1_950;
const LAST: usize = 2_200;

/// A millisecond in which every line of the chip becomes pending at once, at another moment each time.
fn stormy_ms(board: &mut Board, moment: u64) -> Vec<Message> {
    let now_ps = board.machine.chip().time.now_ps();
    board.machine.run_until(now_ps + moment * 37 % 1_000 * PS_A_US);
    for line in 0..LINES {
        board.machine.chip_mut().nvic.pend_line(line);
    }
    hear(board, 1)
}

/// Every line of the chip becomes pending at once, again and again while a run is begun, the arm moves, commands come and are
/// answered, and the run is ended: those that are on are served, and nothing is lost.
#[test]
fn all_interrupts_at_once_are_borne() {
    let mut board = kept_board();
    let mut wearer = wearer(3);
    let (home, pose) = (wearer.home(), wearer.next_pose());
    let (mut said, mut nonces) = (hear(&mut board, 200), Vec::new());
    let rest = vec![home.counts; MOVES];
    for (moment, counts) in rest.iter().chain(&wearer.motion(&home, &pose, 1_500, 1)).enumerate() {
        board.set_counts(counts).unwrap();
        match moment {
            BEGINS => nonces.push(send(&mut board, Opcode::Start, 0, 1)),
            ENDS => nonces.push(send(&mut board, Opcode::Abort, 0, 0)),
            // refused each time: no run has this number; fewer in a second than the device remembers
            _ if moment % 100 == 0 => nonces.push(send(&mut board, Opcode::Reject, 999, 0)),
            _ => {}
        }
        said.extend(stormy_ms(&mut board, moment as u64));
        // a command that begins or ends a run has been heard of in a heartbeat
        let expected = match moment {
            0..BEGINS => StateName::Idle,
            MOVES..ENDS => StateName::Collecting,
            LAST.. => StateName::Idle,
            _ => continue,
        };
        assert_eq!(state(&said), Some(expected), "{moment}");
    }
    said.extend(hear(&mut board, 200));
    // what was sent has arrived, and was answered once and in order
    let answered = answers(&said);
    assert_eq!(answered.iter().map(|answer| answer.nonce).collect::<Vec<_>>(), nonces);
    let obeyed = answered.iter().filter(|answer| answer.code == Reason::Fine).map(|answer| answer.opcode);
    assert_eq!(obeyed.collect::<Vec<_>>(), [Opcode::Start as u8, Opcode::Abort as u8]);
    // no frame of the board's is missing
    let sequence: Vec<u8> = beats(&said).iter().map(|heartbeat| heartbeat.sequence).collect();
    assert!(sequence.windows(2).all(|two| two[1] == two[0].wrapping_add(1)), "{sequence:?}");
    assert!(sequence.len() >= 25, "{sequence:?}");
    // no count is
    assert!(board.holds_counts("sampling6LATEST", pose.counts));
    let known = query(&mut board);
    let counters = counters(&known).unwrap();
    assert_eq!((counters.foreign, counters.malformed, counters.overruns), (0, 0, 0));
    assert_eq!(health(&known).unwrap().dropped, 0);
    assert_eq!(live(&known), Some(calibrated().1));
    assert_eq!(faults(&said), []);
    assert_eq!(board.machine.resets, [], "{:?}", board.last_words());
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
