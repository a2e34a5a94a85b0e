//! Interrupts of the mps2-an386 that this board uses.
//!
//! Source: ARM DAI 0386, "Application note AN386", interrupt table; the same numbers stand in QEMU's `mps2.c`.

use cortex_m::interrupt::InterruptNumber;

/// An interrupt by its number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u16)]
pub enum Interrupt {
    /// UART0 received a byte.
    Uart0Receive = 0,
    /// UART0 sent a byte.
    Uart0Transmit = 1,
    /// UART1 received a byte.
    Uart1Receive = 2,
    /// UART1 sent a byte.
    Uart1Transmit = 3,
}

// SAFETY: the numbers are fixed in the device and lie within the table of vectors.rs.
unsafe impl InterruptNumber for Interrupt {
    fn number(self) -> u16 {
        self as u16
    }
}
