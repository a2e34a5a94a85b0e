//! What is wrong on the board, told when it begins, while it lasts, and when it ends.

use crate::can::status::Fault;
use crate::procedure::Reason;

/// A fault that lasts, or one that comes again and again, is told once in this time, ms.
const REPEAT_MS: u32 = 1_000;

/// One kind of fault.
#[derive(Debug, Clone, Copy)]
pub(super) struct FaultWatch {
    told: Option<(Reason, u8)>,
    told_at_ms: u32,
    count: u16,
    /// Momentary faults since the last time that one was told.
    untold: bool,
}

impl FaultWatch {
    /// Nothing is wrong.
    pub const fn new() -> Self {
        Self { told: None, told_at_ms: 0, count: 0, untold: false }
    }

    /// The state of a fault that lasts: what is wrong, and with which cable (0: none). Returns what is to be told.
    pub fn update(&mut self, now_ms: u32, run_id: u16, wrong: Option<(Reason, u8)>) -> Option<Fault> {
        let repeat = wrong.is_some() && self.is_due(now_ms);
        if wrong == self.told && !repeat {
            return None;
        }
        if wrong.is_some() && wrong != self.told {
            self.count = self.count.saturating_add(1);
        }
        let (code, cable) = wrong.or(self.told)?;
        self.told = wrong;
        self.told_at_ms = now_ms;
        Some(Fault { run_id, code, cable, active: wrong.is_some(), count: self.count })
    }

    /// A momentary fault has happened so many times; 0 is fine.
    pub fn happened(&mut self, times: u16) {
        self.count = self.count.saturating_add(times);
        self.untold |= times != 0;
    }

    /// Returns what is to be told of momentary faults.
    pub fn tell(&mut self, now_ms: u32, run_id: u16, code: Reason) -> Option<Fault> {
        if !self.untold || self.told.is_some() && !self.is_due(now_ms) {
            return None;
        }
        self.untold = false;
        self.told = Some((code, 0));
        self.told_at_ms = now_ms;
        Some(Fault { run_id, code, cable: 0, active: false, count: self.count })
    }

    fn is_due(&self, now_ms: u32) -> bool {
        now_ms.wrapping_sub(self.told_at_ms) >= REPEAT_MS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SILENT: Option<(Reason, u8)> = Some((Reason::EncoderSilent, 0));

    #[test]
    fn a_lasting_fault_is_told_when_it_begins_every_second_and_when_it_ends() {
        let mut watch = FaultWatch::new();
        let told: Vec<(u32, bool, u16)> = (0..5_000)
            .filter_map(|now_ms| {
                let wrong = if (500..3_200).contains(&now_ms) { SILENT } else { None };
                watch.update(now_ms, 1, wrong).map(|fault| (now_ms, fault.active, fault.count))
            })
            .collect();
        assert_eq!(told, [(500, true, 1), (1_500, true, 1), (2_500, true, 1), (3_200, false, 1)]);
    }

    #[test]
    fn another_fault_is_told_at_once() {
        let mut watch = FaultWatch::new();
        watch.update(0, 1, SILENT);
        let fault = watch.update(1, 1, Some((Reason::EncoderJumped, 3))).unwrap();
        assert_eq!((fault.code, fault.cable, fault.count), (Reason::EncoderJumped, 3, 2));
    }

    #[test]
    fn momentary_faults_are_gathered() {
        let mut watch = FaultWatch::new();
        let mut told = Vec::new();
        for now_ms in 0..2_500 {
            watch.happened(1);
            told.extend(watch.tell(now_ms, 1, Reason::ReceiveOverrun).map(|fault| (now_ms, fault.count)));
        }
        assert_eq!(told, [(0, 1), (1_000, 1_001), (2_000, 2_001)]);
    }

    extern crate std;
    use std::vec::Vec;
}
