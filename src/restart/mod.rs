//! Why the board last started, and the crash record of the firmware that stopped.
//!
//! A board whose firmware can no longer be trusted (panic, fault, full stack, watchdog) does not try to go on: it writes
//! a crash record into RAM that a reset leaves alone, resets, and starts as at power-up: no run, the stored centre in
//! use. The next start finds the record, and the device sends it on the bus. That is the safe state of this device:
//! it moves nothing, it only must not name a wrong centre.

mod cause;
mod crash_record;

pub use cause::ResetCause;
pub use crash_record::{Area, CrashRecord, TEXT_LEN};

/// What a board knows about its last start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Restart {
    /// Why it started.
    pub cause: ResetCause,
    /// What the firmware said before it stopped, if it could.
    pub crash_record: Option<CrashRecord>,
}

impl Restart {
    /// From what the hardware says (its reset flags), and the area that the crash record lies in.
    ///
    /// The crash record is only that of this restart if the firmware itself, or the watchdog, brought it about: after a
    /// power-up it is what the RAM happens to hold, whatever its checksum says.
    pub fn new(by_hardware: ResetCause, area: &Area) -> Self {
        let crash_record = match by_hardware {
            ResetCause::PowerOn => None,
            _ => CrashRecord::open(area),
        };
        Self { cause: crash_record.as_ref().map_or(by_hardware, |record| record.cause), crash_record }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_crash_record_says_more_than_the_hardware() {
        let record = CrashRecord::new(ResetCause::StackOverflow, 0x0800_1234, 0, format_args!("full"));
        let by = |hardware| Restart::new(hardware, &record.seal());
        assert_eq!(by(ResetCause::Requested).cause, ResetCause::StackOverflow);
        assert_eq!(by(ResetCause::Requested).crash_record, Some(record));
        assert_eq!(by(ResetCause::PowerOn), Restart { cause: ResetCause::PowerOn, crash_record: None });
    }

    #[test]
    fn without_a_crash_record_the_hardware_is_believed() {
        let restart = Restart::new(ResetCause::Watchdog, &[0; _]);
        assert_eq!(restart, Restart { cause: ResetCause::Watchdog, crash_record: None });
    }
}
