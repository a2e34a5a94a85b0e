//! The device in its place.

use cortex_m::singleton;
use glenoid::device::{Config, Device};

/// The device in its place; `None` if it was called before.
// A frame of its own: what building it takes of the stack (18 KB, `cargo stack --ways`) is free again before anything else
// runs.
#[inline(never)]
pub fn device(config: &Config) -> Option<&'static mut Device> {
    singleton!(: Device = Device::new(config))
}
