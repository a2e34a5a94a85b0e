//! Requests about parameters.

use super::{Action, Device};
use crate::can::{Frame, Message, ParameterAnswer, ParameterRequest};
use crate::procedure::Reason;

impl Device {
    pub(super) fn receive_parameter_request(&mut self, _now_ms: u32, frame: &Frame, out: &mut impl FnMut(Action)) {
        let (request, code) = match ParameterRequest::unpack(frame.data()) {
            Ok(request) => (request, Reason::UnknownOperation),
            Err((request, reason)) => (request, reason),
        };
        let ParameterRequest { operation, index, nonce, value } = request;
        self.send(&Message::Parameter(ParameterAnswer { operation, index, nonce, code, value }), out);
    }
}
