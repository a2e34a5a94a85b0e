//! Which frames the CAN controller lets through: those of the device's own block of identifiers.
//!
//! The command, which the device obeys, is one of them; any other frame of the block is somebody else who sends in the
//! device's name, which the device counts as foreign. What is outside of the block is dropped by the hardware and costs
//! the board nothing, however crowded the bus is.

use crate::can::BaseId;
use crate::can::message::BLOCK;

/// All bits of a standard identifier.
const ID_BITS: u16 = 0x7FF;

/// An element of the message RAM that filters nothing (SFEC = 0).
pub const NO_FILTER: u32 = 0;
/// Standard filters that the message RAM has room for (RM0440, "Message RAM"). The driver has the controller look through all of them.
pub const FILTERS: usize = 28;

/// A classic filter: identifier and mask, a mask bit of 1 is compared (RM0440, 44.3.11: SFT = 0b10).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CanFilter {
    /// What the compared bits must be.
    pub id: u16,
    /// Which bits are compared.
    pub mask: u16,
}

impl CanFilter {
    /// The filter of a device's block of identifiers.
    pub fn of_block(base: BaseId) -> Self {
        Self { id: base.command().as_raw(), mask: ID_BITS & !(BLOCK - 1) }
    }

    /// The filter as an element of the message RAM: what it accepts goes to the first FIFO (RM0440, "Standard message ID
    /// filter element": SFT, SFEC, SFID1, SFID2; the rest is reserved).
    pub const fn element(self) -> u32 {
        const BY_MASK: u32 = 0b10 << 30;
        const TO_FIFO_0: u32 = 0b001 << 27;
        BY_MASK | TO_FIFO_0 | (self.id as u32) << 16 | self.mask as u32
    }

    /// What the hardware does with this filter: does it let the identifier through?
    pub const fn accepts(self, raw_id: u16) -> bool {
        (raw_id ^ self.id) & self.mask == 0
    }
}
