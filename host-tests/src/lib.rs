//! Host side of Glenoid.

pub mod literal;
pub mod emulator;
pub mod firmware;
pub mod packages;
pub mod slcan_client;
pub mod plot;
pub mod wearer;
