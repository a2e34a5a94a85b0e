//! How the joint centre moves, as it is shown, kept and used: 24 integers, so that all three are the same to the bit.

use super::arm_frame::{ArmFrame, FEATURES, SHOWN_FEATURES};
use super::moving_centre::MovingCentre;
use super::scatter::Scatter;
use crate::kinematics::rotation::{nearest_attitude, rotation_of};
use crate::scalar;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// Parts of three numbers: the six columns of A that are shown, then scatter and standard deviations, then the frame.
pub const MOTION_PARTS: usize = SHOWN_FEATURES + 2;
/// The part of scatter and standard deviations, and that of the frame.
const SIGMAS: usize = SHOWN_FEATURES;
const FRAME: usize = SHOWN_FEATURES + 1;

/// Steps of a millimetre, or of a millimetre per unit of a feature: 128. What rounding changes in the centre, 0.01 mm,
/// is far below its standard deviation.
const STEPS: f32 = 128.0;
/// Steps of the modified Rodrigues parameters, which lie between -1 and 1.
const FRAME_STEPS: f32 = 64.0 * STEPS;
/// The largest integer: 15 bits with the sign.
const MAX: f32 = 16_383.0;

/// How a joint centre moves with the arm, O(R) = O0 + A φ(R), with the scatter about that and how well the path is known. Of φ
/// the trefoils are not shown.
///
/// | part | its three numbers |
/// |---|---|
/// | 0 to 5 | a column of A: x, y, z in {B}, mm per unit of φ, in steps of 1/128 |
/// | 6 | scatter along an axis; 1σ of the path across the arm; 1σ of the path in all: mm, in steps of 1/128 |
/// | 7 | the frame of φ: the mean rotation {P} to {B} as modified Rodrigues parameters, in steps of 1/8192 |
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ShownMotion {
    parts: [[i16; 3]; MOTION_PARTS],
}

impl ShownMotion {
    /// Rounds a model to what is shown of it. `across_mm`, `all_mm`: 1σ of the path, across the arm and in all. `None`
    /// when a number does not fit: no joint moves so far.
    #[cfg_attr(feature = "ccm", unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
    pub fn new(model: &MovingCentre<f32>, across_mm: f32, all_mm: f32) -> Option<Self> {
        let mut parts = [[0; 3]; MOTION_PARTS];
        for (part, gain) in parts.iter_mut().zip(&model.gains).take(SHOWN_FEATURES) {
            *part = rounded([gain.x, gain.y, gain.z], STEPS)?;
        }
        parts[SIGMAS] = rounded([model.scatter.sigma_mm(), across_mm, all_mm], STEPS)?;
        let mean = nearest_attitude(model.frame.mean());
        let (vector, scalar) = if mean.w < 0.0 { (-mean.imag(), -mean.w) } else { (mean.imag(), mean.w) };
        let parameters = vector * (1.0 / (1.0 + scalar));
        parts[FRAME] = rounded(parameters.into(), FRAME_STEPS)?;
        Some(Self { parts })
    }

    /// From the integers, part by part.
    pub const fn from_parts(parts: [[i16; 3]; MOTION_PARTS]) -> Self {
        Self { parts }
    }

    /// The integers, part by part.
    pub const fn parts(&self) -> &[[i16; 3]; MOTION_PARTS] {
        &self.parts
    }

    /// Can these be the numbers of a joint: scatter and standard deviations are not negative, and the frame is a
    /// rotation.
    pub fn is_sound(&self) -> bool {
        let [.., sigmas, frame] = &self.parts;
        let squares = frame.iter().fold(0.0, |sum, number| sum + f32::from(*number) * f32::from(*number));
        sigmas.iter().all(|number| *number >= 0) && squares <= FRAME_STEPS * FRAME_STEPS * 1.001
    }

