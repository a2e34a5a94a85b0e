//! The parameters: every constant of the rig and every setting, readable and settable over CAN.
//!
//! [`TABLE`] is the one list of them. A [`ParameterSet`] holds a value for each; checked as a whole it becomes the
//! [`Config`] of a device. The device prepares a set in RAM, stores it whole, and starts anew with
//! it: no constant ever changes while something goes by it.

mod config;
mod hinge;
mod machine;
mod set;
mod table;

pub use config::{Config, DEFAULT_LIVE_PERIOD_MS, DEFAULT_TELEMETRY_HZ};
pub use machine::{Contradiction, LOCK_KEYS};
pub use set::{ParameterSet, find, next};
pub use table::{COUNT, Description, Entry, Key, Kind, TABLE};

#[cfg(test)]
mod tests;
