//! Constants that a function puts together in a register, half by half.

use std::collections::BTreeMap;

/// What the instructions gone through so far have put together.
#[derive(Debug, Default)]
pub struct Constants {
    /// The lower half that each register got last. The compiler keeps the two instructions together, in this order.
    lower: BTreeMap<u8, u16>,
    whole: Vec<u32>,
}

impl Constants {
    /// A register gets this lower half, and zeros above.
    pub fn lower_half(&mut self, register: u8, value: u16) {
        self.lower.insert(register, value);
    }

    /// A register gets this upper half.
    pub fn upper_half(&mut self, register: u8, value: u16) {
        let lower = self.lower.get(&register).copied().unwrap_or_default();
        self.whole.push(u32::from(value) << 16 | u32::from(lower));
    }

    /// All constants of two halves. A lower half alone is a number: the compiler does not know where a function will lie, so
    /// that it always puts an address together of both (relocations `R_ARM_THM_MOVW_ABS_NC` and `R_ARM_THM_MOVT_ABS`).
    pub fn all(self) -> impl Iterator<Item = u32> {
        self.whole.into_iter()
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
        assert_eq!(constants.all().collect::<Vec<_>>(), [0x0001_1BE9, 0x0800_1BE9]);
    }

    #[test]
    fn an_address_in_the_first_64_kib_has_an_upper_half_of_zeros() {
        let mut constants = Constants::default();
        constants.lower_half(3, 0x1BE9);
        constants.lower_half(3, 0x2BE9);
        constants.upper_half(3, 0);
        constants.upper_half(4, 0x0800);
        assert_eq!(constants.all().collect::<Vec<_>>(), [0x2BE9, 0x0800_0000]);
    }
}
