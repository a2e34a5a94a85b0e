//! The vectors of this board's interrupts.

use super::uart;

/// The device's part of the vector table, behind the 15 exceptions of the core. Interrupts past the last entry are
/// never enabled.
// SAFETY: cortex-m-rt's linker script places this section and checks this name; the type is that of a vector.
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
pub static __INTERRUPTS: [extern "C" fn(); 4] = [uart::on_uart0, uart::on_uart0, uart::on_uart1, uart::on_uart1];
