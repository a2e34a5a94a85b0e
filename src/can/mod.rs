//! The CAN vocabulary of `glenoid.dbc`: classic CAN, 11-bit identifiers, 8 bytes, little-endian.
//!
//! `glenoid.dbc` is the one source. The fields are written out here once more by hand, because a generated codec
//! truncates and turns NaN into 0; tests hold the two together, bit by bit.

pub mod command;
pub mod e2e;
pub mod frame;
pub mod health;
pub mod hinge;
pub mod identity;
pub mod live_set;
pub mod message;
pub mod parameter;
mod payload;
pub mod report;
pub mod result;
pub mod rounding;
pub mod set;
pub mod status;
pub mod telemetry;
pub mod watch;

pub use command::{Opcode, Order, Request};
pub use frame::{Frame, FrameError};
pub use live_set::{LiveSet, Standing};
pub use message::{BaseId, Message, UnpackError};
pub use parameter::{Operation, ParameterAnswer, ParameterRequest};
pub use payload::PackError;
pub use telemetry::Telemetry;
