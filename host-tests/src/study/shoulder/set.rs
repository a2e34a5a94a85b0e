//! A set of poses of a shoulder whose centre moves, and what is true of it.

use super::super::built::{BuiltMachine, NOISE_MM, Worn};
use super::super::scene::{normal, symmetric, symmetric_vector, tilted};
use crate::anatomy::Shoulder;
use crate::wearer::rotation;
use glenoid::kinematics::CableLengths;
use glenoid::rig::{CABLES, POINTS};
use nalgebra::{Rotation3, Vector3};
use rand::Rng;
use std::f64::consts::TAU;

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

/// One pose: the six readings, and the truth in {B}.
#[derive(Clone, Copy, Debug)]
pub struct Posed {
    /// mm.
    pub lengths_mm: [f64; CABLES],
    /// Along the arm.
    pub along: Vector3<f64>,
    /// The centre without the slide, mm.
    pub centre_mm: Vector3<f64>,
    /// The centre with it, mm.
    pub slid_mm: Vector3<f64>,
    /// The end-points without the slide, mm.
    pub ends_mm: [Vector3<f64>; POINTS],
}

/// A person in a machine.
pub struct Person {
    /// The machine.
    pub machine: BuiltMachine,
    worn: Worn,
    shoulder: Shoulder,
    tilt_deg: f64,
    /// How the platform stands on the arm.
    askew: Rotation3<f64>,
}

impl Person {
    /// A person by number, with the centre up to 20 mm and the cuff up to 10 mm off along each axis.
    pub fn new(machine: BuiltMachine, person: u64, follow: f64, tilt_deg: f64, random: &mut impl Rng) -> Self {
        let worn = machine.worn(random, 20.0);
        Self { worn, machine, shoulder: Shoulder::new(person, follow), tilt_deg, askew: Rotation3::identity() }
    }

    /// The same person with the cuff askew, so that the arm's direction is not the platform's normal: normal errors about each
    /// axis across the arm, degrees.
    pub fn with_cuff_askew(self, sigma_deg: f64, random: &mut impl Rng) -> Self {
        let mut angle = || normal(random) * sigma_deg.to_radians();
        Self { askew: Rotation3::new(Vector3::new(angle(), angle(), 0.0)), ..self }
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
        let centre_mm = self.worn.centre_mm() + self.shoulder.displacement_mm(&arm) * share + off;
        let noise: [f64; CABLES] = std::array::from_fn(|_| symmetric(random, NOISE_MM));
        self.posed(&arm, &centre_mm, &slide_mm, &noise)
    }

    /// The arm at a rotation from home about a centre, with a slide of the head and errors of the readings, mm.
    pub fn posed(
        &self,
        arm: &Rotation3<f64>,
        centre_mm: &Vector3<f64>,
        slide_mm: &Vector3<f64>,
        noise_mm: &[f64; CABLES],
    ) -> Posed {
        let (machine, platform) = (&self.machine, arm * self.askew);
        let slid_mm = centre_mm + slide_mm;
        let readings = machine.without_noise(&self.worn.end_points_mm(&slid_mm, &platform));
        let in_base = |point: Vector3<f64>| machine.in_base_mm(&point);
        Posed {
            lengths_mm: std::array::from_fn(|cable| readings[cable] + noise_mm[cable]),
            along: (in_base(arm * Vector3::z()) - in_base(Vector3::zeros())),
            centre_mm: in_base(*centre_mm),
            slid_mm: in_base(slid_mm),
            ends_mm: self.worn.end_points_mm(centre_mm, &platform).map(in_base),
        }
    }
}

/// The readings, as the library takes them.
pub fn lengths(poses: &[Posed]) -> Vec<CableLengths<f64>> {
    poses.iter().filter_map(|posed| CableLengths::new(posed.lengths_mm).ok()).collect()
}
