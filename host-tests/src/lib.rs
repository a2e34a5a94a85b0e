//! Host side of Glenoid.

pub mod literal;