    /// The model with exactly these numbers.
    pub fn model(&self) -> MovingCentre<f32> {
        let [x, y, z] = self.parts[FRAME].map(|number| f32::from(number) * (1.0 / FRAME_STEPS));
        let squares = x * x + y * y + z * z;
        let scale = 1.0 / (1.0 + squares);
        let double = 2.0 * scale;
        let mean = Quaternion::new((1.0 - squares) * scale, x * double, y * double, z * double);
        let mut gains = [Vector3::zeros(); FEATURES];
        for (gain, part) in gains.iter_mut().zip(&self.parts).take(SHOWN_FEATURES) {
            *gain = Vector3::from(part.map(|number| f32::from(number) * (1.0 / STEPS)));
        }
        let frame = ArmFrame::of_mean(rotation_of(&UnitQuaternion::new_unchecked(mean)));
        MovingCentre { frame, gains, scatter: Scatter::of_sigma(self.sigmas_mm()[0]), persistence: 1.0 }
    }

    /// Scatter along an axis, 1σ of the path across the arm, and in all, mm.
    pub fn sigmas_mm(&self) -> [f32; 3] {
        self.parts[SIGMAS].map(|number| f32::from(number) * (1.0 / STEPS))
    }
}

/// Three numbers in steps; `None` when one does not fit or is none.
#[cfg_attr(feature = "ccm", unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
fn rounded(values: [f32; 3], steps: f32) -> Option<[i16; 3]> {
    let scaled = values.map(|value| scalar::rounded(value * steps));
    // Written so that NaN fails.
    scaled.iter().all(|steps| steps.abs() <= MAX).then(|| scaled.map(|steps| steps as i16))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;

    fn moving(turn: Vector3<f32>) -> MovingCentre<f32> {
        let frame = ArmFrame::of_mean(Rotation3::new(turn).into_inner());
        // the trefoils are not shown
        let gains = core::array::from_fn(|j| {
            if j < SHOWN_FEATURES { Vector3::new(j as f32 - 20.0, 31.27 - j as f32, 0.503) } else { Vector3::zeros() }
        });
        MovingCentre { frame, gains, scatter: Scatter::of_sigma(0.35), persistence: 1.0 }
    }

    #[test]
    fn the_centre_moves_as_before_to_a_hundredth_of_a_millimetre() {
        for turn in [[0.0, 0.0, 0.0], [0.3, -0.2, 1.1], [2.0, 1.5, -1.0], [0.0, 3.1, 0.0]] {
            let model = moving(turn.into());
            let shown = ShownMotion::new(&model, 0.5, 1.2).unwrap();
            assert!(shown.is_sound());
            for arm in [[0.1, 0.2, 0.3], [-0.5, 0.4, 0.2], [0.0, -0.7, -0.4]] {
                let rotation = Rotation3::new(arm.into()).into_inner() * model.frame.mean();
                let off = shown.model().displacement_mm(&rotation) - model.displacement_mm(&rotation);
                assert!(off.norm() < 0.02, "{turn:?} {arm:?}: {off}");
            }
            let [scatter, across, all] = shown.sigmas_mm();
            assert!((scatter - 0.35).abs() < 0.004 && (across - 0.5).abs() < 0.004 && (all - 1.2).abs() < 0.004);
        }
    }

    #[test]
    fn what_is_shown_of_a_shown_motion_is_the_same_to_the_bit() {
        let shown = ShownMotion::new(&moving(Vector3::new(0.7, -1.2, 0.4)), 0.5, 1.2).unwrap();
        let [_, across, all] = shown.sigmas_mm();
        assert_eq!(ShownMotion::new(&shown.model(), across, all), Some(shown));
    }

    #[test]
    fn a_joint_that_moves_out_of_range_is_not_shown() {
        let mut model = moving(Vector3::zeros());
        model.gains[2].y = 128.0;
        assert_eq!(ShownMotion::new(&model, 0.5, 1.2), None);
        model.gains[2].y = f32::NAN;
        assert_eq!(ShownMotion::new(&model, 0.5, 1.2), None);
    }
}
