//! What the device notes for the board's log.

use super::button::Press;
use crate::can::command::Request;
use crate::can::watch::WatchReport;
use crate::procedure::{PoseNotice, Reason, StateName};

/// What is worth noting in a log.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum LogEntry {
    /// The procedure changed its state.
    State {
        /// The run.
        run_id: u16,
        /// The state before.
        from: StateName,
        /// The state now.
        to: StateName,
        /// Why the run stands where it stands.
        reason: Reason,
    },
    /// A pose was captured or refused.
    Pose(PoseNotice),
    /// The button was pressed.
    Press {
        /// How.
        press: Press,
        /// What became of it.
        reason: Reason,
    },
    /// A command came over CAN.
    Command {
        /// What was asked for.
        request: Request,
        /// What was answered.
        reason: Reason,
    },
    /// A hinge was identified: half of its numbers.
    HingeIdentified {
        /// The run.
        run_id: u16,
        /// 0: axis and foot point in the base; 1: the same in the platform.
        body: u8,
        /// x, y, z of either, as the bits of single-precision numbers.
        bits: [u32; 6],
    },
    /// A centre was identified.
    Identified {
        /// The run.
        run_id: u16,
        /// x, y, z, p1, p2, p3 as the bits of single-precision numbers in mm.
        bits: [u32; 6],
    },
    /// The record was taken into use ([`Reason::Fine`], and the run is not 0), was not there, or was refused.
    Loaded {
        /// The run of the record.
        run_id: u16,
        /// Why it was refused.
        reason: Reason,
    },
    /// The watch warns of a slip.
    Slipped(WatchReport),
    /// The record was stored, or why not.
    Stored {
        /// The run of the record.
        run_id: u16,
        /// Why it was not stored.
        reason: Reason,
    },
}
