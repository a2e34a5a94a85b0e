//! Commands to the procedure, whether they come from the button or over CAN.

use super::slip_monitor::SlipMonitor;
use super::{Action, Device, Press};
use crate::can::command::Request;
use crate::procedure::{Command, Reason};

impl Device {
    /// Hands a command to the procedure, and reports what it brings about beyond its answer; `None` when that comes later.
    pub(super) fn command(
        &mut self,
        now_ms: u32,
        command: Command,
        out: &mut impl FnMut(Action),
    ) -> Option<(Reason, u16)> {
        // Before another begins, whoever asked for the pose that was captured last is answered.
        self.answer_capture(now_ms, out);
        if command == Command::Accept && self.numbering_unchecked() {
            return Some((Reason::NumberingUnchecked, 0));
        }
        let reply = self.procedure.command(now_ms, command);
        if reply.is_later {
            return None;
        }
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
        Some((reply.reason, reply.detail))
    }

    /// Answers whoever asked for the pose that was captured with the tick before.
    pub(super) fn answer_capture(&mut self, now_ms: u32, out: &mut impl FnMut(Action)) {
        let Some((reason, detail)) = self.procedure.take_answer() else { return };
        match self.capture_asked.take() {
            Some(Asked::OverCan(request)) => self.answer_obeyed(now_ms, request, reason, detail, out),
            Some(Asked::ByButton(press)) => self.answer_press(now_ms, press, reason, out),
            None => {}
        }
    }
}

/// Who asked for the pose that is being captured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Asked {
    OverCan(Request),
    ByButton(Press),
}
