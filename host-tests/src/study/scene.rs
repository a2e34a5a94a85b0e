//! The virtual rehabilitator of the studies: a rig, an arm in it, and the poses that the arm takes.

use crate::wearer::{FittedArm, rotation};
use glenoid::kinematics::inverse;
use glenoid::rig::{CABLES, Drum, POINTS, Parameters, Rig, RigError};
use glenoid::scalar::Real;
use nalgebra::{Rotation3, Vector3};
use rand::Rng;
use std::f64::consts::TAU;

/// A rig with an arm in it whose joint centre is known.
#[derive(Debug, Clone, Copy)]
pub struct Scene {
    rig: Rig<f64>,
    rig_single: Rig<f32>,
    /// Joint centre O in {B}, mm.
    pub centre_mm: Vector3<f64>,
    /// OP_1..OP_3 at home, axes of {B}, mm.
    pub end_points_mm: [Vector3<f64>; POINTS],
}

/// How far a random rig and its arm are from their ideal places, along each axis, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Least and largest base radius.
    pub base_radius_mm: (f64, f64),
    /// Attachment points and end-points.
    pub points_mm: f64,
    /// Joint centre.
    pub centre_mm: f64,
}

impl Spread {
    /// Rigs of all sizes, everything within 20 mm of its ideal place.
    pub const ANY_RIG: Self = Self { base_radius_mm: (120.0, 350.0), points_mm: 20.0, centre_mm: 20.0 };
    /// The same with the centre within 60 mm.
    pub const EXTREME: Self = Self { centre_mm: 60.0, ..Self::ANY_RIG };
}

/// How far the arm moves: tilt about a random horizontal axis, and torsion about its own length before that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reach {
    /// Largest tilt, degrees.
    pub tilt_deg: f64,
    /// Largest torsion to either side, degrees.
    pub torsion_deg: f64,
}

impl Reach {
    /// What a wearer does when asked to move about: 45 and 30 degrees.
    pub const USUAL: Self = Self { tilt_deg: 45.0, torsion_deg: 30.0 };
    /// As far as a shoulder goes in the machine: 60 degrees of both.
    pub const EXTREME: Self = Self { tilt_deg: 60.0, torsion_deg: 60.0 };

    /// A random rotation of the arm from home; both angles are uniform.
    pub fn rotation(self, random: &mut impl Rng) -> Rotation3<f64> {
        let azimuth = random.random_range(0.0..TAU);
        let tilt = random.random_range(0.0..=1.0) * self.tilt_deg;
        let torsion = symmetric(random, self.torsion_deg);
        tilted(azimuth, tilt) * rotation(Vector3::z(), torsion.to_radians())
    }
}

/// The arm tilted by `tilt_deg` about the horizontal axis at `azimuth_rad`.
pub fn tilted(azimuth_rad: f64, tilt_deg: f64) -> Rotation3<f64> {
    rotation(Vector3::new(libm::cos(azimuth_rad), libm::sin(azimuth_rad), 0.0), tilt_deg.to_radians())
}

/// Uniform within `limit` to either side. Always draws, so that a limit of zero changes no other number.
pub fn symmetric(random: &mut impl Rng, limit: f64) -> f64 {
    random.random_range(-1.0..=1.0) * limit
}

/// A vector with each component uniform within `limit` to either side.
pub fn symmetric_vector(random: &mut impl Rng, limit: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| symmetric(random, limit))
}

/// A standard normal number (Box and Muller 1958).
pub fn normal(random: &mut impl Rng) -> f64 {
    let (u, v): (f64, f64) = (random.random_range(f64::MIN_POSITIVE..1.0), random.random_range(0.0..TAU));
    libm::sqrt(-2.0 * libm::log(u)) * libm::cos(v)
}

impl Scene {
    /// The paper's rig with a base of the given radius, and the arm of Table I in it.
    ///
    /// # Errors
    /// When the radius gives no rig.
    pub fn table_1(base_radius_mm: f64) -> Result<Self, RigError> {
        let rig = Rig::shoulder(base_radius_mm)?;
        let arm = FittedArm::new(&rig, Vector3::zeros(), Vector3::zeros());
        Self::new(rig, *arm.centre_mm(), *arm.end_points_mm())
    }

