//! The modules as one chain, from what their boards have found to the hand: the same chain as that of `cargo arm`.

use super::ball::CalibratedBall;
use super::hinge::CalibratedHinge;
use super::module::name;
use crate::study::arm::HAND_MM;
use glenoid::identification::arm::{Arm, ArmPose, Mount};
use nalgebra::{Matrix3, Vector3};
use serde::Serialize;

/// The hand's error may be this many σ, and this much beyond, mm: single precision, and lengths that are rounded to counts.
const SIGMAS: f64 = 5.0;
const GRANTED_MM: f64 = 0.05;

/// The hand in one posture.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Hand {
    /// Where it is by the chain, in the shoulder's base, mm.
    pub found_mm: [f64; 3],
    /// 1σ along each axis, mm.
    pub sigma_mm: [f64; 3],
    /// Covariance, mm².
    pub covariance_mm2: [[f64; 3]; 3],
    /// Where it is, mm.
    pub true_mm: [f64; 3],
    /// Distance of the two, mm.
    pub error_mm: f64,
    /// Squared error over the covariance: 3 on average.
    pub chi_square: f64,
    /// What shoulder, elbow, wrist and mounts add to σ, mm.
    pub by_module_mm: [f64; 4],
}

/// A limb.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Limb {
    /// Its length by the chain, mm.
    pub length_mm: f64,
    /// 1σ, mm.
    pub sigma_mm: f64,
    /// Its length, mm.
    pub true_mm: f64,
}

/// The identified modules and the mounts between them.
pub struct Chain<'a> {
    arm: Arm<'a, f32>,
}

impl<'a> Chain<'a> {
    /// The chain of an arm, in the precision of its boards.
    pub fn new(
        shoulder: &'a CalibratedBall,
        elbow: &'a CalibratedHinge,
        wrist: &'a CalibratedBall,
        [upper_arm, forearm]: [Mount<f32>; 2],
    ) -> Self {
        let (shoulder, elbow, wrist) = (shoulder.ball(), &elbow.estimator, wrist.ball());
        Self { arm: Arm { shoulder, upper_arm, elbow, forearm, wrist } }
    }

    /// The hand in a posture, beside where it is.
    ///
    /// # Errors
    /// The module whose lengths fit no pose.
    pub fn hand(&self, posture: &ArmPose<f32>, true_mm: &Vector3<f64>) -> Result<Hand, String> {
        let position = self.arm.position(posture, &HAND_MM.map(|x| x as f32));
        let position = position.map_err(|module| format!("the {}'s lengths fit no pose", name(module)))?;
        let found_mm = position.hand.at_mm.map(f64::from);
        let covariance: Matrix3<f64> = position.hand.covariance_mm2.map(f64::from);
        let error = found_mm - true_mm;
        Ok(Hand {
            found_mm: found_mm.into(),
            sigma_mm: position.hand.sigma_mm().map(f64::from).into(),
            covariance_mm2: covariance.transpose().into(),
            true_mm: (*true_mm).into(),
            error_mm: error.norm(),
            chi_square: covariance.try_inverse().map_or(f64::INFINITY, |inverse| error.dot(&(inverse * error))),
            by_module_mm: position.by_module_mm.map(f64::from),
        })
    }

    /// Upper arm and forearm.
    pub fn limbs(&self, true_mm: [f64; 2]) -> [Limb; 2] {
        let segments = self.arm.segments();
        let limb = |(length_mm, sigma_mm): (f32, f32), true_mm| Limb {
            length_mm: length_mm.into(),
            sigma_mm: sigma_mm.into(),
            true_mm,
        };
        let [upper_arm, forearm] = true_mm;
        [limb(segments.upper_arm_mm, upper_arm), limb(segments.forearm_mm, forearm)]
    }
}

impl Hand {
    /// What is wrong with it, in words. No number is never right.
    pub fn objection(&self) -> Option<String> {
        let allowed = self.sigma_mm.map(|sigma| SIGMAS * sigma + GRANTED_MM);
        let is_right = (0..3).all(|k| (self.found_mm[k] - self.true_mm[k]).abs() <= allowed[k]);
        (!is_right).then(|| format!("the hand is {:.2} mm off, where its σ is {:.2?} mm", self.error_mm, self.sigma_mm))
    }
}

impl Limb {
    /// What is wrong with it, in words.
    pub fn objection(&self, title: &str) -> Option<String> {
        let off = self.length_mm - self.true_mm;
        let is_right = off.abs() <= SIGMAS * self.sigma_mm + GRANTED_MM;
        (!is_right).then(|| format!("the {title} is {off:+.2} mm off, where its σ is {:.2} mm", self.sigma_mm))
    }
}
