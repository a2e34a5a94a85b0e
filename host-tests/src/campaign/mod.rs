//! Long runs of chance against the device on the host: what must hold in a million of them.

pub mod accepts;
pub mod telemetry;
