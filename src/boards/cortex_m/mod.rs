//! What every Cortex-M4F board of this project does alike: the guard below the stack, the end of a firmware that can
//! no longer be trusted, and the code that does not run from flash.
//!
//! A board that uses it calls `hot::load` before anything else and `hot::Comparison::go_on` when there is nothing to do,
//! and gives two functions at its crate's root: `say(&CrashRecord)`, called just before the reset with interrupts off, for
//! whoever listens at that moment; and `on_nmi(address)`, for what its hardware wires to the non-maskable interrupt.

pub mod faults;
pub mod hot;
pub mod kept;
pub mod stack;
