//! Motions that cannot determine the centre: are they refused, and is the axis right?

mod family;

use self::family::{FAMILIES, Family};
use super::findings::{Findings, Plan, Problem, Table, Target, percent, short};
use super::scene::{Scene, Spread, with_noise};
use super::solve::{Knowledge, Precision, solve};
use super::statistics::quantile;
use super::{Study, trials};
use glenoid::identification::Refusal;
use nalgebra::Vector3;
use rand::Rng;

/// Degenerate families.
pub const STUDY: Study = Study {
    name: "degenerate",
    about: "one axis, two rotations, all alike, pure torsion, single plane: refused, the axis right to 1 degree",
    trials: 20_000,
    run,
};

/// Largest error of the axis, degrees.
const AXIS_DEG: f64 = 1.0;

/// How a set ended.
enum Ending {
    Accepted,
    /// Refused as turning about one axis that is wrong by this angle, degrees (NaN where there is no true one).
    OneAxis(f64),
    TooAlike,
    Weak,
    Otherwise,
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
    the 150 mm rig and half on random rigs. One axis: turns by up to ±30° about a random axis from a pose \
    within 20° of tilt and torsion. Two rotations: of the usual reach, at least 10° apart. Within 2°: turns by up to 2° about random axes. Pure torsion: up to ±60°. Single plane: up to ±45° of tilt. \
    The axis error is that of the axis which a refusal for one axis names.";

fn ending<T: Precision>(scene: &Scene, poses_mm: &[[f64; 6]], axis: Option<Vector3<f64>>) -> Ending {
    match solve::<T>(scene, poses_mm, Knowledge::Noise) {
        Ok(_) => Ending::Accepted,
        Err(Refusal::OneAxis { axis: named, .. }) => {
            let named = Vector3::from(named.map(f64::from));
            Ending::OneAxis(axis.map_or(f64::NAN, |axis| angle_deg(&axis, &named)))
        }
        Err(Refusal::TooAlike { .. }) => Ending::TooAlike,
        Err(Refusal::Weak { .. }) => Ending::Weak,
        Err(_) => Ending::Otherwise,
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
                Ending::Otherwise => tally.otherwise += 1,
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
            let worst = quantile(&mut self.axis_errors.clone(), 1.0);
            targets.push(Target::at_most(format!("{name}: largest error of the named axis, degrees"), AXIS_DEG, worst));
        }
        targets
    }
}
