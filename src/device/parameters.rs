//! Requests about parameters: read, prepare, check as a whole, store as a whole, start anew.

use super::persistence::reason_of_store;
use super::{Action, Device, sets};
use crate::can::{Frame, Message, Operation, ParameterAnswer, ParameterRequest};
use crate::parameters::{Key, ParameterSet, find, next};
use crate::procedure::{Reason, StateName};
use crate::record::StoreError;
use crate::restart::{ResetCause, Restart};

/// So long after the answer to a save the device starts anew, ms: the answer must be on its way.
const RESTART_AFTER_MS: u32 = 50;

/// What saving waits for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Saving {
    Nothing,
    /// The board stores, or erases; then this request is answered.
    Storing(ParameterRequest),
    /// Stored at this time: the device is about to start anew.
    Stored(u32),
}

impl Device {
    pub(super) fn receive_parameter_request(&mut self, now_ms: u32, frame: &Frame, out: &mut impl FnMut(Action)) {
        let request = match ParameterRequest::unpack(frame.data()) {
            Ok(request) => request,
            Err((request, reason)) => {
                self.counters.malformed = self.counters.malformed.saturating_add(1);
                self.answer_parameter(&request, Err(reason), out);
                return;
            }
        };
        if request.nonce != 0
            && let Some(answer) = self.parameters_answered.find(now_ms, &request)
        {
            self.send(&Message::Parameter(answer), out);
            return;
        }
        let operation = Operation::from_code(request.operation);
        let remembered = request.nonce != 0 && !operation.is_some_and(Operation::is_query);
        let result = match operation {
            None => Err((Reason::UnknownOperation, request.value)),
            Some(_) if remembered && !self.parameters_answered.has_room_for(1) => {
                Err((Reason::TooManyCommands, request.value))
            }
            Some(Operation::Save | Operation::EraseRecord) => {
                match self.begin_saving(&request, out) {
                    // answered when the board has stored
                    Ok(()) => return,
                    Err(refusal) => Err(refusal),
                }
            }
            Some(operation) => self.parameter(now_ms, operation, &request),
        };
        let answer = self.answer_parameter_with(&request, result, out);
        if remembered && answer.code != Reason::TooManyCommands {
            self.parameters_answered.note(now_ms, request, answer);
        }
    }

    /// Does what is asked for at once. The value of the answer, or the reason and a value that says more.
    fn parameter(
        &mut self,
        now_ms: u32,
        operation: Operation,
        request: &ParameterRequest,
    ) -> Result<u32, (Reason, u32)> {
        let plain = |reason| (reason, request.value);
        let entry = || find(request.index).map(|(_, entry)| entry).ok_or(plain(Reason::UnknownParameter));
        match operation {
            Operation::Read => self.read(&self.in_use, request.index).map_err(plain),
            Operation::ReadPrepared => self.read(&self.prepared, request.index).map_err(plain),
            Operation::ReadDefault => entry().map(|entry| entry.default),
            Operation::ReadMinimum => entry().map(|entry| entry.minimum),
            Operation::ReadMaximum => entry().map(|entry| entry.maximum),
            Operation::List => {
                next(request.index).map(|entry| u32::from(entry.index)).ok_or(plain(Reason::UnknownParameter))
            }
            Operation::Write => self.write(request).map(|()| request.value).map_err(plain),
            Operation::Check => self.check().map(|()| 0),
            Operation::Discard => {
                self.prepared = self.in_use;
                Ok(0)
            }
            Operation::Reset => {
                if !self.lock.is_open() {
                    return Err(plain(Reason::Locked));
                }
                self.prepared = self.in_use.reset();
                Ok(0)
            }
            Operation::Challenge => Ok(self.lock.challenge(now_ms, self.boot)),
            Operation::Unlock => {
                if self.lock.open(now_ms, request.value) {
                    Ok(0)
                } else {
                    Err((Reason::WrongKey, 0))
                }
            }
            Operation::Lock => {
                self.lock.close();
                Ok(0)
            }
            // answered by their own way
            Operation::Save | Operation::EraseRecord => Err(plain(Reason::UnknownOperation)),
        }
    }

