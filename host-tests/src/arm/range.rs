//! How far a module goes, as the poses of its log show, and a seeded grid of poses within that.

use nalgebra::{Matrix3, Rotation3, Unit, UnitQuaternion, Vector2, Vector3};
use rand::Rng;
use std::f64::consts::TAU;

/// Tilts on each ring about the middle, the innermost first; the rings are equally far apart.
const TILTS: [usize; 3] = [6, 12, 18];
/// Torsions with every tilt, from the least to the most.
const TORSIONS: usize = 3;
/// Lines that bound the tilts, in all directions.
const LINES: usize = 120;
/// Angles of a hinge.
const ANGLES: usize = 30;

/// The range of a ball.
pub struct BallRange {
    /// The middle of its rotations.
    middle: Rotation3<f64>,
    /// Two directions across the limb in the middle, and along it: the z axis of the platform.
    axes: Matrix3<f64>,
    /// How far the limb is tilted in each pose, along those two, rad.
    tilts_rad: Vec<Vector2<f64>>,
    /// Least and largest turn about the limb, rad.
    torsion_rad: (f64, f64),
}

impl BallRange {
    /// What these rotations ({P} to {B}) reach.
    pub fn of(rotations: &[Matrix3<f64>]) -> Self {
        let near = rotations.first().map_or_else(Rotation3::identity, |one| Rotation3::from_matrix_unchecked(*one));
        let middle = Rotation3::from_matrix_eps(&rotations.iter().sum(), 1e-12, 100, near);
        let along = middle * Vector3::z();
        let across = along.cross(&(middle * Vector3::x())).normalize();
        let axes = Matrix3::from_columns(&[across.cross(&along), across, along]);
        let mut range = Self { middle, axes, tilts_rad: Vec::new(), torsion_rad: (0.0, 0.0) };
        for rotation in rotations {
            let turned =
                UnitQuaternion::from_rotation_matrix(&(Rotation3::from_matrix_unchecked(*rotation) * middle.inverse()));
            // Swing and twist: turned = tilt · torsion.
            let torsion = 2.0 * turned.imag().dot(&along).atan2(turned.w);
            let torsion = if torsion.abs() > TAU / 2.0 { torsion - TAU * torsion.signum() } else { torsion };
            let tilt = turned * UnitQuaternion::from_axis_angle(&Unit::new_unchecked(along), -torsion);
            range.tilts_rad.push((axes.transpose() * tilt.scaled_axis()).xy());
            range.torsion_rad = (range.torsion_rad.0.min(torsion), range.torsion_rad.1.max(torsion));
        }
        range
    }

    /// Rotations ({P} to {B}) all over it: the limb tilted within the convex hull of the tilts that the range was made of, and
    /// turned about itself no further than there.
    pub fn grid(&self, random: &mut impl Rng) -> Vec<Matrix3<f64>> {
        let mut tilts = vec![Vector2::zeros()];
        for (ring, count) in TILTS.iter().enumerate() {
            let share = (ring + 1) as f64 / TILTS.len() as f64;
            let first: f64 = random.random_range(0.0..1.0);
            for place in 0..*count {
                let (sin, cos) = ((first + place as f64) / *count as f64 * TAU).sin_cos();
                let direction = Vector2::new(cos, sin);
                tilts.push(direction * (self.farthest_rad(&direction) * share));
            }
        }
        let (least, most) = self.torsion_rad;
        let torsion = |step: usize| least + (most - least) * step as f64 / (TORSIONS - 1) as f64;
        let steps = |tilt| (0..TORSIONS).map(move |step| (tilt, torsion(step)));
        tilts.into_iter().flat_map(steps).map(|(tilt, torsion)| self.rotation(&tilt, torsion)).collect()
    }

