//! Single precision against double: the same sets, both solvers.

use super::findings::{Findings, Plan, Problem, Table, percent, short};
use super::scene::{Reach, Scene, Spread, with_noise};
use super::solve::{Knowledge, solve};
use super::statistics::{largest, quantile};
use super::{Study, trials};
use rand::Rng;

/// f32 against f64.
pub const STUDY: Study =
    Study { name: "precision", about: "f32 against f64 on the same sets, with and without noise", trials: 50_000, run };

const BUCKETS: [(usize, usize); 6] = [(3, 3), (4, 5), (6, 9), (10, 20), (21, 50), (51, 100)];

/// One set in both precisions.
struct Trial {
    poses: usize,
    /// Distance between the two centres, and the standard deviation, mm; `None` when either refused.
    both: Option<(f64, f64)>,
    /// One accepted and the other refused.
    disagree: bool,
}

fn run(plan: &Plan) -> Result<Findings, Problem> {
    let columns = [
        "noise",
        "poses",
        "sets",
        "identified by both",
        "one refuses",
        "difference, median (mm)",
        "99 % (mm)",
        "largest (mm)",
        "largest, in sigmas",
    ];
    let mut table = Table::new("precision", "Distance between the centres found in f32 and in f64", &columns);
    for (name, noise_mm) in [("none", 0.0), ("±0.1 mm", 0.1)] {
        let outcomes = trials::run(plan.seed, &format!("precision {name}"), plan.trials, |_, mut random| {
            let scene = Scene::random(&mut random, &Spread::ANY_RIG)?;
            let poses =
                if random.random_bool(0.5) { random.random_range(3..=20) } else { random.random_range(21..=100usize) };
            let poses_mm: Vec<_> = (0..poses)
                .map(|_| with_noise(scene.lengths(&Reach::USUAL.rotation(&mut random)), &mut random, noise_mm))
                .collect();
            Ok(trial(&scene, &poses_mm))
        });
        let trials = outcomes.into_iter().collect::<Result<Vec<_>, Problem>>()?;
        for (least, most) in BUCKETS {
            let some: Vec<_> = trials.iter().filter(|trial| (least..=most).contains(&trial.poses)).collect();
            let both: Vec<_> = some.iter().filter_map(|trial| trial.both).collect();
            let mut differences: Vec<_> = both.iter().map(|(difference, _)| *difference).collect();
            table.push([
                name.to_string(),
                if least == most { least.to_string() } else { format!("{least}-{most}") },
                some.len().to_string(),
                both.len().to_string(),
                percent(some.iter().filter(|trial| trial.disagree).count(), some.len()),
                short(quantile(&mut differences, 0.5)),
                short(quantile(&mut differences, 0.99)),
                short(largest(differences.iter().copied())),
                short(largest(both.iter().map(|(difference, sigma)| difference / sigma))),
            ]);
        }
    }
    Ok(Findings { method: METHOD.to_string(), tables: vec![table], ..Findings::default() })
}

const METHOD: &str = "A trial is a set of 3 to 100 random poses (half of them at most 20; tilt to 45°, torsion ±30°) on a random rig (base radius \
    120-350 mm, everything up to ±20 mm off), solved in both precisions. The single one gets the lengths rounded to it. Sigmas \
    are those of ±0.1 mm of noise, root of the summed variances of the centre's coordinates.";

fn trial(scene: &Scene, poses_mm: &[[f64; 6]]) -> Trial {
    let poses = poses_mm.len();
    let (double, single) =
        (solve::<f64>(scene, poses_mm, Knowledge::Noise), solve::<f32>(scene, poses_mm, Knowledge::Noise));
    let disagree = double.is_ok() != single.is_ok();
    let both = double.ok().zip(single.ok()).map(|(double, single)| {
        let difference = double.centre_error_mm(scene) - single.centre_error_mm(scene);
        (libm::sqrt(difference.norm_squared()), double.centre_sigma_mm())
    });
    Trial { poses, both, disagree }
}
