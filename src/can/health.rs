//! Messages about the health of the board: the bus, and how the firmware stopped the last time.

use super::payload::{Field, Payload};
use crate::restart::{CrashRecord, ResetCause, TEXT_LEN};

/// How the board's CAN controller fares.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BusHealth {
    /// How often the controller had left the bus because of too many errors, and came back. Stops at its largest value.
    pub bus_off: u16,
    /// Frames that were not sent because nobody took them. Stops at its largest value.
    pub dropped: u16,
    /// Transmit error counter (ISO 11898-1), 0 to 255.
    pub transmit_errors: u8,
    /// Receive error counter (ISO 11898-1), 0 to 127.
    pub receive_errors: u8,
    /// The controller may only watch for errors, not signal them: one of the counters is past 127.
    pub error_passive: bool,
}

mod bus {
    use super::Field;
    pub(super) const BUS_OFF: Field = Field::integer(0, 16);
    pub(super) const DROPPED: Field = Field::integer(16, 16);
    pub(super) const TRANSMIT_ERRORS: Field = Field::integer(32, 8);
    pub(super) const RECEIVE_ERRORS: Field = Field::integer(40, 8);
    pub(super) const ERROR_PASSIVE: Field = Field::integer(48, 1);
}

impl BusHealth {
    pub(super) fn pack(&self) -> Payload {
        Payload::new()
            .with(bus::BUS_OFF, self.bus_off)
            .with(bus::DROPPED, self.dropped)
            .with(bus::TRANSMIT_ERRORS, self.transmit_errors)
            .with(bus::RECEIVE_ERRORS, self.receive_errors)
            .with(bus::ERROR_PASSIVE, self.error_passive)
    }

    pub(super) fn unpack(payload: Payload) -> Self {
        Self {
            bus_off: payload.get_u16(bus::BUS_OFF),
            dropped: payload.get_u16(bus::DROPPED),
            transmit_errors: payload.get_u8(bus::TRANSMIT_ERRORS),
            receive_errors: payload.get_u8(bus::RECEIVE_ERRORS),
            error_passive: payload.get_flag(bus::ERROR_PASSIVE),
        }
    }
}

/// Why and where the firmware stopped before this start. [`StopText`]s follow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LastStop {
    /// Why.
    pub cause: ResetCause,
    /// Length of the text, bytes.
    pub text_len: u8,
    /// Line of the source, 0 when not known.
    pub line: u16,
    /// Address of the instruction, 0 when not known.
    pub address: u32,
}

mod stop {
    use super::Field;
    pub(super) const CAUSE: Field = Field::integer(0, 8);
    pub(super) const TEXT_LEN: Field = Field::integer(8, 8);
    pub(super) const LINE: Field = Field::integer(16, 16);
    pub(super) const ADDRESS: Field = Field::integer(32, 32);
}

impl LastStop {
    /// What the words say besides their text.
    pub fn of(words: &CrashRecord) -> Self {
        // a text is never longer than a byte counts
        let text_len = words.text().len() as u8;
        Self { cause: words.cause, text_len, line: words.line, address: words.address }
    }

    pub(super) fn pack(&self) -> Payload {
        Payload::new()
            .with(stop::CAUSE, self.cause.code())
            .with(stop::TEXT_LEN, self.text_len)
            .with(stop::LINE, self.line)
            .with(stop::ADDRESS, self.address)
    }

    pub(super) fn unpack(payload: Payload) -> Option<Self> {
        Some(Self {
            cause: ResetCause::from_code(payload.get_u8(stop::CAUSE))?,
            text_len: payload.get_u8(stop::TEXT_LEN),
            line: payload.get_u16(stop::LINE),
            address: payload.get(stop::ADDRESS),
        })
    }
}

/// Seven characters of the crash record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct StopText {
    /// Which part of the text, from 0.
    pub index: u8,
    /// ASCII; 0 past the end.
    pub text: [u8; Self::LEN],
}

mod stop_text {
    use super::{Field, StopText};
    pub(super) const INDEX: Field = Field::integer(0, 8);
    pub(super) const CHARACTERS: [Field; StopText::LEN] = [
        Field::integer(8, 8),
        Field::integer(16, 8),
        Field::integer(24, 8),
        Field::integer(32, 8),
        Field::integer(40, 8),
        Field::integer(48, 8),
        Field::integer(56, 8),
    ];
}

impl StopText {
    /// Characters of a part.
    pub const LEN: usize = 7;
    /// Parts of the longest text.
    pub const MAX_PARTS: u8 = TEXT_LEN.div_ceil(Self::LEN) as u8;

    /// A part of the text; None past its end.
    pub fn of(words: &CrashRecord, index: u8) -> Option<Self> {
        let part = words.text().as_bytes().chunks(Self::LEN).nth(usize::from(index))?;
        let mut text = [0; Self::LEN];
        for (place, byte) in text.iter_mut().zip(part) {
            *place = *byte;
        }
        Some(Self { index, text })
    }

    pub(super) fn pack(&self) -> Payload {
        let payload = Payload::new().with(stop_text::INDEX, self.index);
        stop_text::CHARACTERS
            .into_iter()
            .zip(self.text)
            .fold(payload, |payload, (field, byte)| payload.with(field, byte))
    }

    pub(super) fn unpack(payload: Payload) -> Self {
        Self { index: payload.get_u8(stop_text::INDEX), text: stop_text::CHARACTERS.map(|field| payload.get_u8(field)) }
    }
}
