//! The CAN bus: bit, filter, bus-off, loneliness, flood.

use crate::scene::{counters, health, hear, heartbeats, is_fault, new_board, query};
use board_model::peripheral::message_ram::BusFrame;
use board_model::peripheral::rcc::Cause;
use board_model::time::PS_A_SECOND;
use glenoid::can::BaseId;
use glenoid::can::message::BLOCK;
use glenoid::procedure::Reason;

fn frame(id: u32, extended: bool, remote: bool) -> BusFrame {
    BusFrame { id, extended, remote, len: 8, data: [0x55; 8] }
}

/// The first identifier of the device's own, and of somebody else's behind them.
fn own() -> std::ops::Range<u32> {
    let first = u32::from(BaseId::DEFAULT.command().as_raw());
    first..first + u32::from(BLOCK)
}

/// B12: the bit lasts 2 us to a tenth of a percent, and is sampled at 85 % of it. The model divides its own clock tree.
#[test]
fn the_bit_is_right() {
    let board = new_board();
    let chip = board.machine.chip();
    let get = |field| u64::from(chip.can.file.get("NBTP", field));
    let quanta = (get("NBRP") + 1) * (get("NTSEG1") + get("NTSEG2") + 3);
    assert_eq!(quanta * PS_A_SECOND / u64::from(chip.clocks().fdcan), 2_000_000);
    assert_eq!(chip.can.sample_permille(), 850);
}

/// The heartbeat comes ten times a second by the board's own clock: the core's timer divides 170 MHz.
#[test]
fn a_second_is_a_second() {
    let mut board = new_board();
    assert_eq!(board.machine.chip().clocks().ahb, 170_000_000);
    let heard = heartbeats(&hear(&mut board, 10_000));
    assert!((99..=101).contains(&heard), "{heard}");
}

/// B5: the board returns from each of ten bus-offs within a second, and tells.
#[test]
fn it_comes_back_from_bus_off() {
    let mut board = new_board();
    let mut before = 0;
    for _ in 0..10 {
        board.machine.chip_mut().can.bus.shorted = true;
        assert_eq!(hear(&mut board, 1_000), []);
        board.machine.chip_mut().can.bus.shorted = false;
        let said = hear(&mut board, 1_000);
        assert!(heartbeats(&said) >= 5, "{said:?}");
        assert!(is_fault(&said, Reason::BusOff), "{said:?}");
        let said = query(&mut board);
        let bus_off = health(&said).unwrap().bus_off;
        assert!(bus_off > before, "{bus_off} after {before}");
        before = bus_off;
    }
    assert_eq!(board.machine.resets, []);
    assert_eq!(board.complaints(), [""; 0]);
}

/// B6: a minute without anybody who listens. Then it goes on.
#[test]
fn it_survives_that_nobody_listens() {
    let mut board = new_board();
    board.machine.chip_mut().can.bus.lonely = true;
    assert_eq!(hear(&mut board, 60_000), []);
    board.machine.chip_mut().can.bus.lonely = false;
    assert!(heartbeats(&hear(&mut board, 1_000)) >= 10);
    assert!(health(&query(&mut board)).unwrap().dropped > 0);
    assert_eq!(board.machine.resets, []);
    assert_eq!(board.complaints(), [""; 0]);
}

/// All other traffic is dropped by the filter; what somebody else sends in the device's name is counted. Before this program ran
/// another one had filters in the controller's memory that let everything in.
#[test]
fn foreign_frames_are_dropped_by_the_hardware() {
    let mut board = new_board();
    // RM0440, "FDCAN message RAM filter elements": by mask, no bit compared, into the first FIFO
    let everything_standard = [2 << 30 | 1 << 27; 28];
    let everything_extended = [1 << 29, 2 << 30].repeat(8);
    board.machine.chip_mut().can.ram.leave(0, &everything_standard);
    board.machine.chip_mut().can.ram.leave(28, &everything_extended);
    board.machine.reset(Cause::Pin);
    hear(&mut board, 50);
    let before = board.machine.chip().can.accepted;
    for id in (0..0x800).filter(|id| !own().contains(id)) {
        board.machine.chip_mut().can.bus.waiting.push_back(frame(id, false, false));
    }
    for id in [0, own().start, 0x1234_5678, 0x1FFF_FFFF] {
        board.machine.chip_mut().can.bus.waiting.push_back(frame(id, true, false));
        board.machine.chip_mut().can.bus.waiting.push_back(frame(id, true, true));
    }
    board.machine.chip_mut().can.bus.waiting.push_back(frame(own().start, false, true));
    hear(&mut board, 1_000);
    assert!(board.machine.chip().can.bus.waiting.is_empty());
    assert_eq!(board.machine.chip().can.accepted - before, 0);
    board.machine.chip_mut().can.bus.waiting.push_back(frame(own().end - 1, false, false));
    let said = query(&mut board);
    assert_eq!(counters(&said).unwrap().foreign, 1, "{said:?}");
    assert_eq!(board.machine.chip().can.accepted - before, 2);
    assert_eq!(board.complaints(), [""; 0]);
}

/// A bus full of commands: none is lost without a word, and the sampling goes on.
#[test]
fn a_flood_of_commands_is_borne() {
    let mut board = new_board();
    for _ in 0..4_000 {
        board.machine.chip_mut().can.bus.waiting.push_back(frame(own().start, false, false));
    }
    let said = hear(&mut board, 2_000);
    assert!(heartbeats(&said) >= 10, "{said:?}");
    assert_eq!(board.machine.resets, []);
    assert_eq!(board.complaints(), [""; 0]);
}
