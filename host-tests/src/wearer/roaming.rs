//! A slow free movement of the arm through its whole range, as people make it who are asked to: nothing is held.

use super::joint::SCATTER_MM;
use super::{Pose, Wearer, rotation, symmetric};
use glenoid::rig::CABLES;
use nalgebra::{Rotation3, Vector3};
use std::f64::consts::TAU;

/// How fast tilt, its direction and torsion go to and fro, rad/s: about 0.6 rad/s in all at the fastest.
const TILT_RAD_PER_S: f64 = 0.7;
const DIRECTION_RAD_PER_S: f64 = 0.31;
const TORSION_RAD_PER_S: f64 = 0.57;
/// How fast the head slides to and fro in its socket along each axis, rad/s (assumed): within half a second it is elsewhere.
const SLIDE_RAD_PER_S: [f64; 3] = [4.3, 5.9, 7.7];
/// The same where it slides slowly.
const SLOW_SLIDE_RAD_PER_S: [f64; 3] = [0.9, 1.4, 2.1];

/// The way of the arm.
#[derive(Debug, Clone)]
pub struct Roaming {
    seconds: f64,
    /// Where tilt, its direction and torsion begin, rad.
    phases: [f64; 3],
    /// The same of the slides along each axis.
    slides: [[f64; 3]; 3],
    slide_rad_per_s: [f64; 3],
}

impl Roaming {
    /// Begins somewhere.
    pub fn new(wearer: &mut Wearer) -> Self {
        let mut three = || std::array::from_fn(|_| symmetric(&mut wearer.random, TAU / 2.0));
        let (phases, slides) = (three(), [three(), three(), three()]);
        let slide_rad_per_s = if wearer.settings.slow_slides { SLOW_SLIDE_RAD_PER_S } else { SLIDE_RAD_PER_S };
        Self { seconds: 0.0, phases, slides, slide_rad_per_s }
    }

    /// The arm after `period_ms` more, with fresh noise of every cable.
    pub fn next(&mut self, wearer: &mut Wearer, period_ms: u32) -> Pose {
        self.seconds += f64::from(period_ms) / 1000.0;
        let noise_mm = wearer.settings.noise_mm;
        let errors_mm: [f64; CABLES] = std::array::from_fn(|_| symmetric(&mut wearer.random, noise_mm));
        let slide_mm = if wearer.joint.is_some() { self.slide_mm() } else { Vector3::zeros() };
        wearer.pose(self.rotation(wearer), slide_mm, errors_mm)
    }

    fn rotation(&self, wearer: &Wearer) -> Rotation3<f64> {
        let [tilt, direction, torsion] = self.phases;
        let azimuth = direction + DIRECTION_RAD_PER_S * self.seconds;
        let across = Vector3::new(libm::cos(azimuth), libm::sin(azimuth), 0.0);
        let torsion = wearer.settings.torsion_rad * libm::sin(torsion + TORSION_RAD_PER_S * self.seconds);
        let twist = rotation(Vector3::z(), torsion);
        let mut tilt = wearer.tilt_limit_rad() * libm::sin(tilt + TILT_RAD_PER_S * self.seconds);
        loop {
            let there = rotation(across, tilt) * twist;
            // Where the shoulder ends, less far.
            if wearer.reaches(&there) || tilt.abs() < 1e-3 {
                return there;
            }
            tilt *= 0.98;
        }
    }

    /// Along each axis three waves of a third of the variance.
    fn slide_mm(&self) -> Vector3<f64> {
        let wave = |phases: &[f64; 3]| -> f64 {
            phases.iter().zip(self.slide_rad_per_s).map(|(phase, speed)| libm::sin(phase + speed * self.seconds)).sum()
        };
        Vector3::from_fn(|axis, _| wave(&self.slides[axis])) * (SCATTER_MM * libm::sqrt(2.0 / 3.0))
    }
}
