//! The CAN bus outside: who is on it, what it does to the line, and how the controller is connected to it.

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
    /// CANH and CANL touch: whatever is sent, all see a recessive line.
    pub shorted: bool,
}

/// The controller's two pins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pins {
    /// Both are set up for it.
    pub connected: bool,
    /// The level at which the receive pin is stuck; high is recessive.
    pub receive: Option<bool>,
    /// The level at which the transmit pin is stuck.
    pub transmit: Option<bool>,
}

impl Pins {
    /// The controller sees a dominant line whatever is sent: a transmit pin that is stuck low holds the bus itself.
    pub fn dominant(self) -> bool {
        self.receive == Some(false) || self.transmit == Some(false)
    }

    /// What the controller sends is not what it sees.
    pub fn garbles(self) -> bool {
        self.receive.is_some() || self.transmit.is_some()
    }
}

/// Bits of a frame on the line with the space behind it: a standard frame has 44 and its data, an extended one 64; of
/// four stuffable bits one more is the most, a tenth is usual; three lie between two frames.
pub fn bits(frame: &BusFrame) -> u64 {
    let data = if frame.remote { 0 } else { frame.len as u64 * 8 };
    let stuffable = if frame.extended { 54 } else { 34 } + data;
    stuffable + stuffable / 10 + 10 + 3
}
