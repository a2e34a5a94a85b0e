//! The drive board's chip (STM32G474RE) as a register-level model, for the real image.
//!
//! It is built from the reference manual's facts (RM0440), the architecture's (ARMv7-M ARM) and ST's description of the
//! registers. Whatever the firmware does that these forbid is a [`breach::Breach`], told with the program counter.

mod address_map;
pub mod arguments;
pub mod board;
pub mod breach;
pub mod by_button;
pub mod chip;
pub mod core;
mod exceptions;
mod hooks;
pub mod image;
pub mod log;
pub mod machine;
mod marks;
pub mod memories;
pub mod peripheral;
pub mod power_cuts;
pub mod register_file;
pub mod time;
