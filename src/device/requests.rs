//! Frames that come in: commands are obeyed and answered, everything else is counted.

use super::commands::Asked;
use super::report::Parts;
use super::{Action, Device, LogEntry};
use crate::can::command::{NamedValue, Order, Request, ZERO_PRIOR_STEP_MM};
use crate::can::status::Answer;
use crate::can::{Frame, Message, Opcode};
use crate::procedure::{Command, PoseSet, Reason};

impl Device {
    pub(super) fn receive(&mut self, now_ms: u32, frame: &Frame, out: &mut impl FnMut(Action)) {
        if frame.raw_id() == self.base.command().as_raw() {
            self.receive_command(now_ms, frame, out);
        } else if frame.raw_id() == self.base.parameters().as_raw() {
            self.receive_parameter_request(now_ms, frame, out);
        } else {
            self.counters.foreign = self.counters.foreign.saturating_add(1);
        }
    }

    fn receive_command(&mut self, now_ms: u32, frame: &Frame, out: &mut impl FnMut(Action)) {
        let request = match Request::unpack(frame.data()) {
            Ok(request) => request,
            Err((request, reason)) => {
                self.counters.malformed = self.counters.malformed.saturating_add(1);
                self.answer(&request, reason, 0, out);
                return;
            }
        };
        if request.nonce != 0
            && let Some(answer) = self.answered.find(now_ms, &request)
        {
            self.send(&Message::Answer(answer), out);
            return;
        }
        if request.nonce != 0 && self.capture_asked == Some(Asked::OverCan(request)) {
            // A repetition: the answer is on its way.
            return;
        }
        // The answer that is on its way will be remembered too.
        let is_awaited = matches!(self.capture_asked, Some(Asked::OverCan(_)));
        if is_remembered(&request) && !self.answered.has_room_for(1 + usize::from(is_awaited)) {
            self.answer(&request, Reason::TooManyCommands, 0, out);
            return;
        }
        match self.obey(now_ms, &request, out) {
            Some((reason, detail)) => self.answer_obeyed(now_ms, request, reason, detail, out),
            None => self.capture_asked = Some(Asked::OverCan(request)),
        }
    }

    /// Answers a request that was obeyed or refused, and remembers it.
    pub(super) fn answer_obeyed(
        &mut self,
        now_ms: u32,
        request: Request,
        reason: Reason,
        detail: u16,
        out: &mut impl FnMut(Action),
    ) {
        let answer = self.answer(&request, reason, detail, out);
        if is_remembered(&request) {
            self.answered.note(now_ms, request, answer);
        }
        out(Action::Log(LogEntry::Command { request, reason }));
    }

    fn answer(&mut self, request: &Request, code: Reason, detail: u16, out: &mut impl FnMut(Action)) -> Answer {
        let answer =
            Answer { opcode: request.opcode, code, nonce: request.nonce, run_id: self.procedure.run_id(), detail };
        self.send(&Message::Answer(answer), out);
        answer
    }

    /// What a request brings about: its answer, or `None` when that comes later.
    fn obey(&mut self, now_ms: u32, request: &Request, out: &mut impl FnMut(Action)) -> Option<(Reason, u16)> {
        Some(match request.order(self.procedure.run_id()) {
            Err(reason) => (reason, 0),
            Ok(Order::Procedure(command)) => return self.command(now_ms, command, out),
            Ok(Order::Accept(value)) => return self.accept_named(now_ms, value, out),
            Ok(Order::Confirm(value)) => self.confirm_named(now_ms, value, out),
            Ok(Order::SetWearer { wearer }) => (self.procedure.set_wearer(wearer), wearer),
            Ok(Order::CheckCable { cable }) => self.check_cable(now_ms, cable),
            Ok(Order::ReadPose { set, index }) => (self.read_out(set, index), u16::from(index)),
            Ok(Order::SetZeroPrior { steps }) => (self.set_zero_prior(f32::from(steps) * ZERO_PRIOR_STEP_MM), 0),
            Ok(Order::Query) => {
                // the report that follows says all about it
                self.restart_is_news = false;
                self.reporter.begin(now_ms, Parts { device: true, live: true, run: true });
                (Reason::Fine, u16::from(self.procedure.state().code()))
            }
        })
    }

    /// Accepts the new centre if it is the one that is named, and was shown whole.
    fn accept_named(&mut self, now_ms: u32, value: NamedValue, out: &mut impl FnMut(Action)) -> Option<(Reason, u16)> {
        // in another state the procedure says why not
        if let Some(candidate) = self.procedure.candidate() {
            let is_shown = self.reporter.has_shown(candidate.run_id());
            match self.shown_candidate() {
                Some(shown) if !shown.is_named_by(&value) => return Some((Reason::WrongValue, 0)),
                Some(_) if is_shown => {}
                _ => return Some((Reason::ReportIncomplete, 0)),
            }
        }
        self.command(now_ms, Command::Accept, out)
    }

    /// Confirms the centre in use, if it is the one that is named.
    fn confirm_named(&mut self, now_ms: u32, value: NamedValue, out: &mut impl FnMut(Action)) -> (Reason, u16) {
        let Some(shown) = self.shown_live() else { return (Reason::WrongState, 0) };
        if !shown.is_named_by(&value) {
            return (Reason::WrongValue, 0);
        }
        match self.procedure.fault(now_ms) {
            Some(fault) => (fault.reason, u16::from(fault.cable)),
            None => (self.confirm(out), 0),
        }
    }

    /// A wider prior costs poses and hides nothing; a narrower one than the parameter hides what homing left.
    fn set_zero_prior(&mut self, prior_mm: f32) -> Reason {
        let stated_mm = self.procedure.limits().settings().zero_prior_mm;
        if prior_mm < stated_mm && !self.lock.is_open() {
            return Reason::Locked;
        }
        self.procedure.set_zero_prior(prior_mm)
    }

    fn read_out(&mut self, set: PoseSet, index: u8) -> Reason {
        if usize::from(index) >= self.procedure.poses_of(set) {
            Reason::NoSuchPose
        } else if self.reporter.read_out(set, index) {
            Reason::Fine
        } else {
            Reason::Busy
        }
    }
}

/// A repetition of this request is to be answered again and not obeyed again. Queries change nothing and may be asked again
/// at once.
const fn is_remembered(request: &Request) -> bool {
    request.nonce != 0 && !is_query(request.opcode)
}

/// Commands that change nothing but what is sent.
const fn is_query(opcode: u8) -> bool {
    opcode == Opcode::Query as u8 || opcode == Opcode::ReadPose as u8
}
