//! Frames that come in: commands are obeyed and answered, everything else is counted.

use super::report::Parts;
use super::{Action, Device, LogEntry};
use crate::can::command::{Order, Request, ZERO_PRIOR_STEP_MM};
use crate::can::status::Answer;
use crate::can::{Frame, Message, Opcode};
use crate::procedure::{PoseSet, Reason};

/// Within this time, ms, the same frame (same nonce, not 0) is a repetition: its answer was lost, not its effect.
const REPETITION_MS: u32 = 1_000;

impl Device {
    pub(super) fn receive(&mut self, now_ms: u32, frame: &Frame, out: &mut impl FnMut(Action)) {
        if frame.raw_id() != self.base.command().as_raw() {
            self.counters.foreign = self.counters.foreign.saturating_add(1);
            return;
        }
        let (request, malformed) = match Request::unpack(frame.data()) {
            Ok(request) => (request, None),
            Err((request, reason)) => (request, Some(reason)),
        };
        if let Some(reason) = malformed {
            self.counters.malformed = self.counters.malformed.saturating_add(1);
            self.answer(&request, reason, 0, out);
            return;
        }
        if let Some((_, answer, _)) = self.answered.filter(|(asked, _, at_ms)| {
            *asked == request && request.nonce != 0 && now_ms.wrapping_sub(*at_ms) < REPETITION_MS
        }) {
            self.send(&Message::Answer(answer), out);
            return;
        }
        let (reason, detail) = self.obey(now_ms, &request, out);
        let answer = self.answer(&request, reason, detail, out);
        // A query changes nothing and may be asked again at once.
        if request.opcode != Opcode::Query as u8 {
            self.answered = Some((request, answer, now_ms));
        }
        out(Action::Log(LogEntry::Command { request, reason }));
    }

    fn answer(&mut self, request: &Request, code: Reason, detail: u16, out: &mut impl FnMut(Action)) -> Answer {
        let answer =
            Answer { opcode: request.opcode, code, nonce: request.nonce, run_id: self.procedure.run_id(), detail };
        self.send(&Message::Answer(answer), out);
        answer
    }

    fn obey(&mut self, now_ms: u32, request: &Request, out: &mut impl FnMut(Action)) -> (Reason, u16) {
        match request.order(self.procedure.run_id()) {
            Err(reason) => (reason, 0),
            Ok(Order::Procedure(command)) => self.command(now_ms, command, out),
            Ok(Order::ReadPose { set, index }) => (self.read_out(set, index), u16::from(index)),
            Ok(Order::SetZeroPrior { steps }) => {
                (self.procedure.set_zero_prior(f32::from(steps) * ZERO_PRIOR_STEP_MM), 0)
            }
            Ok(Order::Query) => {
                // the report that follows says all about it
                self.restart_is_news = false;
                self.reporter.begin(now_ms, Parts { device: true, live: true, run: true });
                (Reason::Fine, u16::from(self.procedure.state().code()))
            }
        }
    }

    fn read_out(&mut self, set: PoseSet, index: u8) -> Reason {
        if usize::from(index) >= self.procedure.poses(set).len() {
            Reason::NoSuchPose
        } else if self.reporter.read_out(set, index) {
            Reason::Fine
        } else {
            Reason::Busy
        }
    }
}
