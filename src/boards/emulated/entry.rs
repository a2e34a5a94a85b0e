//! What this board writes into its log.

use core::fmt;

use glenoid::device::{BlinkPattern, LogEntry};
use glenoid::rig_link::RigLinkError;
use glenoid::slcan::SlcanError;

use super::cortex::stack;
use super::device_entry;

/// One line of the log.
pub enum Entry {
    /// Power-up is over: both lines are served.
    Ready { stack: stack::Usage },
    /// What the parts of the device take of the static RAM, in bytes.
    Memory { device: usize, poses: usize, estimator: usize },
    /// The device has something to say.
    Device(LogEntry),
    /// The status LED shows another pattern.
    StatusLed(BlinkPattern),
    /// Lines of the CAN client were answered with a bell.
    SlcanRefused { last: SlcanError, so_far: u32 },
    /// Lines of the rig link were ignored.
    RigLinkIgnored { last: RigLinkError, so_far: u32 },
    /// Messages for the CAN client found their queue full.
    NobodyReads { dropped: u32 },
    /// Bytes of the CAN client were lost.
    Overrun { so_far: u32 },
    /// How far the stack has reached since the board was ready.
    Stack(stack::Usage),
}

impl fmt::Display for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Ready { stack } => {
                write!(f, "board: ready, {} of {} bytes of stack used to get here", stack.used_bytes, stack.size_bytes)
            }
            Self::Memory { device, poses, estimator } => {
                write!(f, "memory: {device} bytes of device, {poses} of them for poses, {estimator} for the estimator")
            }
            Self::Device(entry) => {
                f.write_str("device: ")?;
                device_entry::write(entry, f)
            }
            Self::StatusLed(pattern) => write!(f, "status LED: {pattern:?}"),
            Self::SlcanRefused { last, so_far } => {
                write!(f, "slcan: {so_far} lines refused so far, last: {last} ({})", last.code())
            }
            Self::RigLinkIgnored { last, so_far } => {
                write!(f, "rig link: {so_far} lines ignored so far, last: {last} ({})", last.code())
            }
            Self::NobodyReads { dropped } => write!(f, "can: {dropped} messages dropped so far, nobody reads"),
            Self::Overrun { so_far } => write!(f, "can: bytes lost {so_far} times so far"),
            Self::Stack(usage) => {
                write!(
                    f,
                    "stack: {} of {} bytes used at most since the board was ready",
                    usage.used_bytes, usage.size_bytes
                )
            }
        }
    }
}
