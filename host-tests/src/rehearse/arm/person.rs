//! The virtual person with a whole arm: a ball, a hinge and a ball, and how the modules stand on the limbs between them.

use super::ball::BallModule;
use super::hinge::HingeModule;
use crate::study::arm::{FOREARM_MM, HAND_MM, UPPER_ARM_MM, mount, through};
use glenoid::identification::arm::Mount;
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;

/// How well the mounts are known, 1σ: a caliper and a square.
const MOUNT_MM: f64 = 0.3;
const MOUNT_RAD: f64 = 0.002;

/// The limbs: what is stated of the mounts, and what is true.
pub struct Limbs {
    upper_arm: (Mount<f64>, Mount<f64>),
    forearm: (Mount<f64>, Mount<f64>),
}

impl Limbs {
    /// Somebody's.
    pub fn new(random: &mut ChaCha8Rng) -> Self {
        Self {
            upper_arm: mount(random, MOUNT_MM, MOUNT_RAD, UPPER_ARM_MM),
            forearm: mount(random, MOUNT_MM, MOUNT_RAD, FOREARM_MM),
        }
    }

    /// The mounts of upper arm and forearm as they are stated.
    pub fn stated(&self) -> [Mount<f32>; 2] {
        [&self.upper_arm.0, &self.forearm.0].map(|mount| Mount {
            rotation: mount.rotation.map(|x| x as f32),
            origin_mm: mount.origin_mm.map(|x| x as f32),
            sigma_mm: mount.sigma_mm as f32,
            sigma_rad: mount.sigma_rad as f32,
        })
    }

    /// Where the hand is in the shoulder's base, mm.
    pub fn hand_mm(&self, shoulder: &BallModule, elbow: &HingeModule, wrist: &BallModule) -> Vector3<f64> {
        let on_forearm = through(&self.forearm.1, &wrist.wearer().arm().carried_mm(&wrist.at().rotation, &HAND_MM));
        let on_base = elbow.wearer().elbow().carried_mm(&on_forearm, elbow.flexion_rad());
        let on_upper_arm = through(&self.upper_arm.1, &on_base);
        shoulder.wearer().arm().carried_mm(&shoulder.at().rotation, &on_upper_arm)
    }

    /// Lengths of upper arm and forearm, mm: from the shoulder's centre to the elbow's axis, and from there to the wrist's
    /// centre.
    pub fn lengths_mm(&self, shoulder: &BallModule, elbow: &HingeModule, wrist: &BallModule) -> [f64; 2] {
        let distance = |from: Vector3<f64>, axis: &Vector3<f64>| from.cross(axis).norm();
        let hinge = elbow.wearer().elbow().hinge();
        let mount = &self.upper_arm.1;
        let shoulder_mm =
            mount.rotation.transpose() * (shoulder.wearer().arm().centre_in_platform_mm() - mount.origin_mm);
        let wrist_mm = through(&self.forearm.1, wrist.wearer().arm().centre_mm());
        [
            distance(shoulder_mm - hinge.foot_mm(), hinge.axis()),
            distance(wrist_mm - hinge.foot_in_platform_mm(), &hinge.axis_in_platform()),
        ]
    }
}
