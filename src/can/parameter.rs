//! The two messages by which parameters are read and set: a request of a client, and the device's answer.

use super::frame::Frame;
use super::payload::{Field, Payload};
use crate::procedure::Reason;

/// What is to be done with a parameter, or with all of them. The numbers go over CAN and are never renumbered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Operation {
    /// Send the value in use.
    Read = 1,
    /// Put a value into the set that is being prepared.
    Write = 2,
    /// Send the value in the set that is being prepared.
    ReadPrepared = 3,
    /// Send the first index that is assigned, from this one on, as an integer.
    List = 4,
    /// Send the default, the smallest and the largest value.
    ReadDefault = 5,
    /// See [`Operation::ReadDefault`].
    ReadMinimum = 6,
    /// See [`Operation::ReadDefault`].
    ReadMaximum = 7,
    /// Check the prepared set as a whole, store it, and start anew with it.
    Save = 8,
    /// The prepared set becomes the one in use.
    Discard = 9,
    /// The prepared set becomes the defaults; the lock's key stays.
    Reset = 10,
    /// Send a number that the answer to the lock is formed from.
    Challenge = 11,
    /// Open the lock with that answer.
    Unlock = 12,
    /// Close the lock.
    Lock = 13,
    /// Check the prepared set without storing it.
    Check = 14,
    /// Erase the record of the centre in use.
    EraseRecord = 15,
}

impl Operation {
    /// All operations, in the order of the numbers.
    pub const ALL: [Self; 15] = [
        Self::Read,
        Self::Write,
        Self::ReadPrepared,
        Self::List,
        Self::ReadDefault,
        Self::ReadMinimum,
        Self::ReadMaximum,
        Self::Save,
        Self::Discard,
        Self::Reset,
        Self::Challenge,
        Self::Unlock,
        Self::Lock,
        Self::Check,
        Self::EraseRecord,
    ];

    /// The operation with this number.
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|operation| *operation as u8 == code)
    }

    /// Does it change nothing? Then it may be asked again at once.
    pub const fn is_query(self) -> bool {
        matches!(
            self,
            Self::Read
                | Self::ReadPrepared
                | Self::List
                | Self::ReadDefault
                | Self::ReadMinimum
                | Self::ReadMaximum
                | Self::Check
        )
    }
}

const OPERATION: Field = Field::integer(0, 4);
const INDEX: Field = Field::integer(4, 12);
const NONCE: Field = Field::integer(16, 8);
/// Of a request 0, of an answer the code.
const CODE: Field = Field::integer(24, 8);
const VALUE: Field = Field::integer(32, 32);

/// A request about parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ParameterRequest {
    /// The operation as it was sent, known or not: the answer repeats it.
    pub operation: u8,
    /// Index of the parameter, 0 where none is meant.
    pub index: u16,
    /// Chosen by the client; the answer repeats it. 0 = no nonce.
    pub nonce: u8,
    /// The bits of the value: an IEEE single or an unsigned integer, as the parameter's type says.
    pub value: u32,
}

impl ParameterRequest {
    /// The frame of this request, for clients and tests.
    pub fn pack(&self, id: embedded_can::StandardId) -> Frame {
        let payload = Payload::new()
            .with(OPERATION, self.operation)
            .with(INDEX, self.index)
            .with(NONCE, self.nonce)
            .with(VALUE, self.value);
        Frame::of_eight(id, payload.to_bytes())
    }

    /// Takes a request's bytes apart.
    ///
    /// # Errors
    /// The request as far as it could be read, with [`Reason::WrongLength`] or [`Reason::ReservedNotZero`].
    pub fn unpack(data: &[u8]) -> Result<Self, (Self, Reason)> {
        let (payload, is_whole) = Payload::of_data(data);
        let request = Self {
            operation: payload.get_u8(OPERATION),
            index: payload.get_u16(INDEX),
            nonce: payload.get_u8(NONCE),
            value: payload.get(VALUE),
        };
        if !is_whole {
            Err((request, Reason::WrongLength))
        } else if payload.get(CODE) != 0 {
            Err((request, Reason::ReservedNotZero))
        } else {
            Ok(request)
        }
    }
}

/// The answer to a request about parameters. Every request gets exactly one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ParameterAnswer {
    /// The operation, repeated.
    pub operation: u8,
    /// The index, repeated.
    pub index: u16,
    /// The nonce, repeated.
    pub nonce: u8,
    /// [`Reason::Fine`] when the request was obeyed.
    pub code: Reason,
    /// The bits of the value after the request; with a refusal of the set its detail.
    pub value: u32,
}

impl ParameterAnswer {
    pub(super) fn pack(&self) -> Payload {
        Payload::new()
            .with(OPERATION, self.operation)
            .with(INDEX, self.index)
            .with(NONCE, self.nonce)
            .with(CODE, self.code.code())
            .with(VALUE, self.value)
    }

    pub(super) fn unpack(payload: Payload) -> Option<Self> {
        Some(Self {
            operation: payload.get_u8(OPERATION),
            index: payload.get_u16(INDEX),
            nonce: payload.get_u8(NONCE),
            code: Reason::from_code(payload.get_u8(CODE))?,
            value: payload.get(VALUE),
        })
    }
}
