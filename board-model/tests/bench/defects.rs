//! Defects that were found once, put back on purpose by altering the store that the firmware makes: each is caught by name.

use crate::scene::image;
use board_model::board::Board;
use board_model::breach::Rule;
use glenoid::can::{BaseId, Frame};
use host_tests::rehearse::Bench;

const PWR_CR5: u32 = 0x4000_7080;
const RCC_CFGR: u32 = 0x4002_1008;
const FLASH_ACR: u32 = 0x4002_2000;
const FILTER_0: u32 = 0x4000_A400;
const FDCAN_NBTP: u32 = 0x4000_641C;

/// The breaches of a board whose stores pass through `alter`.
fn breaches(alter: fn(u32, u32) -> u32) -> Vec<Rule> {
    let mut board = Board::new(image(), 1);
    board.machine.chip_mut().alter = Some(alter);
    board.pass(60).unwrap();
    board.send(&Frame::new(BaseId::DEFAULT.command().as_raw(), &[0; 8]).unwrap()).unwrap();
    board.pass(10).unwrap();
    board.breaches().iter().map(|breach| breach.rule).collect()
}

#[test]
fn the_image_as_it_is_breaks_nothing() {
    assert_eq!(breaches(|_, value| value), []);
}

/// The register crate has R1MODE at bit 0: what it wrote left the bit set.
#[test]
fn the_boost_bit_at_the_wrong_place() {
    assert!(breaches(|at, value| if at == PWR_CR5 { value | 0x100 } else { value }).contains(&Rule::NoBoost));
}

/// The AHB clock was made whole in the write that selected the PLL.
#[test]
fn the_ahb_clock_undone_too_early() {
    let alter = |at, value| if at == RCC_CFGR { value & !0xF0 } else { value };
    assert!(breaches(alter).contains(&Rule::AhbStep));
}

/// The firmware reads the wait states back before it goes faster: without them it waits at half of the chip's own 16 MHz (RM0440,
/// "System clock selection"), dark and silent, and breaks no rule.
#[test]
fn too_few_wait_states() {
    let mut board = Board::new(image(), 1);
    board.machine.chip_mut().alter =
        Some(|at, value| if at == FLASH_ACR && value & 0xF == 4 { value - 1 } else { value });
    assert_eq!(board.pass(200).unwrap(), []);
    assert_eq!(board.machine.chip().clocks().ahb, 8_000_000);
    assert!(!board.is_up() && !board.lamp());
    assert_eq!(board.machine.resets, []);
    assert_eq!(board.breaches(), []);
}

/// The driver's filter word set two reserved bits.
#[test]
fn reserved_bits_of_a_filter() {
    let alter = |at, value| if at == FILTER_0 { value | 0xC000 } else { value };
    assert!(breaches(alter).contains(&Rule::ReservedBit));
}

/// Another bit rate: nothing is heard, nothing is acknowledged.
#[test]
fn a_wrong_bit_rate_is_silence() {
    let mut board = Board::new(image(), 1);
    board.machine.chip_mut().alter = Some(|at, value| if at == FDCAN_NBTP { value + (1 << 16) } else { value });
    assert_eq!(board.pass(500).unwrap(), []);
}
