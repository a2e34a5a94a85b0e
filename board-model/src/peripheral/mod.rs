//! The chip's peripherals: one a file, each with the rules that the reference manual gives it.

pub mod bus;
pub mod clocks;
pub mod fdcan;
pub mod flash;
pub mod gpio;
pub mod iwdg;
pub mod message_ram;
pub mod plain;
pub mod rcc;
pub mod timer;
pub mod words;

use crate::breach::Breaches;
use crate::core::nvic::Nvic;
use clocks::Clocks;

/// What a peripheral sees of the rest of the chip.
pub struct Env<'a> {
    /// Time, ps.
    pub now_ps: u64,
    /// The clocks.
    pub clocks: Clocks,
    /// Where breaches are noted.
    pub breaches: &'a mut Breaches,
    /// Where interrupts become pending.
    pub nvic: &'a mut Nvic,
}
