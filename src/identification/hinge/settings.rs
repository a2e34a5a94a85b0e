//! Settings of the hinge's estimator.

use super::rig::HingeRig;
use crate::identification::settings::Noise;
use crate::scalar::Real;

/// Limits of acceptance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HingeSettings<T> {
    /// Noise of a cable length.
    pub noise: Noise<T>,
    /// Smallest flexion, from the smallest to the largest angle of the poses, rad.
    pub flexion_limit_rad: T,
    /// Largest 1σ of the direction of the axis in either body, in its worst direction, rad.
    pub axis_limit_rad: T,
    /// Largest 1σ of the place of the axis across it in either body, in its worst direction, mm.
    pub place_limit_mm: T,
    /// Largest 1σ of where the bodies stand along the axis, mm.
    pub along_limit_mm: T,
}

impl<T: Real> HingeSettings<T> {
    /// The limits for a rig. Where a drawing says the rest, what it says may stand for what the cables do not see, and the
    /// limits of the standard deviations are wide.
    pub fn for_rig(rig: &HingeRig<T>) -> Self {
        let has_prior = rig.drawing().is_some_and(|drawing| drawing.sigma.is_some());
        let wide = T::of(if has_prior { 5.0 } else { 1.0 });
        Self {
            noise: Noise::Known(rig.length_noise_mm()),
            // 30 degrees.
            flexion_limit_rad: T::of(0.524),
            // 2 degrees: at the wrist, 250 mm on, 9 mm.
            axis_limit_rad: T::of(0.035) * wide,
            place_limit_mm: T::of(2.0) * wide,
            along_limit_mm: T::of(5.0) * wide,
        }
    }
}
