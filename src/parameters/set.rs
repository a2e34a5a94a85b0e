//! A whole set of values.

use super::table::{COUNT, Entry, Key, Kind, TABLE};
use crate::procedure::Reason;

/// One value for every parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ParameterSet {
    values: [u32; COUNT],
}

impl ParameterSet {
    /// The defaults: the shoulder of Table I.
    pub fn new() -> Self {
        let mut values = [0; COUNT];
        for (value, entry) in values.iter_mut().zip(TABLE) {
            *value = entry.default;
        }
        Self { values }
    }

    /// The value with this index, as its bits.
    pub fn bits(&self, index: u16) -> Option<u32> {
        let (place, _) = find(index)?;
        self.values.get(place).copied()
    }

    /// The bits of all values in the order of the table.
    pub(crate) const fn all(&self) -> &[u32; COUNT] {
        &self.values
    }

    /// Sets the value with this index.
    ///
    /// # Errors
    /// [`Reason::UnknownParameter`], [`Reason::ParameterOutOfRange`]; nothing has changed then.
    pub fn set_bits(&mut self, index: u16, bits: u32) -> Result<(), Reason> {
        let (place, entry) = find(index).ok_or(Reason::UnknownParameter)?;
        let fits = match entry.kind {
            // false for what is no number
            Kind::Single => {
                let value = f32::from_bits(bits);
                value >= f32::from_bits(entry.minimum) && value <= f32::from_bits(entry.maximum)
            }
            Kind::Integer => (entry.minimum..=entry.maximum).contains(&bits),
        };
        if !fits {
            return Err(Reason::ParameterOutOfRange);
        }
        if let Some(value) = self.values.get_mut(place) {
            *value = bits;
        }
        Ok(())
    }

    /// The value of a parameter that is a single.
    pub fn single(&self, key: Key) -> f32 {
        f32::from_bits(self.raw(key))
    }

    /// The value of a parameter that is an integer.
    pub fn integer(&self, key: Key) -> u32 {
        self.raw(key)
    }

    /// Sets a parameter that is a single, whatever its range.
    pub(super) fn put_single(&mut self, key: Key, value: f32) {
        self.put_integer(key, value.to_bits());
    }

    /// Sets a parameter that is an integer, whatever its range.
    pub(super) fn put_integer(&mut self, key: Key, value: u32) {
        if let Some(place) = self.values.get_mut(key as usize) {
            *place = value;
        }
    }

    /// The defaults with the key of the lock of this set.
    pub fn reset(&self) -> Self {
        let mut defaults = Self::new();
        for key in super::LOCK_KEYS {
            defaults.put_integer(key, self.raw(key));
        }
        defaults
    }

    fn raw(&self, key: Key) -> u32 {
        self.values.get(key as usize).copied().unwrap_or_default()
    }
}

impl Default for ParameterSet {
    fn default() -> Self {
        Self::new()
    }
}

/// The parameter with this index, and its place in the table.
pub fn find(index: u16) -> Option<(usize, &'static Entry)> {
    let place = TABLE.partition_point(|entry| entry.index < index);
    let entry = TABLE.get(place).filter(|entry| entry.index == index)?;
    Some((place, entry))
}

/// The first parameter with this index or a larger one.
pub fn next(index: u16) -> Option<&'static Entry> {
    TABLE.get(TABLE.partition_point(|entry| entry.index < index))
}
