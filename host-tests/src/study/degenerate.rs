//! Motions that cannot determine the centre: are they refused, and is the axis right?

use super::findings::{Findings, Plan, Problem, Table, Target, percent, short};
use super::scene::{Reach, Scene, Spread, normal, symmetric, tilted, with_noise};
use super::solve::{Precision, Told, solve};
use super::statistics::quantile;
use super::{Study, trials};
use crate::wearer::rotation;
use glenoid::identification::Refusal;
use nalgebra::{Rotation3, Vector3};
use rand::Rng;
use std::f64::consts::TAU;

/// Degenerate families.
pub const STUDY: Study = Study {
    name: "degenerate",
    about: "one axis, two rotations, all alike, pure torsion, single plane: refused, the axis right to 1 degree",
    trials: 20_000,
    run,
};

/// A motion that leaves the centre free along an axis, or altogether.
#[derive(Clone, Copy, PartialEq)]
enum Family {
    /// Turns by up to 45 degrees to either side about any axis, from any pose.
    OneAxis,
    /// Two rotations, each again and again.
    TwoRotations,
    /// Turns by up to 2 degrees about any axes, from any pose.
    Alike,
    /// The arm turns about its own length alone, by up to 60 degrees.
    Torsion,
    /// The arm swings in one vertical plane, by up to 60 degrees.
    Plane,
}

const FAMILIES: [(&str, Family); 5] = [
    ("one axis", Family::OneAxis),
    ("two rotations", Family::TwoRotations),
    ("within 2°", Family::Alike),
    ("pure torsion", Family::Torsion),
    ("single plane", Family::Plane),
];

/// Smallest angle between two distinct rotations, degrees.
const DISTINCT_DEG: f64 = 10.0;
/// Largest error of the axis, degrees.
const AXIS_DEG: f64 = 1.0;

/// How a set ended.
enum Ending {
    Accepted,
    /// Refused as turning about one axis that is wrong by this angle, degrees (NaN where there is no true one).
    OneAxis(f64),
    TooAlike,
    Weak,
    /// With its code.
    Otherwise(u8),
}

impl Family {
    /// The rotations of a set, and the common axis in {B}, if there is one.
    fn rotations(self, random: &mut impl Rng, poses: usize) -> (Vec<Rotation3<f64>>, Option<Vector3<f64>>) {
        let middle = Reach::USUAL.rotation(random);
        let mut any = |_: ()| Vector3::from_fn(|_, _| normal(random)).normalize();
        match self {
            Self::OneAxis => {
                let axis = any(());
                let turn = |_| rotation(axis, symmetric(random, 45.0).to_radians()) * middle;
                ((0..poses).map(turn).collect(), Some(axis))
            }
            Self::TwoRotations => {
                let axis = any(());
                let angle_deg = random.random_range(DISTINCT_DEG..60.0);
                let other = rotation(axis, f64::to_radians(angle_deg)) * middle;
                // Both occur at least once.
                let pick = |pose| match pose {
                    0 => middle,
                    1 => other,
                    _ if random.random_bool(0.5) => middle,
                    _ => other,
                };
                ((0..poses).map(pick).collect(), Some(axis))
            }
            Self::Alike => {
                let turn = |_| {
                    let axis = Vector3::from_fn(|_, _| normal(random)).normalize();
                    rotation(axis, symmetric(random, 2.0).to_radians()) * middle
                };
                ((0..poses).map(turn).collect(), None)
            }
            Self::Torsion => {
                let turn = |_| rotation(Vector3::z(), symmetric(random, 60.0).to_radians());
                ((0..poses).map(turn).collect(), Some(Vector3::z()))
            }
            Self::Plane => {
                let azimuth = random.random_range(0.0..TAU);
                let turn = |_| tilted(azimuth, symmetric(random, 60.0));
                ((0..poses).map(turn).collect(), Some(Vector3::new(libm::cos(azimuth), libm::sin(azimuth), 0.0)))
            }
        }
    }
}

