//! Constants that a function puts together in a register, half by half.

use std::collections::BTreeMap;

/// What the instructions gone through so far have put together.
#[derive(Debug, Default)]
pub struct Constants {
    /// The lower half that each register got last, and whether an upper half has come to it. The compiler keeps the two
    /// instructions together, in this order.
    lower: BTreeMap<u8, (u16, bool)>,
    whole: Vec<u32>,
}

impl Constants {
    /// A register gets this lower half, and zeros above.
    pub fn lower_half(&mut self, register: u8, value: u16) {
        if let Some((before, false)) = self.lower.insert(register, (value, false)) {
            self.whole.push(before.into());
        }
    }

    /// A register gets this upper half.
    pub fn upper_half(&mut self, register: u8, value: u16) {
        let (lower, is_joined) = self.lower.entry(register).or_default();
        *is_joined = true;
        self.whole.push(u32::from(value) << 16 | u32::from(*lower));
    }

    /// All constants. A lower half that no upper half came to is one: an address in the first 64 KiB needs none.
    pub fn all(self) -> impl Iterator<Item = u32> {
        let alone = self.lower.into_values().filter(|(_, is_joined)| !is_joined).map(|(value, _)| value.into());
        self.whole.into_iter().chain(alone)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_halves_are_one_constant() {
        let mut constants = Constants::default();
        constants.lower_half(3, 0x1BE9);
        constants.lower_half(4, 0x0001);
        constants.upper_half(3, 0x0001);
        // the same lower half with another upper one
        constants.upper_half(3, 0x0800);
        assert_eq!(constants.all().collect::<Vec<_>>(), [0x0001_1BE9, 0x0800_1BE9, 0x0001]);
    }

    #[test]
    fn a_lower_half_alone_is_a_constant() {
        let mut constants = Constants::default();
        constants.lower_half(3, 0x1BE9);
        constants.lower_half(3, 0x2BE9);
        constants.upper_half(4, 0x0800);
        assert_eq!(constants.all().collect::<Vec<_>>(), [0x1BE9, 0x0800_0000, 0x2BE9]);
    }
}
