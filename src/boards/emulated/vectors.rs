//! Interrupts of the mps2-an386 that this board uses.
//!
//! Source: ARM DAI 0386, "Application note AN386", interrupt table; the same numbers stand in QEMU's `mps2.c`.

use cortex_m::interrupt::InterruptNumber;

use super::uart;

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

// SAFETY: the numbers are fixed in the device and lie within the table below.
unsafe impl InterruptNumber for Interrupt {
    fn number(self) -> u16 {
        self as u16
    }
}

/// The device's part of the vector table, behind the 15 exceptions of the core. Interrupts past the last entry are
/// never enabled.
// SAFETY: cortex-m-rt's linker script places this section and checks this name; the type is that of a vector.
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
pub static __INTERRUPTS: [extern "C" fn(); 4] = [uart::on_uart0, uart::on_uart0, uart::on_uart1, uart::on_uart1];