    /// How far the convex hull of the tilts goes in a direction: no line that has all of them on one side is crossed.
    fn farthest_rad(&self, direction: &Vector2<f64>) -> f64 {
        let lines = (0..LINES).filter_map(|line| {
            let (sin, cos) = (line as f64 / LINES as f64 * TAU).sin_cos();
            let across = Vector2::new(cos, sin);
            let support = self.tilts_rad.iter().map(|tilt| tilt.dot(&across)).fold(0.0, f64::max);
            let along = across.dot(direction);
            (along > 1e-3).then(|| support / along)
        });
        lines.fold(f64::INFINITY, f64::min)
    }

    fn rotation(&self, tilt_rad: &Vector2<f64>, torsion_rad: f64) -> Matrix3<f64> {
        let turned = |x: f64, y: f64, z: f64| Rotation3::from_scaled_axis(self.axes * Vector3::new(x, y, z));
        (turned(tilt_rad.x, tilt_rad.y, 0.0) * turned(0.0, 0.0, torsion_rad) * self.middle).into_inner()
    }
}

/// Angles all over the range of those that a hinge has been at, one in each of equal parts, rad.
pub fn hinge_grid(angles_rad: &[f64], random: &mut impl Rng) -> Vec<f64> {
    let least = angles_rad.iter().copied().fold(f64::INFINITY, f64::min);
    let most = angles_rad.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let part = (most - least) / ANGLES as f64;
    (0..ANGLES).map(|k| least + part * (k as f64 + random.random_range(0.0..1.0))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    /// A limb that was tilted by up to 40 degrees to one side, 10 to the others, and turned from -5 to 25 degrees.
    #[test]
    fn no_candidate_goes_beyond_the_poses() {
        let home = Rotation3::from_euler_angles(0.4, -0.2, 1.0);
        let at = |x: f64, y: f64, torsion: f64| {
            let swing = home * Rotation3::from_scaled_axis(Vector3::new(x, y, 0.0).map(f64::to_radians));
            (swing * Rotation3::from_scaled_axis(Vector3::z() * torsion.to_radians())).into_inner()
        };
        let poses =
            [at(40.0, 0.0, 0.0), at(-10.0, 0.0, 25.0), at(0.0, 10.0, -5.0), at(0.0, -10.0, 10.0), at(0.0, 0.0, 10.0)];
        let grid = BallRange::of(&poses).grid(&mut ChaCha8Rng::seed_from_u64(1));
        assert_eq!(grid.len(), 37 * 3);
        // From home, in the frame of the limb: its z axis says the tilt.
        let tilts: Vec<_> = grid
            .iter()
            .map(|rotation| {
                let limb = home.inverse() * (rotation * Vector3::z());
                // Tilted about x, it moves along -y.
                [limb.y, limb.x].map(|sine| sine.asin().to_degrees())
            })
            .collect();
        for [y, x] in &tilts {
            // Within the quadrilateral that the poses span, but for what angles differ from their sines and the torsion.
            let reach = y.min(0.0) / -40.0 + y.max(0.0) / 10.0 + x.abs() / 10.0;
            assert!(reach < 1.15, "{y} {x}");
        }
        let most = |k: usize, sign: f64| tilts.iter().map(|tilt| tilt[k] * sign).fold(0.0, f64::max);
        for (k, sign, limit) in [(0, -1.0, 40.0), (0, 1.0, 10.0), (1, 1.0, 10.0), (1, -1.0, 10.0)] {
            let most = most(k, sign);
            // Swing and torsion are those about the middle. Twenty degrees lie between two tilts of the outer ring.
            assert!(most < limit + 2.0 && most > limit * 0.5, "{k} {sign}: {most} {limit}");
        }
    }

    #[test]
    fn angles_are_spread_over_the_range_of_the_poses() {
        let angles = hinge_grid(&[-1.0, 0.5, 2.0], &mut ChaCha8Rng::seed_from_u64(1));
        assert!(angles.windows(2).all(|pair| pair[0] < pair[1]));
        assert!((-1.0..-0.9).contains(&angles[0]) && (1.9..2.0).contains(&angles[29]), "{angles:?}");
    }
}
