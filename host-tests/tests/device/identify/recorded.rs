//! Logs as a rehabilitator would record them, from arms that are turned and measured, never from the solver.

use nalgebra::{Matrix3, Rotation3, Vector3};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The centre in every log made here, mm: the shoulder's nominal one, moved.
pub const CENTRE_MM: [f64; 3] = [7.0, -4.0, 155.0];
/// The radii in every log made here, mm (Table I).
pub const RADII_MM: [f64; 3] = [140.8; 3];

/// A recorded log, mm.
pub type Log = Vec<[f64; 6]>;

/// The lengths at a rotation of the arm: end-points on a circle in a plane 96 mm from the centre, attachment points
/// on a circle of 150 mm (the command's default rig).
fn lengths(centre_mm: [f64; 3], arm: Rotation3<f64>) -> [f64; 6] {
    let circle =
        |radius: f64, azimuth: f64| Vector3::new(azimuth.to_radians().cos(), azimuth.to_radians().sin(), 0.0) * radius;
    let across = (RADII_MM[0] * RADII_MM[0] - 96.0 * 96.0).sqrt();
    let [b1, b2, b3] = [0.0, 120.0, 240.0].map(|azimuth| circle(150.0, azimuth));
    let [p1, p2, p3] = [60.0, 180.0, 300.0]
        .map(|azimuth| Vector3::from(centre_mm) + arm * (circle(across, azimuth) + Vector3::z() * 96.0));
    [p1 - b1, p1 - b2, p2 - b2, p2 - b3, p3 - b3, p3 - b1].map(|cable| cable.norm())
}

/// Poses tilted by up to 45 degrees and turned by up to 30, each length wrong by up to `noise_mm`, uniformly.
pub fn shoulder(seed: u64, poses: usize, noise_mm: f64) -> Log {
    wandering(seed, poses, noise_mm, 0.0)
}

/// The same from a joint whose centre goes to and fro along x, by `amplitude_mm` to either side.
pub fn wandering(seed: u64, poses: usize, noise_mm: f64, amplitude_mm: f64) -> Log {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    (0..poses)
        .map(|pose| {
            let azimuth = random.random_range(0.0..std::f64::consts::TAU);
            let tilt = random.random_range(0f64..=45.0).to_radians();
            let torsion = random.random_range(-30f64..=30.0).to_radians();
            let arm = Rotation3::new(Vector3::new(azimuth.cos(), azimuth.sin(), 0.0) * tilt)
                * Rotation3::new(Vector3::z() * torsion);
            let [x, y, z] = CENTRE_MM;
            let centre_mm = [x + (pose as f64 * 2.4).sin() * amplitude_mm, y, z];
            lengths(centre_mm, arm).map(|length| length + random.random_range(-1.0..=1.0) * noise_mm)
        })
        .collect()
}

/// From a shoulder whose centre moves with the arm's direction by `share` of 12 mm or so, and scatters by 0.35 mm or so.
pub fn moving(seed: u64, poses: usize, tilt_deg: f64, share: f64) -> Log {
    let motion = Matrix3::new(8.0, 20.0, 0.0, -10.0, 12.0, 5.0, 0.0, 25.0, 10.0) * share;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    (0..poses)
        .map(|_| {
            let azimuth = random.random_range(0.0..std::f64::consts::TAU);
            let tilt = random.random_range(0.0..=tilt_deg).to_radians();
            let torsion = random.random_range(-30f64..=30.0).to_radians();
            let arm = Rotation3::new(Vector3::new(azimuth.cos(), azimuth.sin(), 0.0) * tilt)
                * Rotation3::new(Vector3::z() * torsion);
            let scatter = Vector3::from_fn(|_, _| random.random_range(-0.6..=0.6));
            let centre_mm = Vector3::from(CENTRE_MM) + motion * (arm * Vector3::z() - Vector3::z()) + scatter;
            lengths(centre_mm.into(), arm).map(|length| length + random.random_range(-0.1..=0.1))
        })
        .collect()
}

/// The same log with two cables (from 0) exchanged.
pub fn exchanged(log: Log, one: usize, other: usize) -> Log {
    let exchange = |mut row: [f64; 6]| {
        row.swap(one, other);
        row
    };
    log.into_iter().map(exchange).collect()
}

/// The same log from encoders that read `zeros_mm` too much.
pub fn not_homed(log: Log, zeros_mm: [f64; 6]) -> Log {
    log.into_iter().map(|row| std::array::from_fn(|cable| row[cable] + zeros_mm[cable])).collect()
}

/// Poses that turn about one axis through the centre, within 40 degrees to either side.
pub fn about(axis: [f64; 3], poses: usize) -> Log {
    let axis = Vector3::from(axis).normalize();
    (0..poses)
        .map(|pose| {
            let share = pose as f64 / (poses - 1) as f64;
            lengths(CENTRE_MM, Rotation3::new(axis * (80.0 * share - 40.0).to_radians()))
        })
        .collect()
}

/// The log as a file.
pub fn csv(log: &[[f64; 6]]) -> String {
    let rows = log.iter().map(|row| row.map(|length| format!("{length:.6}")).join(",") + "\n");
    "l1,l2,l3,l4,l5,l6\n".to_owned() + &rows.collect::<String>()
}
