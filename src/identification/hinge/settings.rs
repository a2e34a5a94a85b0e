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
    /// The limits for a rig. Those of the standard deviations only keep out what is useless: errors along the weak
    /// directions of a hinge hardly move what it carries.
    pub fn for_rig(rig: &HingeRig<T>) -> Self {
        Self {
            noise: Noise::Known(rig.length_noise_mm()),
            // 30 degrees.
            flexion_limit_rad: T::of(0.524),
            // 5 degrees.
            axis_limit_rad: T::of(0.087_3),
            place_limit_mm: T::of(10.0),
            along_limit_mm: T::of(20.0),
        }
    }
}
