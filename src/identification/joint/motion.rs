//! How far the arm moves in a set of poses: enough to determine how the joint centre moves with it?

use super::arm_frame::ArmFrame;
use crate::identification::refusal::Refusal;
use crate::linear_algebra::{largest_eigenpair, non_negative_root};
use crate::scalar::Real;
use nalgebra::Matrix2;

/// Minimum number of poses for a centre that moves: 54 equations for 24 unknowns.
pub const MIN_MOVING_POSES: usize = 18;

/// Smallest standard deviations of tilt in its widest and its narrowest plane, and of torsion, rad (6, 4 and 5
/// degrees).
const MIN_TILT_RAD: f64 = 0.105;
const MIN_SECOND_TILT_RAD: f64 = 0.070;
const MIN_TORSION_RAD: f64 = 0.087;

/// What a set of poses lacks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum MissingMotion {
    /// Tilt altogether.
    Tilt = 1,
    /// Tilt out of one plane.
    SecondPlane = 2,
    /// Turning of the arm about its own length.
    Torsion = 3,
}

impl MissingMotion {
    /// What is missing, in words.
    pub const fn text(self) -> &'static str {
        match self {
            Self::Tilt => "the joint centre moves, and the arm is tilted too little to say how",
            Self::SecondPlane => "the joint centre moves, and the arm is tilted in one plane only",
            Self::Torsion => "the joint centre moves, and the arm is not turned about its own length",
        }
    }
}

/// Sums over the poses: tilt across the mean direction, and torsion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmMotion<T> {
    poses: T,
    sum: [T; 3],
    products: [T; 4],
}

impl<T: Real> Default for ArmMotion<T> {
    fn default() -> Self {
        Self { poses: T::zero(), sum: [T::zero(); 3], products: [T::zero(); 4] }
    }
}

impl<T: Real> ArmMotion<T> {
    /// Adds a pose by its tilt (two components across the mean direction) and torsion, rad.
    pub fn add(&mut self, [x, y]: [T; 2], torsion: T) {
        self.poses += T::one();
        for (sum, value) in self.sum.iter_mut().zip([x, y, torsion]) {
            *sum += value;
        }
        for (sum, value) in self.products.iter_mut().zip([x * x, x * y, y * y, torsion * torsion]) {
            *sum += value;
        }
    }

    /// Refuses too little motion for a moving centre, and names what is missing.
    ///
    /// # Errors
    /// [`Refusal::TooFewForMovingCentre`], [`Refusal::MissingMotion`].
    pub fn require_motion(&self, frame: &ArmFrame<T>, poses: usize) -> Result<(), Refusal> {
        if poses < MIN_MOVING_POSES {
            return Err(Refusal::TooFewForMovingCentre { poses: poses as u32 });
        }
        let share = T::one() / self.poses.max(T::one());
        let [x, y, torsion] = self.sum.map(|sum| sum * share);
        let [xx, xy, yy, tt] = self.products.map(|sum| sum * share);
        let tilt = Matrix2::new(xx - x * x, xy - x * y, xy - x * y, yy - y * y);
        let (widest, along) = largest_eigenpair(&tilt);
        let widest_rad = non_negative_root(widest);
        let narrowest_rad = non_negative_root(tilt.trace() - widest);
        let torsion_rad = non_negative_root(tt - torsion * torsion);
        let [e1, e2] = frame.across();
        // Across the plane in which the arm tilts.
        let direction = (e2 * along.x - e1 * along.y).map(Real::to_f32);
        let missing = |missing, spread: T| {
            Err(Refusal::MissingMotion { missing, spread_rad: spread.to_f32(), direction: direction.into() })
        };
        // Also refuses NaN.
        if !(widest_rad >= T::of(MIN_TILT_RAD)) {
            missing(MissingMotion::Tilt, widest_rad)
        } else if !(narrowest_rad >= T::of(MIN_SECOND_TILT_RAD)) {
            missing(MissingMotion::SecondPlane, narrowest_rad)
        } else if !(torsion_rad >= T::of(MIN_TORSION_RAD)) {
            missing(MissingMotion::Torsion, torsion_rad)
        } else {
            Ok(())
        }
    }
}
