//! CAN vocabulary: frames and messages of `glenoid.dbc`.

pub mod frame;

pub use frame::{Frame, FrameError};
