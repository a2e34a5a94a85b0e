//! A rotation in six bytes: what the solver keeps of each of a hundred poses.

use crate::scalar::Real;
use nalgebra::{Quaternion, UnitQuaternion};

/// Modified Rodrigues parameters (x, y, z) / (1 + w) of a unit quaternion with w >= 0: three numbers within ±1, with no
/// singular rotation among them (Shuster 1993, "A survey of attitude representations").
///
/// In single precision within 2.2e-4 rad. The solver's equations are linear about the kept rotation, so what this costs
/// is of second order: 5e-6 mm on an arm of 200 mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PackedAttitude<T: Real>([T::Fraction; 3]);

impl<T: Real> PackedAttitude<T> {
    pub fn identity() -> Self {
        Self([T::zero().to_fraction(); 3])
    }

    #[inline(never)]
    pub fn set(&mut self, attitude: &UnitQuaternion<T>) {
        let [x, y, z, w]: [T; 4] = attitude.coords.into();
        // q and -q are the same rotation.
        let by_sum = if w < T::zero() { T::one() / (w - T::one()) } else { T::one() / (w + T::one()) };
        self.0 = [(x * by_sum).to_fraction(), (y * by_sum).to_fraction(), (z * by_sum).to_fraction()];
    }

    #[inline(never)]
    pub fn unpacked(&self) -> UnitQuaternion<T> {
        let [x, y, z] = self.0;
        let (x, y, z) = (T::of_fraction(x), T::of_fraction(y), T::of_fraction(z));
        let twice = T::of(2.0) / (T::one() + x * x + y * y + z * z);
        UnitQuaternion::new_unchecked(Quaternion::new(twice - T::one(), x * twice, y * twice, z * twice))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    /// Every rotation comes back: axes all round, angles to more than half a turn.
    fn largest_error<T: Real>() -> f64 {
        let mut largest = 0.0_f64;
        for step in 0..20_000 {
            let [a, b] = [f64::from(step) * 0.377, f64::from(step) * 0.618_034];
            let axis = Vector3::new(a.cos() * b.sin(), a.sin() * b.sin(), b.cos());
            let angle = f64::from(step) * 1e-3 % 7.0;
            let attitude = UnitQuaternion::from_scaled_axis(axis * angle);
            let [x, y, z, w]: [f64; 4] = attitude.coords.into();
            let [a, b, c, d] = [w, x, y, z].map(T::of);
            let mut kept = PackedAttitude::identity();
            kept.set(&UnitQuaternion::new_unchecked(Quaternion::new(a, b, c, d)));
            let [x, y, z, w] = <[T; 4]>::from(kept.unpacked().coords).map(Real::to_f64);
            let back = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
            largest = largest.max(back.angle_to(&attitude));
        }
        largest
    }

    #[test]
    fn a_kept_rotation_comes_back() {
        let (single, double) = (largest_error::<f32>(), largest_error::<f64>());
        assert!(single < 2.2e-4 && double < 1e-7, "{single} {double}");
        // 16 bits, not 32.
        assert_eq!(size_of::<PackedAttitude<f32>>(), 6);
        assert!(single > 1e-5);
    }
}
