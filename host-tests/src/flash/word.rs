//! One word of flash, whole or torn.

use rand::Rng;

/// What a word reads as whose writing or erasing was cut short.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TornWord {
    /// Some of the bits have changed, some have not; the reading is the same every time.
    PartialBits,
    /// Zeros: a driver that maps an error of the error correcting code to data.
    Zeros,
    /// Some bits read differently each time.
    Unsteady,
    /// The reading fails: a driver that passes the error on.
    Error,
}

impl TornWord {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::PartialBits, Self::Zeros, Self::Unsteady, Self::Error];
}

/// A word.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Word {
    bits: u64,
    /// Bits that read differently each time.
    unsteady: u64,
    unreadable: bool,
}

impl Word {
    pub const ERASED: Self = Self::written(u64::MAX);

    pub const fn written(bits: u64) -> Self {
        Self { bits, unsteady: 0, unreadable: false }
    }

    /// Writing is allowed: nothing was written here, as far as the flash's own check can tell.
    pub fn is_erased(&self) -> bool {
        *self == Self::ERASED
    }

    pub fn flip(&mut self, bits: u64) {
        self.bits ^= bits;
    }

    /// An erased word whose writing was cut short.
    pub fn torn_in_writing(value: u64, torn: TornWord, random: &mut impl Rng) -> Self {
        Self::ERASED.torn(value, torn, random)
    }

    /// An erase of the word's page was cut short.
    pub fn tear_in_erasing(&mut self, torn: TornWord, random: &mut impl Rng) {
        *self = self.torn(u64::MAX, torn, random);
    }

    /// On the way from one value to another.
    fn torn(self, to: u64, torn: TornWord, random: &mut impl Rng) -> Self {
        let changing = self.bits ^ to;
        let changed = self.bits ^ (changing & any_of(random));
        match torn {
            // it may have been cut just before the first change, or just after the last
            _ if random.random_bool(0.1) => self,
            _ if random.random_bool(0.1) => Self::written(to),
            TornWord::PartialBits => Self { bits: changed, ..self },
            TornWord::Zeros => Self::written(0),
            TornWord::Unsteady => Self { bits: changed, unsteady: self.unsteady | changing & any_of(random), ..self },
            TornWord::Error => Self { unreadable: true, ..self },
        }
    }

    pub fn read(&self, random: &mut impl Rng) -> Option<u64> {
        (!self.unreadable).then(|| self.bits ^ (self.unsteady & random.random::<u64>()))
    }
}

/// A mask of few, of half or of most of the bits: a single unsteady bit is as bad as many.
fn any_of(random: &mut impl Rng) -> u64 {
    match random.random_range(0..3) {
        0 => 1 << random.random_range(0..u64::BITS),
        1 => random.random(),
        _ => !(1 << random.random_range(0..u64::BITS)),
    }
}