    fn read(&self, set: &ParameterSet, index: u16) -> Result<u32, Reason> {
        if is_write_only(index) {
            return Err(Reason::WriteOnly);
        }
        set.bits(index).ok_or(Reason::UnknownParameter)
    }

    fn write(&mut self, request: &ParameterRequest) -> Result<(), Reason> {
        let (place, entry) = find(request.index).ok_or(Reason::UnknownParameter)?;
        if entry.guarded && !self.lock.is_open() {
            return Err(Reason::Locked);
        }
        self.prepared.set_bits(request.index, request.value)?;
        if place == Key::TelemetryRate as usize {
            // nothing goes by it but what is sent: it acts at once
            self.telemetry_out.set_period(sets::period_ms(request.value as u16));
        }
        Ok(())
    }

    /// Do the prepared values fit each other?
    fn check(&self) -> Result<(), (Reason, u32)> {
        match self.prepared.config(Restart::default(), self.serial) {
            Ok(_) => Ok(()),
            Err(contradiction) => Err((Reason::ParametersContradict, u32::from(contradiction.index))),
        }
    }

    fn begin_saving(&mut self, request: &ParameterRequest, out: &mut impl FnMut(Action)) -> Result<(), (Reason, u32)> {
        if self.saving != Saving::Nothing {
            return Err((Reason::Busy, 0));
        }
        if !matches!(self.procedure.state(), StateName::Idle | StateName::Failed) {
            return Err((Reason::AlreadyRunning, 0));
        }
        if request.operation == Operation::EraseRecord as u8 {
            if !self.lock.is_open() {
                return Err((Reason::Locked, 0));
            }
            self.saving = Saving::Storing(*request);
            out(Action::EraseRecord);
        } else {
            self.check()?;
            // The board starts anew when it has saved; a centre that could not be stored would be gone.
            if let Some(reason) = self.persistence.wrong.filter(|_| self.procedure.live().is_some()) {
                return Err((reason, 0));
            }
            self.saving = Saving::Storing(*request);
            out(Action::StoreParameters(self.prepared));
        }
        Ok(())
    }

    /// The board has stored the parameters, or erased the record: the device starts anew, so that nothing ever goes by
    /// half of an old set and half of a new one.
    pub(super) fn parameters_stored(
        &mut self,
        now_ms: u32,
        result: Result<(), StoreError>,
        out: &mut impl FnMut(Action),
    ) {
        let Saving::Storing(request) = self.saving else { return };
        self.saving = if result.is_ok() { Saving::Stored(now_ms) } else { Saving::Nothing };
        let result = result.map(|()| 0).map_err(|error| (reason_of_store(error), 0));
        let answer = self.answer_parameter_with(&request, result, out);
        if request.nonce != 0 {
            self.parameters_answered.note(now_ms, request, answer);
        }
    }

    pub(super) fn restart_when_saved(&mut self, now_ms: u32, out: &mut impl FnMut(Action)) {
        if let Saving::Stored(at_ms) = self.saving
            && now_ms.wrapping_sub(at_ms) >= RESTART_AFTER_MS
        {
            self.saving = Saving::Nothing;
            out(Action::Stop(ResetCause::Requested));
        }
    }

    fn answer_parameter(
        &mut self,
        request: &ParameterRequest,
        result: Result<u32, Reason>,
        out: &mut impl FnMut(Action),
    ) {
        self.answer_parameter_with(request, result.map_err(|reason| (reason, request.value)), out);
    }

    fn answer_parameter_with(
        &mut self,
        request: &ParameterRequest,
        result: Result<u32, (Reason, u32)>,
        out: &mut impl FnMut(Action),
    ) -> ParameterAnswer {
        let ParameterRequest { operation, index, nonce, .. } = *request;
        let (code, value) = result.map_or_else(|refusal| refusal, |value| (Reason::Fine, value));
        // the key is not sent back
        let value = if operation == Operation::Write as u8 && is_write_only(index) { 0 } else { value };
        let answer = ParameterAnswer { operation, index, nonce, code, value };
        self.send(&Message::Parameter(answer), out);
        answer
    }
}

/// The key of the lock is for nobody to read.
fn is_write_only(index: u16) -> bool {
    let first = Key::LockKey1 as usize;
    find(index).is_some_and(|(place, _)| (first..first + 4).contains(&place))
}
