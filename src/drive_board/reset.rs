//! Why the chip started (RM0440, 7.4.29: RCC_CSR).

use crate::restart::ResetCause;

/// Each flag and what it says, the gravest first. A power-up clears all others: what stands beside its flag came after it, before
/// the program had read them. Every reset also pulls the reset pin, so that flag says the least. The chip leaves standby and
/// shutdown with the low-power flag; this firmware enters neither on purpose.
const FLAGS: [(u32, ResetCause); 7] = [
    (1 << 29, ResetCause::Watchdog),
    (1 << 30, ResetCause::Watchdog),
    (1 << 25, ResetCause::OptionBytes),
    (1 << 28, ResetCause::Requested),
    (1 << 31, ResetCause::Unknown),
    (1 << 27, ResetCause::PowerOn),
    (1 << 26, ResetCause::Pin),
];

/// The cause, from RCC_CSR as it was found. The flags gather until they are cleared, which the board does at each
/// start.
pub fn cause(csr: u32) -> ResetCause {
    FLAGS.iter().find(|(flag, _)| csr & flag != 0).map_or(ResetCause::Unknown, |(_, cause)| *cause)
}
