//! The CAN vocabulary of `glenoid.dbc`: classic CAN, 11-bit identifiers, 8 bytes, little-endian.
//!
//! `glenoid.dbc` is the one source. The fields are written out here once more by hand, because a generated codec
//! truncates and turns NaN into 0; tests hold the two together, bit by bit.

pub mod command;
pub mod frame;
pub mod health;
pub mod message;
mod payload;
pub mod report;
pub mod result;
pub mod rounding;
pub mod status;
pub mod watch;

pub use command::{Opcode, Order, Request};
pub use frame::{Frame, FrameError};
pub use message::{BaseId, Message, UnpackError};
pub use payload::PackError;
