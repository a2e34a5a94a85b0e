//! Host side of Glenoid.

pub mod command_line;
pub mod cycles;
pub mod debugger;
pub mod drive_board_image;
pub mod elf;
pub mod emulator;
pub mod firmware;
pub mod flash;
pub mod hot_code;
pub mod identify;
pub mod literal;
pub mod live;
mod monitor;
pub mod packages;
pub mod plot;
pub mod power_cut;
pub mod rehearse;
pub mod slcan_client;
pub mod stack_bound;
pub mod study;
pub mod wearer;

pub use vocabulary;
