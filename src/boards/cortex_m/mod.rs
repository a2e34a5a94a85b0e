//! What every Cortex-M4F board of this project does alike: the guard below the stack, and the end of a firmware that can
//! no longer be trusted.
//!
//! A board that uses it gives two functions at its crate's root: `say(&LastWords)`, called just before the reset with
//! interrupts off, for whoever listens at that moment; and `on_nmi(address)`, for what its hardware wires to the
//! non-maskable interrupt.

pub mod faults;
pub mod kept;
pub mod stack;
