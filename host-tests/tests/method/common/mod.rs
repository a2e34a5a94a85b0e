//! Seeded rigs, poses and starts for the tests of the identification.
//!
//! The truth is made here from rotations and subtractions alone, so that it shares nothing with the code under test.

pub mod dense;
pub mod differences;
pub mod library;
pub mod oracle;
pub mod sets;

use host_tests::literal::{Estimate, Lengths, Machine};
use nalgebra::{Rotation3, Vector3};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Height of the joint centre above the base, mm (Table I).
pub const CENTRE_HEIGHT_MM: f64 = 148.0;
/// Height of the platform above the joint centre at home, mm (Table I).
pub const PLATFORM_HEIGHT_MM: f64 = 96.0;
/// Distance of the end-points from the joint centre, mm (Table I).
pub const RADIUS_MM: f64 = 140.8;

/// The generator of every random number in a test.
pub fn rng(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

/// A machine with a wearer in it: everything that the identification is not told.
#[derive(Clone, Copy, Debug)]
pub struct Worn {
    /// Base points in {B}, mm.
    pub base_mm: [Vector3<f64>; 3],
    /// True joint centre in {B}, mm.
    pub centre_mm: Vector3<f64>,
    /// `OP_1..3` at home, mm.
    pub home_mm: [Vector3<f64>; 3],
}

impl Worn {
    /// Table I over a base of the given radius, with the platform turned by 60 degrees against the base.
    pub fn table_one(base_radius_mm: f64) -> Self {
        let across = (RADIUS_MM * RADIUS_MM - PLATFORM_HEIGHT_MM * PLATFORM_HEIGHT_MM).sqrt();
        Self {
            base_mm: [0.0, 120.0, 240.0].map(|azimuth| on_circle(base_radius_mm, azimuth, 0.0)),
            centre_mm: Vector3::new(0.0, 0.0, CENTRE_HEIGHT_MM),
            home_mm: [60.0, 180.0, 300.0].map(|azimuth| on_circle(across, azimuth, PLATFORM_HEIGHT_MM)),
        }
    }

    /// A base radius of 120 to 350 mm, every point off its ideal place by up to `spread_mm` along each axis, and one
    /// machine in two numbered clockwise.
    pub fn random(rng: &mut ChaCha8Rng, spread_mm: f64) -> Self {
        let mut worn = Self::table_one(rng.random_range(120.0..350.0));
        for point in worn.base_mm.iter_mut().chain(&mut worn.home_mm).chain([&mut worn.centre_mm]) {
            *point += jitter(rng, spread_mm);
        }
        if rng.random() { worn.mirrored() } else { worn }
    }

    /// The same machine seen in a mirror: its points go round the other way, clockwise seen from the arm.
    pub fn mirrored(&self) -> Self {
        Self {
            base_mm: self.base_mm.map(mirrored),
            centre_mm: mirrored(self.centre_mm),
            home_mm: self.home_mm.map(mirrored),
        }
    }

    /// The six cable lengths at a rotation of the arm from home, mm (Eq. 2, 3, 5, 6, 8, 9).
    pub fn lengths_mm(&self, arm: &Rotation3<f64>) -> Lengths<f64> {
        let end = self.home_mm.map(|p| self.centre_mm + arm * p);
        let [b1, b2, b3] = self.base_mm;
        [end[0] - b1, end[0] - b2, end[1] - b2, end[1] - b3, end[2] - b3, end[2] - b1].map(|cable| cable.norm())
    }

    /// What the identification is told about the machine.
    pub fn machine(&self) -> Machine<f64> {
        let [p1, p2, p3] = self.home_mm;
        Machine { base_mm: self.base_mm, edges_mm: [p1 - p2, p2 - p3, p3 - p1].map(|edge| edge.norm()) }
    }

    /// What the identification should find.
    pub fn truth(&self) -> Estimate<f64> {
        Estimate { centre_mm: self.centre_mm, radii_mm: self.home_mm.map(|p| p.norm()) }
    }

    /// The truth with every parameter off by up to `deviation_mm`, uniformly.
    pub fn start(&self, rng: &mut ChaCha8Rng, deviation_mm: f64) -> Estimate<f64> {
        let mut start = self.truth();
        start.centre_mm += jitter(rng, deviation_mm);
        for radius in &mut start.radii_mm {
            *radius += rng.random_range(-deviation_mm..=deviation_mm);
        }
        start
    }
}

/// A rotation whose vector has components uniform within `limit_deg` to either side.
pub fn arm(rng: &mut ChaCha8Rng, limit_deg: f64) -> Rotation3<f64> {
    Rotation3::new(jitter(rng, limit_deg.to_radians()))
}

/// A tilt of exactly `tilt_deg` in a random direction, after a torsion about the arm within `torsion_deg`.
pub fn tilted(rng: &mut ChaCha8Rng, tilt_deg: f64, torsion_deg: f64) -> Rotation3<f64> {
    let azimuth = rng.random_range(0.0..core::f64::consts::TAU);
    let tilt = Rotation3::new(Vector3::new(azimuth.cos(), azimuth.sin(), 0.0) * tilt_deg.to_radians());
    tilt * Rotation3::new(Vector3::z() * rng.random_range(-torsion_deg..=torsion_deg).to_radians())
}

/// A pose set of a machine, with arms as [`arm`] draws them.
pub fn poses(worn: &Worn, rng: &mut ChaCha8Rng, count: usize, limit_deg: f64) -> Vec<Lengths<f64>> {
    (0..count).map(|_| worn.lengths_mm(&arm(rng, limit_deg))).collect()
}

/// A pose set that turns about one axis only, by up to `limit_deg` to either side of a first arm.
pub fn one_axis(worn: &Worn, rng: &mut ChaCha8Rng, count: usize, limit_deg: f64) -> Vec<Lengths<f64>> {
    let first = arm(rng, 10.0);
    let axis = arm(rng, 180.0) * Vector3::z_axis();
    let mut turned = || Rotation3::from_axis_angle(&axis, rng.random_range(-limit_deg..=limit_deg).to_radians());
    (0..count).map(|_| worn.lengths_mm(&(turned() * first))).collect()
}

/// The point in the mirror of the xz plane.
pub fn mirrored(point: Vector3<f64>) -> Vector3<f64> {
    Vector3::new(point.x, -point.y, point.z)
}

/// The six parameters in the paper's order, mm.
pub fn parameters(estimate: &Estimate<f64>) -> [f64; 6] {
    let (o, p) = (estimate.centre_mm, estimate.radii_mm);
    [o.x, o.y, o.z, p[0], p[1], p[2]]
}

/// The estimate with these six parameters, mm.
pub fn estimate([x, y, z, p1, p2, p3]: [f64; 6]) -> Estimate<f64> {
    Estimate { centre_mm: Vector3::new(x, y, z), radii_mm: [p1, p2, p3] }
}

/// The largest difference between two estimates' parameters, mm.
pub fn distance(one: &Estimate<f64>, other: &Estimate<f64>) -> f64 {
    parameters(one).iter().zip(parameters(other)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn jitter(rng: &mut ChaCha8Rng, limit: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| rng.random_range(-limit..=limit))
}

fn on_circle(radius: f64, azimuth_deg: f64, height: f64) -> Vector3<f64> {
    let azimuth = azimuth_deg.to_radians();
    Vector3::new(radius * azimuth.cos(), radius * azimuth.sin(), height)
}
