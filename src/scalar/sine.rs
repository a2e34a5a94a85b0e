//! Sine and cosine in single precision without double precision on the way: `libm::sincosf` takes 7 KB of flash on the target
//! and computes in software doubles, which is half of the time of an elbow's calibration.

/// π/2 in three parts, of which the first two have so few digits that their multiples are exact.
const QUARTER: [f32; 3] = [1.570_312_5, 4.837_513e-4, 7.549_79e-8];
/// Minimax coefficients on ±π/4 (Lawson's iteration): of x³, x⁵, x⁷ for the sine, of x⁴, x⁶, x⁸ for the cosine.
const SINE: [f32; 3] = [-0.166_666_51, 0.008_331_976, -1.949_529_3e-4];
const COSINE: [f32; 3] = [0.041_666_646, -0.001_388_736_4, 2.443_809e-5];

/// Sine and cosine of an angle, rad, within ±10 000 to 1.5 · 2⁻²⁴.
pub fn sin_cos(angle_rad: f32) -> (f32, f32) {
    let quarters = libm::floorf(angle_rad * core::f32::consts::FRAC_2_PI + 0.5);
    let [high, middle, low] = QUARTER;
    let x = ((angle_rad - quarters * high) - quarters * middle) - quarters * low;
    let z = x * x;
    let [s3, s5, s7] = SINE;
    let [c4, c6, c8] = COSINE;
    let sin = x + x * z * (s3 + z * (s5 + z * s7));
    let cos = (1.0 - 0.5 * z) + z * z * (c4 + z * (c6 + z * c8));
    match quarters as i32 & 3 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

#[cfg(test)]
mod tests {
    use super::sin_cos;

    /// Against the standard library in double precision.
    #[test]
    fn sine_and_cosine_are_right_to_the_last_digits() {
        for step in -400_000..400_000 {
            let angle = step as f32 * 1.234_567e-4;
            let (sin, cos) = sin_cos(angle);
            let (true_sin, true_cos) = libm::sincos(f64::from(angle));
            let error = (f64::from(sin) - true_sin).abs().max((f64::from(cos) - true_cos).abs());
            assert!(error < 1e-7, "{angle}: {error}");
        }
        assert_eq!(sin_cos(0.0), (0.0, 1.0));
        assert!(sin_cos(f32::NAN).0.is_nan() && sin_cos(f32::INFINITY).1.is_nan());
    }
}
