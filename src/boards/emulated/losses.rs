//! What went wrong on the serial lines, logged at most once a second however much it is.

use glenoid::rig_link::RigLinkError;
use glenoid::slcan::SlcanError;

use super::entry::Entry;

/// Shortest time between two reports.
const INTERVAL_MS: u32 = 1_000;

/// Running totals since power-up. Every counter wraps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Losses {
    /// Lines of the CAN client answered with a bell, and the last reason.
    pub slcan: (u32, Option<SlcanError>),
    /// Lines of the rig link ignored, and the last reason.
    pub rig_link: (u32, Option<RigLinkError>),
    /// Messages for the CAN client dropped because nobody read.
    pub dropped: u32,
    /// Times that bytes of the CAN client were lost.
    pub overruns: u32,
}

/// Remembers what was reported and when.
#[derive(Debug, Default)]
pub struct LossReporter {
    reported: Losses,
    reported_at_ms: Option<u32>,
}

impl LossReporter {
    /// Gives an entry for each total that has changed, unless the last report is too fresh.
    pub fn report(&mut self, now_ms: u32, losses: Losses, mut push: impl FnMut(Entry)) {
        let too_fresh = self.reported_at_ms.is_some_and(|at_ms| now_ms.wrapping_sub(at_ms) < INTERVAL_MS);
        if losses == self.reported || too_fresh {
            return;
        }
        if let (so_far, Some(last)) = losses.slcan
            && losses.slcan != self.reported.slcan
        {
            push(Entry::SlcanRefused { last, so_far });
        }
        if let (so_far, Some(last)) = losses.rig_link
            && losses.rig_link != self.reported.rig_link
        {
            push(Entry::RigLinkIgnored { last, so_far });
        }
        if losses.dropped != self.reported.dropped {
            push(Entry::NobodyReads { dropped: losses.dropped });
        }
        if losses.overruns != self.reported.overruns {
            push(Entry::Overrun { so_far: losses.overruns });
        }
        self.reported = losses;
        self.reported_at_ms = Some(now_ms);
    }
}
