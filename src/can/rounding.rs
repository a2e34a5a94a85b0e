//! The one way in which a measured or computed number becomes an integer of a CAN frame.
//!
//! Every scale is a power of two. Scaling an `f32` by it is exact, so the only loss is the one rounding that the
//! frame's resolution asks for, and a client that computes in another precision gets the same integer.

use crate::scalar::rounded;

/// How an integer field of a frame stands for a physical value: `value = raw * 2^exponent`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scale {
    /// Width of the integer, 1 to 32 bits.
    pub bits: u8,
    /// Two's complement when true.
    pub signed: bool,
    /// Power of two of one step, -30 to 30.
    pub exponent: i8,
}

impl Scale {
    /// An unsigned field of `bits` bits with steps of `2^exponent`.
    pub const fn unsigned(bits: u8, exponent: i8) -> Self {
        Self { bits, signed: false, exponent }
    }

    /// A two's complement field of `bits` bits with steps of `2^exponent`.
    pub const fn signed(bits: u8, exponent: i8) -> Self {
        Self { bits, signed: true, exponent }
    }

    /// The physical value of one step.
    pub fn step(self) -> f32 {
        power_of_two(self.exponent)
    }
}

/// `2^exponent` for -126 to 127, exactly: the exponent field of an IEEE 754 single.
fn power_of_two(exponent: i8) -> f32 {
    let biased = (i32::from(exponent) + 127).clamp(1, 254) as u32;
    f32::from_bits(biased << 23)
}

/// The integer that stands for `value`, in the low `scale.bits` bits; halves are rounded away from zero.
///
/// None when the value is NaN or infinite or does not fit: such a value must be reported as a fault and never as a
/// number.
pub fn to_raw(value: f32, scale: Scale) -> Option<u32> {
    let steps = rounded(value * power_of_two(scale.exponent.saturating_neg()));
    // 2^bits or 2^(bits-1) itself is representable, the largest integer below it may not be: compare with `<`.
    let (low, end) = if scale.signed {
        let half = power_of_two(scale.bits as i8 - 1);
        (-half, half)
    } else {
        (0.0, power_of_two(scale.bits as i8))
    };
    // NaN fails both comparisons
    if !(steps >= low && steps < end) {
        return None;
    }
    let raw = if scale.signed { (steps as i32) as u32 } else { steps as u32 };
    Some(raw & mask(scale.bits))
}

/// The physical value that the low `scale.bits` bits of `raw` stand for, rounded to a single: beyond 24 bits the field
/// has more digits than that.
pub fn from_raw(raw: u32, scale: Scale) -> f32 {
    let raw = raw & mask(scale.bits);
    let steps = if scale.signed {
        let unused = 32u32.saturating_sub(u32::from(scale.bits));
        // shift up to the sign bit and back: extends the sign
        ((raw.wrapping_shl(unused) as i32).wrapping_shr(unused)) as f32
    } else {
        raw as f32
    };
    steps * scale.step()
}

/// The low `bits` bits set.
pub(super) const fn mask(bits: u8) -> u32 {
    if bits >= 32 { u32::MAX } else { (1 << bits) - 1 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_go_away_from_zero() {
        let scale = Scale::signed(16, -1);
        // steps of 0.5: 0.25 lies half way
        assert_eq!(to_raw(0.25, scale), Some(1));
        assert_eq!(to_raw(-0.25, scale), Some(0xFFFF));
        assert_eq!(to_raw(0.24, scale), Some(0));
    }

    #[test]
    fn what_is_no_number_has_no_integer() {
        for scale in [Scale::signed(16, -4), Scale::unsigned(32, -20)] {
            for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN] {
                assert_eq!(to_raw(value, scale), None, "{value} {scale:?}");
            }
        }
        assert_eq!(to_raw(-0.51, Scale::unsigned(8, 0)), None);
    }

    #[test]
    fn the_ends_of_the_range() {
        let signed = Scale::signed(8, 0);
        assert_eq!(to_raw(127.49, signed), Some(127));
        assert_eq!(to_raw(127.5, signed), None);
        assert_eq!(to_raw(-128.49, signed), Some(0x80));
        assert_eq!(to_raw(-128.5, signed), None);
        let unsigned = Scale::unsigned(32, 0);
        assert_eq!(to_raw(4_294_967_040.0, unsigned), Some(0xFFFF_FF00));
        assert_eq!(to_raw(4_294_967_296.0, unsigned), None);
    }

    #[test]
    fn a_signed_integer_comes_back_with_its_sign() {
        for (bits, raw, value) in [(4, 0x8, -8.0), (28, 0x0FFF_FFFF, -1.0), (32, 0x8000_0000, -2_147_483_648.0)] {
            assert_eq!(from_raw(raw, Scale::signed(bits, 0)), value);
        }
        assert_eq!(from_raw(0xFF, Scale::unsigned(8, -1)), 127.5);
    }

    #[test]
    fn a_single_survives_the_way_there_and_back() {
        // 28 bits of 2^-17 mm hold a distance of 64 to 1024 mm to the bit.
        let scale = Scale::signed(28, -17);
        let mut value = 64.0_f32;
        while value < 1023.0 {
            assert_eq!(to_raw(value, scale).map(|raw| from_raw(raw, scale)), Some(value));
            value = f32::from_bits(value.to_bits() + 7919);
        }
    }
}
