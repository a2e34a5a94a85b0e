//! A million noise-free sets without a start: is the centre always found, or refused with cause?

use super::findings::{Findings, Plan, Problem, Table, Target, percent, short};
use super::scene::{Reach, Scene, Spread};
use super::solve::{Knowledge, Precision, solve};
use super::statistics::largest;
use super::{Study, trials};
use glenoid::identification::Refusal;
use rand::Rng;

/// Random rigs, the usual reach.
pub const MILLION: Study = Study {
    name: "million",
    about: "noise-free, no start, random rigs: identified to 1e-6 mm or refused with cause",
    trials: 1_000_000,
    run: |plan| Experiment { name: "million", spread: Spread::ANY_RIG, reach: Reach::USUAL }.run(plan),
};

/// Random rigs with the centre far off, the whole reach of a shoulder.
pub const EXTREMES: Study = Study {
    name: "extremes",
    about: "the same with the centre off by 60 mm, tilt and torsion to 60 degrees: no wrong accept",
    trials: 1_000_000,
    run: |plan| Experiment { name: "extremes", spread: Spread::EXTREME, reach: Reach::EXTREME }.run(plan),
};

/// Ranges of the number of poses that are reported separately, least and most.
const BUCKETS: [(usize, usize); 7] = [(3, 3), (4, 4), (5, 5), (6, 6), (7, 9), (10, 20), (21, 100)];

/// Largest error of any parameter with which a set counts as identified, mm.
const EXACT_F64_MM: f64 = 1e-6;
/// The same in single precision.
const EXACT_F32_MM: f64 = 1e-2;

struct Experiment {
    name: &'static str,
    spread: Spread,
    reach: Reach,
}

/// How a set ended.
#[derive(Clone, Copy)]
enum Ending {
    /// With the largest error of any of the six parameters, mm.
    Identified(f64),
    /// One axis, too alike, weak, or something else.
    Refused(Cause),
}

#[derive(Clone, Copy, PartialEq)]
enum Cause {
    OneAxis,
    TooAlike,
    Weak,
    HangsOnOnePose,
    /// With the refusal's code.
    Other(u8),
}

struct Trial {
    poses: usize,
    double: Ending,
    single: Ending,
    /// In double precision, with every pose taken as sound.
    trusting: Ending,
}

fn ending<T: Precision>(scene: &Scene, poses_mm: &[[f64; 6]], knowledge: Knowledge) -> Ending {
    match solve::<T>(scene, poses_mm, knowledge) {
        Ok(answer) => Ending::Identified(answer.largest_error_mm(scene)),
        Err(refusal) => Ending::Refused(match refusal {
            Refusal::OneAxis { .. } => Cause::OneAxis,
            Refusal::TooAlike { .. } => Cause::TooAlike,
            Refusal::Weak { .. } => Cause::Weak,
            Refusal::NotRedundant { .. } => Cause::HangsOnOnePose,
            other => Cause::Other(other.code()),
        }),
    }
}

impl Experiment {
    fn run(&self, plan: &Plan) -> Result<Findings, Problem> {
        let outcomes = trials::run(plan.seed, self.name, plan.trials, |_, mut random| {
            let scene = Scene::random(&mut random, &self.spread)?;
            let poses = random.random_range(3..=100usize);
            let poses_mm: Vec<_> = (0..poses).map(|_| scene.lengths(&self.reach.rotation(&mut random))).collect();
            let double = ending::<f64>(&scene, &poses_mm, Knowledge::Noise);
            let single = ending::<f32>(&scene, &poses_mm, Knowledge::Noise);
            // Trust changes nothing but that refusal.
            let trusting = match double {
                Ending::Refused(Cause::HangsOnOnePose) => {
                    ending::<f64>(&scene, &poses_mm, Knowledge::NoiseAndSoundPoses)
                }
                other => other,
            };
            Ok(Trial { poses, double, single, trusting })
        });
        let trials = outcomes.into_iter().collect::<Result<Vec<_>, Problem>>()?;
        let targets = if self.name == MILLION.name { million_targets(&trials) } else { extreme_targets(&trials) };
        Ok(Findings {
            method: self.method(),
            tables: vec![
                table(self.name, &trials, f64::NAME, EXACT_F64_MM, |trial| trial.double),
                table(self.name, &trials, f32::NAME, EXACT_F32_MM, |trial| trial.single),
                table(self.name, &trials, "f64, every pose taken for sound", EXACT_F64_MM, |trial| trial.trusting),
            ],
            targets,
            ..Findings::default()
        })
    }

