//! Commands to the procedure, whether they come from the button or over CAN.

use super::slip_monitor::SlipMonitor;
use super::{Action, Device};
use crate::procedure::{Command, Reason};

impl Device {
    /// Hands a command to the procedure, and reports what it brings about beyond its answer.
    pub(super) fn command(&mut self, now_ms: u32, command: Command, out: &mut impl FnMut(Action)) -> (Reason, u16) {
        if command == Command::Accept && self.numbering_unchecked() {
            return (Reason::NumberingUnchecked, 0);
        }
        let reply = self.procedure.command(now_ms, command);
        if let Some(notice) = &reply.pose {
            self.note_pose(now_ms, notice, out);
        }
        if command == Command::Acknowledge && reply.reason == Reason::Fine {
            self.reporter.stop_repeating();
            self.slip_monitor.acknowledge();
        }
        if command == Command::Accept && reply.reason == Reason::Fine {
            self.confirmed = true;
            self.seal_live();
            self.trust(None, out);
            // stored, and watched over, from the next ticks on: an accept does enough
            self.keep_is_due = true;
            self.slip_monitor = SlipMonitor::to_be_built();
        }
        if matches!(command, Command::Start { .. }) && reply.reason == Reason::Fine {
            self.reporter.forget_shown();
            self.journal(out);
        }
        (reply.reason, reply.detail)
    }
}
