//! Pose sets for the tests of the start-free solver: two machines, noise, bad readings.

use super::{Worn, rng};
use host_tests::literal::Lengths;
use nalgebra::{Rotation3, Vector3};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// Standard deviation of the noise that the rigs of [`library::rig`](super::library::rig) declare, mm.
pub const NOISE_MM: f64 = 0.06;

/// The wrist module: base radius 60 mm, centre 62 mm above it, platform 39 mm above the centre, radii 56 mm.
pub fn wrist() -> Worn {
    let around = |radius: f64, azimuth_deg: f64, height: f64| {
        let (sin, cos) = azimuth_deg.to_radians().sin_cos();
        Vector3::new(radius * cos, radius * sin, height)
    };
    let across = (56.0_f64 * 56.0 - 39.0 * 39.0).sqrt();
    Worn {
        base_mm: [0.0, 120.0, 240.0].map(|azimuth| around(60.0, azimuth, 0.0)),
        centre_mm: Vector3::new(0.0, 0.0, 62.0),
        home_mm: [60.0, 180.0, 300.0].map(|azimuth| around(across, azimuth, 39.0)),
    }
}

/// The shoulder of Table I over an assumed base radius of 150 mm.
pub fn shoulder() -> Worn {
    Worn::table_one(150.0)
}

/// Both machines by name. Whatever the solver promises, it promises for both.
pub fn machines() -> [(&'static str, Worn); 2] {
    [("shoulder", shoulder()), ("wrist", wrist())]
}

/// Rotations with a tilt uniform within `tilt_deg` towards any side, after a torsion within `torsion_deg`.
pub fn sweep(rng: &mut ChaCha8Rng, count: usize, tilt_deg: f64, torsion_deg: f64) -> Vec<Rotation3<f64>> {
    let mut one = || {
        let tilt = rng.random_range(0.0..=tilt_deg);
        super::tilted(rng, tilt, torsion_deg)
    };
    (0..count).map(|_| one()).collect()
}

/// The lengths of a machine at each of the rotations, mm.
pub fn lengths_at(worn: &Worn, rotations: &[Rotation3<f64>]) -> Vec<Lengths<f64>> {
    rotations.iter().map(|rotation| worn.lengths_mm(rotation)).collect()
}

/// A sound set without noise: tilt to 45 degrees, torsion to 30 degrees.
pub fn sound(worn: &Worn, seed: u64, count: usize) -> Vec<Lengths<f64>> {
    lengths_at(worn, &sweep(&mut rng(seed), count, 45.0, 30.0))
}

/// The same with normal noise of [`NOISE_MM`].
pub fn noisy(worn: &Worn, seed: u64, count: usize) -> Vec<Lengths<f64>> {
    let mut poses = sound(worn, seed, count);
    add_noise(&mut poses, &mut rng(seed ^ 0xA015E), NOISE_MM);
    poses
}

/// Normal noise on every length, independent, of standard deviation `sigma_mm`.
pub fn add_noise(poses: &mut [Lengths<f64>], rng: &mut ChaCha8Rng, sigma_mm: f64) {
    for length in poses.as_flattened_mut() {
        *length += sigma_mm * normal(rng);
    }
}

/// A normal number of variance one (Box and Muller 1958).
pub fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let (radius, turn): (f64, f64) = (rng.random_range(f64::MIN_POSITIVE..1.0), rng.random());
    (-2.0 * radius.ln()).sqrt() * (turn * core::f64::consts::TAU).cos()
}

/// Plus or minus one.
pub fn sign(rng: &mut ChaCha8Rng) -> f64 {
    if rng.random() { 1.0 } else { -1.0 }
}
