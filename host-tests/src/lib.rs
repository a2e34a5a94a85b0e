//! Host side of Glenoid.

pub mod plot;
