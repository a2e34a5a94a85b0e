//! The CAN controller's pins, stuck at a level.

use crate::scene::{
    beats, calibrated, collect, health, hear, heartbeats, is_fault, kept_board, live, query, send, state,
};
use board_model::board::Board;
use board_model::peripheral::gpio::Wire;
use glenoid::can::Opcode;
use glenoid::can::health::BusHealth;
use glenoid::procedure::{Reason, StateName};

/// PA11 and PA12.
const RECEIVE: (usize, u32) = (0, 11);
const TRANSMIT: (usize, u32) = (0, 12);

/// A board in a run, with this pin stuck for five seconds, in which nothing is heard of it and a command does not reach it.
fn stuck(pin: (usize, u32), level: Wire) -> Board {
    let mut board = kept_board();
    collect(&mut board);
    board.spoil(pin, Some(level));
    assert_eq!(hear(&mut board, 4_000), []);
    send(&mut board, Opcode::Abort, 0, 0);
    assert_eq!(hear(&mut board, 1_000), []);
    board
}

/// Mended, the board speaks at once, is still in its run, and obeys; what it says of its bus. Nothing is lost but what was to be said
/// meanwhile.
fn mended(board: &mut Board, pin: (usize, u32)) -> (bool, BusHealth) {
    board.spoil(pin, None);
    let said = hear(board, 500);
    // first what was left waiting, as many frames as there is room for; then a heartbeat every 100 ms
    assert!(said.len() > 67 && heartbeats(&said) >= 4, "{said:?}");
    assert!(beats(&said).iter().all(|now| now.state == StateName::Collecting), "{said:?}");
    let known = query(board);
    assert_eq!((live(&known), state(&known)), (Some(calibrated().1), Some(StateName::Collecting)));
    send(board, Opcode::Abort, 0, 0);
    assert_eq!(state(&hear(board, 300)), Some(StateName::Idle));
    assert_eq!(board.machine.resets, []);
    assert_eq!(board.complaints(), [""; 0]);
    (is_fault(&said, Reason::BusOff), health(&known).unwrap())
}

/// The controller does not see what it sends: bus-off after bus-off, since a recessive line ends each of them.
#[test]
fn a_receive_line_stuck_recessive_is_a_bus_off() {
    let mut board = stuck(RECEIVE, Wire::High);
    let (is_told, health) = mended(&mut board, RECEIVE);
    // each takes 32 frames of a quarter of a millisecond, and 3 ms
    assert!(is_told && health.bus_off > 300 && health.dropped > 0, "{health:?}");
}

/// A dominant line is never free: the controller waits, and counts receive errors, which lead to no bus-off (ISO 11898-1). It is
/// the same when the transmit line holds the bus.
#[test]
fn a_line_stuck_dominant_is_waited_out() {
    for pin in [RECEIVE, TRANSMIT] {
        let mut board = stuck(pin, Wire::Low);
        let file = &board.machine.chip().can.file;
        let get = |register, field| file.get(register, field);
        assert_eq!((get("PSR", "BO"), get("PSR", "EP"), get("ECR", "RP"), get("ECR", "REC")), (0, 1, 1, 127));
        if pin == TRANSMIT {
            // nobody could send, so the command still waits
            board.machine.chip_mut().can.bus.waiting.clear();
        }
        let (is_told, health) = mended(&mut board, pin);
        assert!(!is_told && health.bus_off == 0 && health.dropped > 0, "{health:?}");
        // a frame was heard: the counter is back below 128
        assert!(!health.error_passive && health.receive_errors <= 127, "{health:?}");
    }
}

/// Without its transmit line the board hears, and obeys, but cannot say so.
#[test]
fn without_its_transmit_line_the_board_still_hears() {
    let mut board = kept_board();
    collect(&mut board);
    board.spoil(TRANSMIT, Some(Wire::High));
    // between two bus-offs it is on the bus for a while
    for _ in 0..20 {
        send(&mut board, Opcode::Abort, 0, 0);
        assert_eq!(hear(&mut board, 13), []);
    }
    board.spoil(TRANSMIT, None);
    hear(&mut board, 500);
    assert_eq!(state(&hear(&mut board, 200)), Some(StateName::Idle));
    assert_eq!(board.machine.resets, []);
}

/// Stuck from power-up on, and mended.
#[test]
fn a_board_that_starts_with_a_stuck_pin_of_the_bus_keeps_its_centre() {
    for level in [Wire::High, Wire::Low] {
        let mut board = kept_board();
        board.spoil(RECEIVE, Some(level));
        board.power_cycle();
        assert_eq!(hear(&mut board, 1_000), []);
        board.spoil(RECEIVE, None);
        assert!(heartbeats(&hear(&mut board, 500)) >= 5);
        assert_eq!(live(&query(&mut board)), Some(calibrated().1));
        assert_eq!(board.machine.resets, []);
        assert_eq!(board.complaints(), [""; 0]);
    }
}
