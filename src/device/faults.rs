//! What is wrong on the board: reported when it begins, while it lasts, and when it ends.

use crate::can::status::Fault;
use crate::procedure::Reason;

/// A fault that lasts, or one that comes again and again, is reported once in this time, ms.
const REPEAT_MS: u32 = 1_000;

/// One kind of fault.
#[derive(Debug, Clone, Copy)]
pub(super) struct FaultReporter {
    reported: Option<(Reason, u8)>,
    reported_at_ms: u32,
    count: u16,
    /// Momentary faults since the last report.
    unreported: bool,
}

impl FaultReporter {
    /// Nothing is wrong.
    pub const fn new() -> Self {
        Self { reported: None, reported_at_ms: 0, count: 0, unreported: false }
    }

    /// The state of a fault that lasts: what is wrong, and with which cable (0: none). Returns what is to be reported.
    pub fn update(&mut self, now_ms: u32, run_id: u16, wrong: Option<(Reason, u8)>) -> Option<Fault> {
        let repeat = wrong.is_some() && self.is_due(now_ms);
        if wrong == self.reported && !repeat {
            return None;
        }
        if wrong.is_some() && wrong != self.reported {
            self.count = self.count.saturating_add(1);
        }
        let (code, cable) = wrong.or(self.reported)?;
        self.reported = wrong;
        self.reported_at_ms = now_ms;
        Some(Fault { run_id, code, cable, active: wrong.is_some(), count: self.count })
    }

    /// A momentary fault has happened so many times; 0 is fine.
    pub fn happened(&mut self, times: u16) {
        self.count = self.count.saturating_add(times);
        self.unreported |= times != 0;
    }

    /// Returns the report of momentary faults, if one is due.
    pub fn report(&mut self, now_ms: u32, run_id: u16, code: Reason) -> Option<Fault> {
        if !self.unreported || self.reported.is_some() && !self.is_due(now_ms) {
            return None;
        }
        self.unreported = false;
        self.reported = Some((code, 0));
        self.reported_at_ms = now_ms;
        Some(Fault { run_id, code, cable: 0, active: false, count: self.count })
    }

    fn is_due(&self, now_ms: u32) -> bool {
        now_ms.wrapping_sub(self.reported_at_ms) >= REPEAT_MS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SILENT: Option<(Reason, u8)> = Some((Reason::EncoderSilent, 0));

    #[test]
    fn a_lasting_fault_is_reported_when_it_begins_every_second_and_when_it_ends() {
        let mut watch = FaultReporter::new();
        let reported: Vec<(u32, bool, u16)> = (0..5_000)
            .filter_map(|now_ms| {
                let wrong = if (500..3_200).contains(&now_ms) { SILENT } else { None };
                watch.update(now_ms, 1, wrong).map(|fault| (now_ms, fault.active, fault.count))
            })
            .collect();
        assert_eq!(reported, [(500, true, 1), (1_500, true, 1), (2_500, true, 1), (3_200, false, 1)]);
    }

    #[test]
    fn another_fault_is_reported_at_once() {
        let mut watch = FaultReporter::new();
        watch.update(0, 1, SILENT);
        let fault = watch.update(1, 1, Some((Reason::EncoderJumped, 3))).unwrap();
        assert_eq!((fault.code, fault.cable, fault.count), (Reason::EncoderJumped, 3, 2));
    }

    #[test]
    fn momentary_faults_are_gathered() {
        let mut watch = FaultReporter::new();
        let mut reported = Vec::new();
        for now_ms in 0..2_500 {
            watch.happened(1);
            reported.extend(watch.report(now_ms, 1, Reason::ReceiveOverrun).map(|fault| (now_ms, fault.count)));
        }
        assert_eq!(reported, [(0, 1), (1_000, 1_001), (2_000, 2_001)]);
    }

    extern crate std;
    use std::vec::Vec;
}
