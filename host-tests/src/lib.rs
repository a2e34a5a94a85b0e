//! Host side of Glenoid.