fn run(plan: &Plan) -> Result<Findings, Problem> {
    let columns = [
        "family",
        "noise",
        "precision",
        "sets",
        "accepted",
        "one axis",
        "too alike",
        "weak",
        "other refusals",
        "axis error, median (°)",
        "99.9 % (°)",
        "largest (°)",
        "within 1°",
    ];
    let mut table = Table::new("degenerate", "Motions that cannot determine the centre", &columns);
    let mut targets = Vec::new();
    for (name, family) in FAMILIES {
        for (noise, noise_mm) in [("none", 0.0), ("±0.1 mm", 0.1)] {
            let experiment = format!("degenerate {name} {noise}");
            let outcomes = trials::run(plan.seed, &experiment, plan.trials, |_, mut random| {
                let scene = if random.random_bool(0.5) {
                    Scene::table_1(150.0)?.worn(&mut random, 20.0, 10.0)
                } else {
                    Scene::random(&mut random, &Spread::ANY_RIG)?
                };
                let poses =
                    if random.random_bool(0.5) { random.random_range(3..=10) } else { random.random_range(11..=100) };
                let (rotations, axis) = family.rotations(&mut random, poses);
                let poses_mm: Vec<_> =
                    rotations.iter().map(|r| with_noise(scene.lengths(r), &mut random, noise_mm)).collect();
                Ok([ending::<f64>(&scene, &poses_mm, axis), ending::<f32>(&scene, &poses_mm, axis)])
            });
            let endings = outcomes.into_iter().collect::<Result<Vec<_>, Problem>>()?;
            for (which, precision) in [f64::NAME, f32::NAME].into_iter().enumerate() {
                let tally = Tally::of(endings.iter().map(|pair| &pair[which]));
                targets.extend(tally.targets(&format!("{name}, noise {noise}, {precision}"), family != Family::Alike));
                table.push(tally.row(name, noise, precision));
            }
        }
    }
    Ok(Findings { method: METHOD.to_string(), tables: vec![table], targets, ..Findings::default() })
}

const METHOD: &str = "A trial is a set of 3 to 100 poses (half of the sets have at most 10) of a degenerate family, half of them on \
    the 150 mm rig and half on random rigs. One axis: turns by up to ±45° about a random axis from a random pose. Two rotations: \
    10 to 60° apart. Within 2°: turns by up to 2° about random axes. Pure torsion: up to ±60°. Single plane: up to ±60° of tilt. \
    The axis error is that of the axis which a refusal for one axis names.";

fn ending<T: Precision>(scene: &Scene, poses_mm: &[[f64; 6]], axis: Option<Vector3<f64>>) -> Ending {
    match solve::<T>(scene, poses_mm, Told::Noise) {
        Ok(_) => Ending::Accepted,
        Err(Refusal::OneAxis { axis: named, .. }) => {
            let named = Vector3::from(named.map(f64::from));
            Ending::OneAxis(axis.map_or(f64::NAN, |axis| angle_deg(&axis, &named)))
        }
        Err(Refusal::TooAlike { .. }) => Ending::TooAlike,
        Err(Refusal::Weak { .. }) => Ending::Weak,
        Err(other) => Ending::Otherwise(other.code()),
    }
}

/// Angle between two axes of either sense, degrees.
fn angle_deg(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    let sine = libm::sqrt(a.cross(b).norm_squared());
    libm::atan2(sine, a.dot(b).abs()).to_degrees()
}

#[derive(Default)]
struct Tally {
    sets: usize,
    accepted: usize,
    one_axis: usize,
    too_alike: usize,
    weak: usize,
    otherwise: usize,
    /// Errors of the named axes, degrees.
    axis_errors: Vec<f64>,
}

impl Tally {
    fn of<'a>(endings: impl Iterator<Item = &'a Ending>) -> Self {
        let mut tally = Self::default();
        for ending in endings {
            tally.sets += 1;
            match ending {
                Ending::Accepted => tally.accepted += 1,
                Ending::OneAxis(error) => {
                    tally.one_axis += 1;
                    if !error.is_nan() {
                        tally.axis_errors.push(*error);
                    }
                }
                Ending::TooAlike => tally.too_alike += 1,
                Ending::Weak => tally.weak += 1,
                Ending::Otherwise(_) => tally.otherwise += 1,
            }
        }
        tally
    }

    fn right(&self) -> usize {
        self.axis_errors.iter().filter(|error| **error <= AXIS_DEG).count()
    }

    fn row(&self, family: &str, noise: &str, precision: &str) -> [String; 13] {
        let mut errors = self.axis_errors.clone();
        let mut error = |share| if errors.is_empty() { "-".to_string() } else { short(quantile(&mut errors, share)) };
        [
            family.to_string(),
            noise.to_string(),
            precision.to_string(),
            self.sets.to_string(),
            self.accepted.to_string(),
            percent(self.one_axis, self.sets),
            percent(self.too_alike, self.sets),
            percent(self.weak, self.sets),
            percent(self.otherwise, self.sets),
            error(0.5),
            error(0.999),
            error(1.0),
            percent(self.right(), self.axis_errors.len()),
        ]
    }

    fn targets(&self, name: &str, has_axis: bool) -> Vec<Target> {
        let refused = 100.0 * (self.sets - self.accepted) as f64 / self.sets as f64;
        let mut targets = vec![Target::at_least(format!("{name}: refused, %"), 100.0, refused)];
        if has_axis {
            let worst = self.axis_errors.iter().fold(0.0, |worst: f64, error| worst.max(*error));
            targets.push(Target::at_most(format!("{name}: largest error of the named axis, degrees"), AXIS_DEG, worst));
        }
        targets
    }
}