    fn new(rig: Rig<f64>, centre_mm: Vector3<f64>, end_points_mm: [Vector3<f64>; POINTS]) -> Result<Self, RigError> {
        Ok(Self { rig_single: in_precision(&rig)?, rig, centre_mm, end_points_mm })
    }

    /// A random rig. Everything is drawn again in the rare case that the points make no rig (three in a line).
    ///
    /// # Errors
    /// When the least base radius gives no rig.
    pub fn random(random: &mut impl Rng, spread: &Spread) -> Result<Self, RigError> {
        loop {
            let (least, most) = spread.base_radius_mm;
            let ideal = Self::table_1(random.random_range(least..=most))?;
            let base_mm = ideal.rig.base_mm().map(|b| b + symmetric_vector(random, spread.points_mm));
            let end_points_mm = ideal.end_points_mm.map(|p| p + symmetric_vector(random, spread.points_mm));
            let centre_mm = ideal.centre_mm + symmetric_vector(random, spread.centre_mm);
            let [p1, p2, p3] = end_points_mm;
            let edges_mm = [p1 - p2, p2 - p3, p3 - p1].map(|edge| libm::sqrt(edge.norm_squared()));
            let (drum, noise, nominal) = (*ideal.rig.drum(), ideal.rig.length_noise_mm(), *ideal.rig.nominal());
            let rig = Rig::new(base_mm, edges_mm, drum, noise, nominal);
            if let Ok(scene) = rig.and_then(|rig| Self::new(rig, centre_mm, end_points_mm)) {
                return Ok(scene);
            }
        }
    }

    /// The same rig with the joint centre and the cuff on the arm moved by up to this much along each axis, mm.
    #[must_use]
    pub fn worn(mut self, random: &mut impl Rng, centre_mm: f64, cuff_mm: f64) -> Self {
        self.centre_mm += symmetric_vector(random, centre_mm);
        let cuff = symmetric_vector(random, cuff_mm);
        self.end_points_mm = self.end_points_mm.map(|p| p + cuff);
        self
    }

    /// The rig as the solver knows it.
    pub fn rig(&self) -> &Rig<f64> {
        &self.rig
    }

    /// The same in single precision.
    pub fn rig_single(&self) -> &Rig<f32> {
        &self.rig_single
    }

    /// What an identification should find: x, y, z, p1, p2, p3, mm.
    pub fn truth(&self) -> Parameters<f64> {
        Parameters { centre_mm: self.centre_mm, radii_mm: self.end_points_mm.map(|p| libm::sqrt(p.norm_squared())) }
    }

    /// The six spans at a rotation from home, mm.
    pub fn lengths(&self, rotation: &Rotation3<f64>) -> [f64; CABLES] {
        self.lengths_about(&self.centre_mm, rotation)
    }

    /// The six spans with the joint centre elsewhere than it should be, mm.
    pub fn lengths_about(&self, centre_mm: &Vector3<f64>, rotation: &Rotation3<f64>) -> [f64; CABLES] {
        inverse::cable_lengths(&self.rig, centre_mm, &self.end_points_mm, rotation)
    }
}

/// Adds noise uniform within `limit_mm` to either side to every length.
pub fn with_noise(mut lengths_mm: [f64; CABLES], random: &mut impl Rng, limit_mm: f64) -> [f64; CABLES] {
    for length in &mut lengths_mm {
        *length += symmetric(random, limit_mm);
    }
    lengths_mm
}

/// The rig with its constants rounded to another precision.
fn in_precision<T: Real>(rig: &Rig<f64>) -> Result<Rig<T>, RigError> {
    let (drum, nominal) = (rig.drum(), rig.nominal());
    let drum = Drum {
        radius_mm: T::of(drum.radius_mm),
        counts_per_turn: T::of(drum.counts_per_turn),
        home_length_mm: drum.home_length_mm.map(T::of),
        fastest_mm_per_s: T::of(drum.fastest_mm_per_s),
    };
    let nominal = Parameters { centre_mm: nominal.centre_mm.map(T::of), radii_mm: nominal.radii_mm.map(T::of) };
    let base_mm = rig.base_mm().map(|point| point.map(T::of));
    Rig::new(base_mm, rig.edges_mm().map(T::of), drum, T::of(rig.length_noise_mm()), nominal)
}
