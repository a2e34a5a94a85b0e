//! Host side of Glenoid.

pub mod anatomy;
pub mod arm;
pub mod board_lines;
pub mod campaign;
pub mod command_line;
pub mod commission;
pub mod debugger;
pub mod emulator;
pub mod estimation;
pub mod firmware;
pub mod flash;
pub mod identify;
pub mod live;
mod monitor;
pub mod packages;
pub mod plot;
pub mod power_cut;
pub mod rehearse;
pub mod slcan_client;
pub mod study;
pub mod wearer;

/// The paper written out the long way.
pub use paper_oracle as literal;
pub use vocabulary;
