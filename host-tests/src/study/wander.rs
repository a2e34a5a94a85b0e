//! Not a ball: a joint centre that migrates from pose to pose at random, or drifts with the arm's elevation.

use super::findings::{Findings, Plan, Problem, Table, Target, percent, short};
use super::scene::{Reach, Scene, normal, with_noise};
use super::solve::{Knowledge, solve};
use super::statistics::quantile;
use super::{Study, trials};
use crate::plot::{Axis, Chart, Series};
use glenoid::identification::Refusal;
use nalgebra::{Rotation3, Vector3};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// Detection of a centre that is none.
pub const STUDY: Study = Study {
    name: "wander",
    about: "a joint centre that migrates or drifts: detection, false alarms, stated size",
    trials: 3_000,
    run,
};

/// Noise of every length, uniform within this to either side, mm.
const NOISE_MM: f64 = 0.1;
/// Its standard deviation, mm: 0.1 / √3.
const NOISE_SIGMA_MM: f64 = 0.057_735_026_918_962_58;
/// Standard deviations of the migration along each axis, mm.
const MIGRATIONS_MM: [f64; 9] = [0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.5, 1.0, 2.0];
/// Drifts at 45 degrees of elevation, mm.
const DRIFTS_MM: [f64; 6] = [0.2, 0.5, 1.0, 2.0, 4.0, 6.0];
const POSES: [usize; 3] = [10, 30, 100];
/// A sound set is to be refused no more often than this.
const FALSE_ALARM_RATE: f64 = 1e-4;
/// Sound sets for each set at any other level: the rate is small.
const SOUND_SETS: u64 = 30;

/// How the centre moves.
#[derive(Clone, Copy)]
enum Motion {
    /// Not at all: a ball joint. Noise is uniform like everywhere, or normal with the same variance.
    None { normal_noise: bool },
    /// At random from pose to pose, normally distributed, this much along each axis, mm.
    Wander(f64),
    /// Upwards (z of {B}) in proportion to the arm's elevation, this much at 45 degrees, mm.
    Drift(f64),
}

#[derive(Clone, Copy)]
enum Ending {
    /// Error of the centre against its mean place, mm; whether it is beyond 5 sigma + 0.05 mm; poses left out.
    Accepted {
        error_mm: f64,
        is_false: bool,
        left_out: usize,
    },
    /// With the stated migration, mm.
    NotABall(f64),
    Otherwise,
}

fn run(plan: &Plan) -> Result<Findings, Problem> {
    let mut table = Table::new("wander", "A centre that migrates, normally distributed along each axis", &COLUMNS);
    let columns = ["poses", "noise", "sets", "refused", "share", "accepted with poses left out"];
    let mut sound = Table::new("false-alarms", "Sound sets, of a ball joint", &columns);
    let mut drift_table = Table::new("drift", "A centre that drifts with elevation (mm at 45°)", &COLUMNS);
    let mut chart = Chart::new(
        "Detection of a migrating joint centre",
        Axis::log10("migration along each axis, standard deviation (mm)"),
        Axis::linear("sets refused (%)").including(0.0).including(100.0),
    )
    .subtitled(&format!("noise ±0.1 mm, base radius 150 mm, seed {}, {} sets a point", plan.seed, plan.trials));
    let mut targets = Vec::new();
    for poses in POSES {
        for (noise, normal_noise) in [("uniform", false), ("normal", true)] {
            let endings = endings(plan.seed, plan.trials * SOUND_SETS, poses, Motion::None { normal_noise })?;
            targets.push(false_alarm_target(poses, noise, refused(&endings), endings.len()));
            sound.push(sound_row(poses, noise, &endings));
        }
        let mut detected = Vec::new();
        for migration_mm in MIGRATIONS_MM {
            let endings = endings(plan.seed, plan.trials, poses, Motion::Wander(migration_mm))?;
            detected.push((migration_mm, 100.0 * refused(&endings) as f64 / endings.len() as f64));
            table.push(row(poses, migration_mm, &endings));
        }
        chart = chart.with(Series::line(&format!("{poses} poses"), detected));
        for drift_mm in DRIFTS_MM {
            let endings = endings(plan.seed, plan.trials, poses, Motion::Drift(drift_mm))?;
            drift_table.push(row(poses, drift_mm, &endings));
        }
    }
    Ok(Findings {
        method: METHOD.to_string(),
        tables: vec![sound, table, drift_table],
        targets,
        figures: vec![("wander", Box::new(chart))],
        ..Findings::default()
    })
}

const METHOD: &str = "A trial is a set of random poses (tilt to 45°, torsion ±30°) with noise uniform within ±0.1 mm on the 150 mm rig, the \
    centre up to ±20 mm and the cuff up to ±10 mm off along each axis. In every pose the centre is elsewhere. Errors are against the \
    mean of its places. A false accept is further off than five sigmas plus 0.05 mm. Of sound sets there are thirty times as \
    many, and as many again with normal noise, which the test is made for.";

