//! A set of poses of a shoulder whose centre moves, and what is true of it.

use super::super::scene::{symmetric, symmetric_vector, tilted};
use crate::anatomy::Shoulder;
use crate::wearer::{FittedArm, rotation};
use glenoid::kinematics::{CableLengths, inverse};
use glenoid::rig::{CABLES, Rig};
use nalgebra::{Rotation3, Vector3};
use rand::Rng;
use std::f64::consts::TAU;

/// Noise of every length, uniform within this to either side, mm.
const NOISE_MM: f64 = 0.1;
/// Slides of the head that follow nothing, 1σ along each axis, mm.
const SLIDE_MM: f64 = 0.35;
/// Largest torsion to either side, degrees.
const TORSION_DEG: f64 = 30.0;
/// What is left of the shoulder blade's motion when it is held, and how far the arm is tilted then, degrees.
const LEFT_WHEN_HELD: f64 = 0.1;
const TILT_WHEN_HELD_DEG: f64 = 30.0;

/// What the joint does that no model has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trouble {
    /// Nothing.
    None,
    /// Nor does it move: a ball.
    Ball,
    /// In every second pose, by chance, the centre is elsewhere by 3 mm.
    Jumps,
    /// The strap slips by 3 mm midway.
    Slips,
}

/// One pose: the six readings, and the truth.
#[derive(Clone, Copy, Debug)]
pub struct Posed {
    /// mm.
    pub lengths_mm: [f64; CABLES],
    /// The arm from home.
    pub arm: Rotation3<f64>,
    /// The centre in {B} without the slide, mm.
    pub centre_mm: Vector3<f64>,
    /// The slide, mm.
    pub slide_mm: Vector3<f64>,
}

/// A person in a machine.
#[derive(Debug)]
pub struct Person {
    /// The machine.
    pub rig: Rig<f64>,
    shoulder: Shoulder,
    /// Where the arm is in it.
    pub arm: FittedArm,
    tilt_deg: f64,
}

impl Person {
    /// A person by number, with the centre up to 20 mm and the cuff up to 10 mm off along each axis.
    pub fn new(rig: Rig<f64>, person: u64, follow: f64, tilt_deg: f64, random: &mut impl Rng) -> Self {
        let (centre, cuff) = (symmetric_vector(random, 20.0), symmetric_vector(random, 10.0));
        Self { arm: FittedArm::new(&rig, centre, cuff), rig, shoulder: Shoulder::new(person, follow), tilt_deg }
    }

    /// Free poses.
    pub fn free(&self, count: usize, trouble: Trouble, random: &mut impl Rng) -> Vec<Posed> {
        let (direction, slipped) = (symmetric_vector(random, 1.0).normalize() * 3.0, count / 2);
        let share = if trouble == Trouble::Ball { 0.0 } else { 1.0 };
        (0..count)
            .map(|index| {
                let is_elsewhere = match trouble {
                    Trouble::None | Trouble::Ball => false,
                    Trouble::Jumps => random.random(),
                    Trouble::Slips => index >= slipped,
                };
                let off = if is_elsewhere { direction } else { Vector3::zeros() };
                self.pose(self.tilt_deg, share, off, random)
            })
            .collect()
    }

    /// Poses with the shoulder blade held.
    pub fn held(&self, count: usize, random: &mut impl Rng) -> Vec<Posed> {
        (0..count).map(|_| self.pose(TILT_WHEN_HELD_DEG, LEFT_WHEN_HELD, Vector3::zeros(), random)).collect()
    }

    fn pose(&self, tilt_deg: f64, share: f64, off: Vector3<f64>, random: &mut impl Rng) -> Posed {
        let arm = loop {
            // Uniform over the directions, as a sphere's cap is.
            let tilt = tilt_deg * libm::sqrt(random.random::<f64>());
            let arm = tilted(random.random_range(0.0..TAU), tilt)
                * rotation(Vector3::z(), symmetric(random, TORSION_DEG).to_radians());
            if self.shoulder.reaches(&arm) {
                break arm;
            }
        };
        let slide_mm = Shoulder::scatter_mm(random, if share > 0.0 { SLIDE_MM } else { 0.0 });
        let centre_mm = self.arm.centre_mm() + self.shoulder.displacement_mm(&arm) * share + off;
        let mut lengths_mm = inverse::cable_lengths(&self.rig, &(centre_mm + slide_mm), self.arm.end_points_mm(), &arm);
        lengths_mm.iter_mut().for_each(|length| *length += symmetric(random, NOISE_MM));
        Posed { lengths_mm, arm, centre_mm, slide_mm }
    }
}

/// The readings, as the library takes them.
pub fn lengths(poses: &[Posed]) -> Vec<CableLengths<f64>> {
    poses.iter().filter_map(|posed| CableLengths::new(posed.lengths_mm).ok()).collect()
}
