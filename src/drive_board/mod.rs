//! The arithmetic behind the real drive board (STM32G474RE): what can be wrong in it without a board to tell.
//!
//! Pure functions of register values, so that the host tests them; `src/boards/nucleo_g474re` does nothing but move the
//! values in and out. Bit positions are those of RM0440 (reference manual of the STM32G4), section given at each.

pub mod bit_timing;
pub mod can_filter;
pub mod can_memory;
pub mod clock;
pub mod counts;
pub mod flash_layout;
pub mod reset;

pub use bit_timing::{BitTiming, TimingError};
pub use can_filter::CanFilter;
pub use flash_layout::{EccVerdict, LayoutError};