    fn method(&self) -> String {
        let (least, most) = self.spread.base_radius_mm;
        format!(
            "A trial is one set of 3 to 100 random poses (tilt to {}°, torsion ±{}°) without noise on a random rig: base radius \
             {least}-{most} mm, every attachment point and end-point up to ±{} mm and the centre up to ±{} mm off along \
             each axis. The solver gets no start. Errors are the largest of the six parameters'. A set depends on one pose when no \
             other could contradict it, were it wrong: every set of three does, and is refused unless all poses are taken as \
             sound.",
            self.reach.tilt_deg, self.reach.torsion_deg, self.spread.points_mm, self.spread.centre_mm
        )
    }
}

fn million_targets(trials: &[Trial]) -> Vec<Target> {
    let failures = trials.iter().filter(|trial| fails(trial.double, EXACT_F64_MM)).count();
    let single: Vec<_> = trials.iter().filter(|trial| trial.poses >= 6).collect();
    let failures_single = single.iter().filter(|trial| fails(trial.single, EXACT_F32_MM)).count();
    vec![
        Target::at_most(
            "failures, f64 (neither within 1e-6 mm nor refused as degenerate or weak)",
            0.0,
            failures as f64,
        ),
        Target::at_most("refusals at m >= 4, f64, %", 1.0, refused_percent(trials, 4, |trial| trial.double)),
        Target::at_most("failures at m >= 6, f32 (beyond 1e-2 mm, or refused otherwise)", 0.0, failures_single as f64),
    ]
}

fn extreme_targets(trials: &[Trial]) -> Vec<Target> {
    let wrong = trials.iter().filter(|trial| is_wrong(trial.double, EXACT_F64_MM)).count();
    let single = trials.iter().filter(|trial| trial.poses >= 6 && is_wrong(trial.single, EXACT_F32_MM)).count();
    vec![
        Target::at_most("wrong accepts, f64 (further off than 1e-6 mm)", 0.0, wrong as f64),
        Target::at_most("refusals at m >= 6, f64, %", 2.0, refused_percent(trials, 6, |trial| trial.double)),
        Target::at_most("wrong accepts at m >= 6, f32 (further off than 1e-2 mm)", 0.0, single as f64),
    ]
}

fn is_wrong(ending: Ending, exact_mm: f64) -> bool {
    // A NaN is wrong too.
    matches!(ending, Ending::Identified(error) if !(error <= exact_mm))
}

fn fails(ending: Ending, exact_mm: f64) -> bool {
    is_wrong(ending, exact_mm) || matches!(ending, Ending::Refused(Cause::Other(_)))
}

fn refused_percent(trials: &[Trial], least_poses: usize, of: impl Fn(&Trial) -> Ending) -> f64 {
    let enough = || trials.iter().filter(|trial| trial.poses >= least_poses);
    let refused = enough().filter(|trial| matches!(of(trial), Ending::Refused(_))).count();
    100.0 * refused as f64 / enough().count() as f64
}

fn table(study: &str, trials: &[Trial], precision: &str, exact_mm: f64, of: impl Fn(&Trial) -> Ending) -> Table {
    let name = match (study, precision) {
        ("million", "f64") => "million-f64",
        ("million", "f32") => "million-f32",
        ("million", _) => "million-trusting",
        (_, "f64") => "extremes-f64",
        (_, "f32") => "extremes-f32",
        _ => "extremes-trusting",
    };
    let columns = [
        "poses",
        "sets",
        "identified",
        "largest error (mm)",
        "beyond tolerance",
        "one axis",
        "too alike",
        "weak",
        "depends on one pose",
        "other refusals",
        "refused",
    ];
    let mut table = Table::new(name, format!("Outcomes in {precision}, tolerance {} mm", short(exact_mm)), &columns);
    for (least, most) in BUCKETS {
        let endings: Vec<_> = trials.iter().filter(|trial| (least..=most).contains(&trial.poses)).map(&of).collect();
        let errors = || endings.iter().filter_map(|e| if let Ending::Identified(mm) = e { Some(*mm) } else { None });
        let refused = |by: fn(Cause) -> bool| {
            endings.iter().filter(|e| matches!(e, Ending::Refused(cause) if by(*cause))).count()
        };
        table.push([
            if least == most { least.to_string() } else { format!("{least}-{most}") },
            endings.len().to_string(),
            errors().count().to_string(),
            short(largest(errors())),
            endings.iter().filter(|e| is_wrong(**e, exact_mm)).count().to_string(),
            refused(|cause| cause == Cause::OneAxis).to_string(),
            refused(|cause| cause == Cause::TooAlike).to_string(),
            refused(|cause| cause == Cause::Weak).to_string(),
            refused(|cause| cause == Cause::HangsOnOnePose).to_string(),
            refused(|cause| matches!(cause, Cause::Other(_))).to_string(),
            percent(refused(|_| true), endings.len()),
        ]);
    }
    table
}
