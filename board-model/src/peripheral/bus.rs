//! The CAN bus outside: who is on it, and what it does to the line.

use super::message_ram::BusFrame;
use std::collections::VecDeque;

/// The bit rate of the others, bit/s.
pub const BIT_HZ: u64 = 500_000;
/// How far a controller's bit may be off (ISO 11898-1: its oscillator within half a percent at this rate), permille.
pub const TOLERANCE_PERMILLE: u64 = 5;

/// The bus.
#[derive(Debug, Clone, Default)]
pub struct CanBus {
    /// Frames that others want to send, in order.
    pub waiting: VecDeque<BusFrame>,
    /// Frames that the board has sent: when, ps, and what.
    pub sent: Vec<(u64, BusFrame)>,
    /// Nobody else is there to acknowledge.
    pub lonely: bool,
    /// CANH and CANL touch.
    pub shorted: bool,
}

/// Bits of a frame on the line with the space behind it: a standard frame has 44 and its data, an extended one 64; of
/// four stuffable bits one more is the most, a tenth is usual; three lie between two frames.
pub fn bits(frame: &BusFrame) -> u64 {
    let data = if frame.remote { 0 } else { frame.len as u64 * 8 };
    let stuffable = if frame.extended { 54 } else { 34 } + data;
    stuffable + stuffable / 10 + 10 + 3
}