fn refused(endings: &[Ending]) -> usize {
    endings.iter().filter(|ending| !matches!(ending, Ending::Accepted { .. })).count()
}

/// The rate itself cannot be met exactly by a count: twice the Poisson standard deviation is allowed.
fn false_alarm_target(poses: usize, noise: &str, refused: usize, sets: usize) -> Target {
    let expected = FALSE_ALARM_RATE * sets as f64;
    let most = libm::floor(expected + 2.0 * libm::sqrt(expected));
    let stated = format!("1 in 10 000 are stated, {} and 2 sigma allowed", short(expected));
    Target::at_most(
        format!("{poses} poses, {noise} noise: false alarms in {sets} sets ({stated})"),
        most,
        refused as f64,
    )
}

fn sound_row(poses: usize, noise: &str, endings: &[Ending]) -> [String; 6] {
    let reduced = endings.iter().filter(|e| matches!(e, Ending::Accepted { left_out: 1.., .. })).count();
    [
        poses.to_string(),
        noise.to_string(),
        endings.len().to_string(),
        refused(endings).to_string(),
        percent(refused(endings), endings.len()),
        reduced.to_string(),
    ]
}

fn endings(seed: u64, trials: u64, poses: usize, motion: Motion) -> Result<Vec<Ending>, Problem> {
    let ideal = Scene::table_1(150.0)?;
    let experiment = match motion {
        Motion::None { normal_noise } => format!("sound m {poses} {normal_noise}"),
        Motion::Wander(mm) => format!("wander m {poses} {mm}"),
        Motion::Drift(mm) => format!("drift m {poses} {mm}"),
    };
    Ok(trials::run(seed, &experiment, trials, |_, random| trial(&ideal, random, poses, motion)))
}

fn trial(ideal: &Scene, mut random: ChaCha8Rng, poses: usize, motion: Motion) -> Ending {
    let mut scene = ideal.worn(&mut random, 20.0, 10.0);
    let mut mean = Vector3::zeros();
    let mut poses_mm = Vec::with_capacity(poses);
    for _ in 0..poses {
        let rotation = Reach::USUAL.rotation(&mut random);
        let centre = scene.centre_mm + motion.displacement(&rotation, &mut random);
        mean += centre / poses as f64;
        let lengths_mm = scene.lengths_about(&centre, &rotation);
        poses_mm.push(match motion {
            Motion::None { normal_noise: true } => lengths_mm.map(|mm| mm + normal(&mut random) * NOISE_SIGMA_MM),
            _ => with_noise(lengths_mm, &mut random, NOISE_MM),
        });
    }
    scene.centre_mm = mean;
    match solve::<f64>(&scene, &poses_mm, Knowledge::Noise) {
        Ok(answer) => {
            let error_mm = libm::sqrt(answer.centre_error_mm(&scene).norm_squared());
            let is_false = !(error_mm <= 5.0 * answer.centre_sigma_mm() + 0.05);
            Ending::Accepted { error_mm, is_false, left_out: answer.rejected.len() }
        }
        Err(Refusal::CentreNotFixed { migration_mm }) => Ending::NotABall(f64::from(migration_mm)),
        Err(_) => Ending::Otherwise,
    }
}

impl Motion {
    fn displacement(self, rotation: &Rotation3<f64>, random: &mut impl Rng) -> Vector3<f64> {
        match self {
            Self::None { .. } => Vector3::zeros(),
            Self::Wander(mm) => Vector3::from_fn(|_, _| normal(random)) * mm,
            Self::Drift(mm) => {
                // The arm lies along z at home: its elevation is the angle by which z is tilted.
                let elevation = libm::acos(rotation.matrix()[(2, 2)].clamp(-1.0, 1.0));
                Vector3::z() * (mm * elevation.to_degrees() / 45.0)
            }
        }
    }
}

const COLUMNS: [&str; 9] = [
    "poses",
    "size (mm)",
    "sets",
    "refused",
    "as wander",
    "stated size, median (mm)",
    "accepted with poses left out",
    "error when accepted, 95 % (mm)",
    "false accepts",
];

fn row(poses: usize, size_mm: f64, endings: &[Ending]) -> [String; 9] {
    let (mut stated, mut errors) = (Vec::new(), Vec::new());
    let (mut reduced, mut falsely) = (0, 0);
    for ending in endings {
        match *ending {
            Ending::NotABall(mm) => stated.push(mm),
            Ending::Accepted { error_mm, is_false, left_out } => {
                errors.push(error_mm);
                reduced += usize::from(left_out > 0);
                falsely += usize::from(is_false);
            }
            Ending::Otherwise => {}
        }
    }
    [
        poses.to_string(),
        short(size_mm),
        endings.len().to_string(),
        percent(endings.len() - errors.len(), endings.len()),
        percent(stated.len(), endings.len()),
        if stated.is_empty() { "-".to_string() } else { short(quantile(&mut stated, 0.5)) },
        percent(reduced, endings.len()),
        if errors.is_empty() { "-".to_string() } else { short(quantile(&mut errors, 0.95)) },
        falsely.to_string(),
    ]
}
