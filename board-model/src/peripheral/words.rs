//! The cells of the flash: double words with their error-correcting code, and what a power cut makes of them.

use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// Bytes of a double word.
pub const WORD_LEN: u32 = 8;
/// Double words of a page.
pub const PAGE_WORDS: usize = 256;

/// One double word.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Word {
    /// Erased: reads as ones, and may be programmed.
    Erased,
    /// Programmed.
    Whole(u64),
    /// An operation on it was cut short: it reads differently each time, at times beyond correction.
    Torn,
    /// Its code does not match: beyond correction each time.
    Broken(u64),
}

impl Word {
    /// Reads it: the bits, and whether they could not be corrected.
    pub fn read(self, random: &mut ChaCha8Rng) -> (u64, bool) {
        match self {
            Self::Erased => (u64::MAX, false),
            Self::Whole(bits) => (bits, false),
            Self::Torn => (random.random(), random.random_bool(0.5)),
            Self::Broken(bits) => (bits, true),
        }
    }

    /// What programming it leaves when the power fails in it.
    pub fn torn_in_programming(target: u64, random: &mut ChaCha8Rng) -> Self {
        match random.random_range(0..4) {
            0 => Self::Erased,
            1 => Self::Whole(target),
            2 => Self::Torn,
            _ => Self::Broken(random.random()),
        }
    }

    /// What erasing it leaves when the power fails in it.
    pub fn torn_in_erasing(self, random: &mut ChaCha8Rng) -> Self {
        match random.random_range(0..4) {
            0 => self,
            1 => Self::Erased,
            2 => Self::Torn,
            _ => Self::Broken(random.random()),
        }
    }

    /// What a chip holds that was used for something else before.
    pub fn noise(random: &mut ChaCha8Rng) -> Self {
        match random.random_range(0..4) {
            0 => Self::Erased,
            1 => Self::Broken(random.random()),
            2 => Self::Torn,
            _ => Self::Whole(random.random()),
        }
    }
}
