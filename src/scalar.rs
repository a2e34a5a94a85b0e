//! The number type of the numerical modules: `f32` on the target, `f64` on the host for reference.

mod sine;

use nalgebra::RealField;

/// A real number with the few operations that the numerical modules need beyond nalgebra's.
pub trait Real: RealField + Copy {
    /// A constant of the source text in this precision. `T::of(0.5)` is folded at compile time.
    fn of(value: f64) -> Self;

    /// A number within ±1, kept in as little memory as its use allows: 16 bits on the target, where a hundredth of a
    /// degree is enough; in double precision in full.
    type Fraction: Copy + core::fmt::Debug + PartialEq;

    /// A number within ±1, to be kept.
    fn to_fraction(self) -> Self::Fraction;

    /// A number that was kept.
    fn of_fraction(fraction: Self::Fraction) -> Self;

    /// An integer, rounded to the nearest number. No double precision on the way: the target has none in hardware.
    fn of_integer(value: i32) -> Self;

    /// The value in double precision, for reports and tests.
    fn to_f64(self) -> f64;

    /// The value in single precision, for what goes on the wire.
    fn to_f32(self) -> f32;

    /// Correctly rounded square root, so that host and target agree to the bit. NaN for a negative number.
    ///
    /// On a Cortex-M4F this is the `vsqrt.f32` instruction (14 cycles) instead of the software routine (about 50
    /// instructions) that a generic square root links.
    fn root(self) -> Self;

    /// Sine and cosine of an angle, rad.
    fn sine_and_cosine(self) -> (Self, Self);

    /// Not NaN and not infinite.
    fn is_a_number(self) -> bool;
}

/// Steps of a 16-bit fraction in one.
const FRACTION_STEPS: f32 = 32_767.0;

impl Real for f32 {
    type Fraction = i16;
    fn to_fraction(self) -> i16 {
        (self * FRACTION_STEPS) as i32 as i16
    }
    fn of_fraction(fraction: i16) -> Self {
        f32::from(fraction) * (1.0 / FRACTION_STEPS)
    }
    fn of(value: f64) -> Self {
        value as f32
    }
    fn of_integer(value: i32) -> Self {
        value as f32
    }
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
    fn to_f32(self) -> f32 {
        self
    }
    fn root(self) -> Self {
        sqrt_f32(self)
    }
    fn sine_and_cosine(self) -> (Self, Self) {
        sine::sin_cos(self)
    }
    fn is_a_number(self) -> bool {
        self.is_finite()
    }
}

impl Real for f64 {
    type Fraction = f64;
    fn to_fraction(self) -> f64 {
        self
    }
    fn of_fraction(fraction: f64) -> Self {
        fraction
    }
    fn of(value: f64) -> Self {
        value
    }
    fn of_integer(value: i32) -> Self {
        f64::from(value)
    }
    fn to_f64(self) -> f64 {
        self
    }
    fn to_f32(self) -> f32 {
        self as f32
    }
    fn root(self) -> Self {
        libm::sqrt(self)
    }
    fn sine_and_cosine(self) -> (Self, Self) {
        nalgebra::ComplexField::sin_cos(self)
    }
    fn is_a_number(self) -> bool {
        self.is_finite()
    }
}

/// The only unsafe code of the library. `libm::sqrtf` is a software routine although a core with a floating-point unit
/// has the instruction, and the compiler refuses `sreg` operands, so the value travels through a core register.
#[allow(unsafe_code)]
fn sqrt_f32(value: f32) -> f32 {
    #[cfg(all(target_arch = "arm", target_os = "none", target_abi = "eabihf"))]
    {
        let mut bits = value.to_bits();
        // SAFETY: touches one named register, which is declared clobbered; no memory, no flags.
        unsafe {
            core::arch::asm!(
                "vmov s0, {0}",
                "vsqrt.f32 s0, s0",
                "vmov {0}, s0",
                inout(reg) bits,
                out("s0") _,
                options(pure, nomem, nostack, preserves_flags),
            );
        }
        f32::from_bits(bits)
    }
    #[cfg(not(all(target_arch = "arm", target_os = "none", target_abi = "eabihf")))]
    libm::sqrtf(value)
}

/// The nearest integer, halves away from zero: as `libm::roundf`, in a quarter of its time.
pub fn rounded(x: f32) -> f32 {
    /// From here on, 2^23, every number is one. NaN goes the same way.
    const WHOLE: f32 = 8_388_608.0;
    if !(x.abs() < WHOLE) {
        return x;
    }
    let whole = x as i32 as f32;
    let rest = x - whole;
    if rest >= 0.5 {
        whole + 1.0
    } else if rest <= -0.5 {
        whole - 1.0
    } else {
        whole
    }
}

#[cfg(test)]
mod tests {
    use super::rounded;

    #[test]
    fn rounding_is_that_of_libm_for_every_exponent_and_beside_every_half() {
        let beside = |x: f32| [x.next_down(), x, x.next_up()];
        let halves = (0..2_000).map(|k| k as f32 * 0.5);
        let powers = (0..255).map(|exponent| f32::from_bits(exponent << 23 | 0x55_5555));
        let ends = [f32::INFINITY, 8_388_608.0, 4_194_304.5, 0.0];
        for x in halves.chain(powers).chain(ends).flat_map(beside).flat_map(|x| [x, -x]) {
            assert_eq!(rounded(x), libm::roundf(x), "{x}");
        }
        assert!(rounded(f32::NAN).is_nan());
    }
}
