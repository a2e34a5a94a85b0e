//! The eight bytes of a frame as one little-endian number that fields are put into and taken from.

use super::frame::MAX_DATA_LEN;
use super::rounding::{Scale, from_raw, mask, to_raw};

/// Why a message cannot be packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum PackError {
    /// A value is NaN or infinite or does not fit its field.
    OutOfRange = 1,
}

impl core::fmt::Display for PackError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("a value is no number or does not fit its field")
    }
}

impl core::error::Error for PackError {}

/// A signal of the DBC: where it starts (bit 0 is the lowest of byte 0, Intel byte order) and how it is scaled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Field {
    start: u8,
    scale: Scale,
}

impl Field {
    /// A plain unsigned integer.
    pub const fn integer(start: u8, bits: u8) -> Self {
        Self { start, scale: Scale::unsigned(bits, 0) }
    }

    /// A physical value.
    pub const fn scaled(start: u8, scale: Scale) -> Self {
        Self { start, scale }
    }
}

/// The run id stands in the first two bytes of every report of a run.
pub(super) const RUN: Field = Field::integer(0, 16);

/// The content of an 8-byte frame.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Payload(u64);

impl Payload {
    /// All bits zero.
    pub const fn new() -> Self {
        Self(0)
    }

    /// The eight bytes as they lie in the frame.
    pub const fn from_bytes(bytes: [u8; 8]) -> Self {
        Self(u64::from_le_bytes(bytes))
    }

    /// What a frame carries, with zeros for bytes that are missing; false when it has not eight.
    pub fn of_data(data: &[u8]) -> (Self, bool) {
        let mut bytes = [0; MAX_DATA_LEN];
        for (target, source) in bytes.iter_mut().zip(data) {
            *target = *source;
        }
        (Self::from_bytes(bytes), data.len() == MAX_DATA_LEN)
    }

    /// The eight bytes as they go into the frame.
    pub const fn to_bytes(self) -> [u8; 8] {
        self.0.to_le_bytes()
    }

    /// Puts the low bits of an integer into a field that is still zero. The caller's type is as wide as the field.
    pub fn with(self, field: Field, raw: impl Into<u32>) -> Self {
        let raw = raw.into() & mask(field.scale.bits);
        Self(self.0 | u64::from(raw) << field.start)
    }

    /// Puts a physical value into a field that is still zero.
    ///
    /// # Errors
    /// [`PackError::OutOfRange`] when the value is no number or does not fit.
    pub fn with_value(self, field: Field, value: f32) -> Result<Self, PackError> {
        let raw = to_raw(value, field.scale).ok_or(PackError::OutOfRange)?;
        Ok(self.with(field, raw))
    }

    /// Puts a value that may be missing, and the bit that says whether it is there.
    ///
    /// # Errors
    /// [`PackError::OutOfRange`] when the value is there and is no number or does not fit.
    pub fn with_optional(self, known: Field, field: Field, value: Option<f32>) -> Result<Self, PackError> {
        match value {
            Some(value) => self.with(known, true).with_value(field, value),
            None => Ok(self),
        }
    }

    /// The integer in a field.
    pub fn get(self, field: Field) -> u32 {
        (self.0 >> field.start) as u32 & mask(field.scale.bits)
    }

    /// The integer in a field of at most 8 bits.
    pub fn get_u8(self, field: Field) -> u8 {
        self.get(field) as u8
    }

    /// The integer in a field of at most 16 bits.
    pub fn get_u16(self, field: Field) -> u16 {
        self.get(field) as u16
    }

    /// The flag in a field of one bit.
    pub fn get_flag(self, field: Field) -> bool {
        self.get(field) != 0
    }

    /// The physical value in a field.
    pub fn get_value(self, field: Field) -> f32 {
        from_raw(self.get(field), field.scale)
    }

    /// The value in a field if the other field says that it is there.
    pub fn get_optional(self, known: Field, field: Field) -> Option<f32> {
        self.get_flag(known).then(|| self.get_value(field))
    }
}
