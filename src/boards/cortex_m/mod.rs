//! What every Cortex-M4F board of this project does alike: the guard below the stack, the device in its place, the end of a
//! firmware that can no longer be trusted, and the code that does not run from flash.
//!
//! A board that uses it calls `ccm_code::load` before anything else and `ccm_code::Comparison::go_on` when there is
//! nothing to do, and gives two functions that the linker finds by their names (`faults.rs`): `board_says`, called just
//! before a reset, and `board_on_nmi`.

pub mod ccm_code;
pub mod faults;
pub mod in_place;
pub mod retained_ram;
pub mod stack;
