//! Host side of Glenoid.

pub mod debugger;
pub mod elf;
pub mod emulator;
pub mod firmware;
pub mod packages;
pub mod slcan_client;
