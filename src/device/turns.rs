//! What the device does as time passes: beside what is short, one thing a tick, so that no tick is longer than the longest of
//! them (`cargo cycles`). While there is computing to do it has every second tick at least.

use super::{Action, Device};

/// What takes long beside the computing; the most urgent first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Sending {
    Heartbeat,
    /// What a controller acts on is put into a set.
    LiveSet,
    /// What the cables show is.
    Telemetry,
    /// The next frames of a report.
    Report,
}

impl Device {
    pub(super) fn tick(&mut self, now_ms: u32, out: &mut impl FnMut(Action)) {
        self.lock.tick(now_ms);
        self.answer_capture(now_ms, out);
        self.restart_when_saved(now_ms, out);
        let sending = self.sending_that_is_due(now_ms);
        // An accepted centre is stored before anything else.
        let may_wait = self.is_busy() && !self.keep_is_due && !self.computing_waited;
        let computing_waits = (sending.is_some() || self.has_pieces()) && may_wait;
        self.computing_waited = computing_waits;
        let has_computed = !computing_waits && self.compute(now_ms, out);
        if !has_computed {
            self.send_what_is_due(sending, now_ms, out);
        }
        self.tick_button(now_ms, out);
        self.report_fault(now_ms, out);
        self.show(now_ms, out);
    }

    fn send_what_is_due(&mut self, sending: Option<Sending>, now_ms: u32, out: &mut impl FnMut(Action)) {
        match sending {
            Some(Sending::Heartbeat) => {
                self.check_live(out);
                self.send_heartbeat(now_ms, out);
            }
            Some(Sending::LiveSet) => self.form_live_set(now_ms),
            Some(Sending::Telemetry) => self.form_telemetry(now_ms),
            Some(Sending::Report) => self.send_report(now_ms, out),
            None => {}
        }
        self.send_pieces(out);
    }

    fn sending_that_is_due(&self, now_ms: u32) -> Option<Sending> {
        if self.pace.heartbeat_is_due(now_ms) {
            Some(Sending::Heartbeat)
        } else if self.live_set_is_due(now_ms) {
            Some(Sending::LiveSet)
        } else if self.telemetry_is_due(now_ms) {
            Some(Sending::Telemetry)
        } else {
            self.reporter.has_more(now_ms).then_some(Sending::Report)
        }
    }

    /// A slice of the computing; poses are captured, and times run out. Did it take long?
    fn compute(&mut self, now_ms: u32, out: &mut impl FnMut(Action)) -> bool {
        let was_busy = self.is_busy();
        if core::mem::take(&mut self.keep_is_due) {
            self.keep(out);
        } else if self.slip_monitor.is_to_be_built() {
            self.slip_monitor.build(&self.procedure);
        } else {
            self.monitor_tick(out);
            if let Some(notice) = self.procedure.tick(now_ms) {
                self.note_pose(now_ms, &notice, out);
                return true;
            }
        }
        was_busy || self.is_busy()
    }
}
