//! Messages on their way out, and whose they are.

use super::{Action, Device};
use crate::can::Message;
use crate::can::identity::Identity;

impl Device {
    /// Sends a message; a value that does not fit becomes a fault instead of a number.
    pub(super) fn send(&mut self, message: &Message, out: &mut impl FnMut(Action)) {
        match message.pack(self.base) {
            Ok(frame) => out(Action::Send(frame)),
            Err(_) => {
                self.reporter.spoil();
                self.note_unsendable();
            }
        }
    }

    pub(super) fn note_unsendable(&mut self) {
        self.counters.unsendable = self.counters.unsendable.saturating_add(1);
        self.unsendable.happened(1);
    }

    /// Which board, which boot, whose arm.
    pub(super) fn identity(&self) -> Identity {
        // modulo 2^16
        Identity { serial: self.serial, boot: self.boot as u16, wearer: self.procedure.wearer() }
    }
}
