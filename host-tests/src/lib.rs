//! Host side of Glenoid.

pub mod plot;
pub mod wearer;
