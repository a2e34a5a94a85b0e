//! A line of the log about what the device noted.
//!
//! Written out rather than derived: the derived form of a floating-point number alone takes 20 KB of flash.

use core::fmt;

use glenoid::device::LogEntry;

/// Writes the entry in a line's length.
pub fn write(entry: &LogEntry, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    match *entry {
        LogEntry::State { run_id, from, to, reason } => {
            write!(f, "run {run_id}, from: {from:?}, to: {to:?}, {reason:?}")
        }
        LogEntry::Pose(notice) => {
            write!(f, "pose {} of {:?}: {:?}", notice.index, notice.set, notice.reason)?;
            if notice.cable != 0 {
                write!(f, ", cable {}", notice.cable)?;
            }
            if let Some(sigma_mm) = notice.sigma_mm {
                write!(f, ", sigma {} um", thousandths(sigma_mm))?;
            }
            if let Some(distance_rad) = notice.distance_rad {
                write!(f, ", {} mrad to the nearest", thousandths(distance_rad))?;
            }
            write!(f, ", next {:?}", notice.guidance)
        }
        LogEntry::Press { press, reason } => write!(f, "{press:?} press: {reason:?}"),
        LogEntry::Command { request, reason } => write!(
            f,
            "command {} (nonce {}, run {}, argument {}): {reason:?}",
            request.opcode, request.nonce, request.run_id, request.argument
        ),
        LogEntry::Identified { run_id, bits } => {
            write!(f, "run {run_id} identified")?;
            bits.iter().try_for_each(|bits| write!(f, " {bits:08x}"))
        }
        LogEntry::HingeIdentified { run_id, body, bits } => {
            write!(f, "run {run_id} identified a hinge, body {body}:")?;
            bits.iter().try_for_each(|bits| write!(f, " {bits:08x}"))
        }
        LogEntry::Loaded { run_id, reason } => write!(f, "record of run {run_id} loaded: {reason:?}"),
        LogEntry::Slipped(report) => {
            write!(f, "centre of run {} slipped: {:?}", report.run_id, report.cause)?;
            if report.cable != 0 {
                write!(f, ", cable {}", report.cable)?;
            }
            report.moved_mm.iter().try_for_each(|moved_mm| write!(f, " {}", thousandths(*moved_mm)))?;
            f.write_str(" um")
        }
        LogEntry::Stored { run_id, reason } => write!(f, "record of run {run_id} stored: {reason:?}"),
    }
}

/// The number in thousandths, rounded; what does not fit reads as the largest that does.
fn thousandths(value: f32) -> i32 {
    libm::roundf(value * 1000.0) as i32
}
