//! What the paper leaves out: how often the plain iteration converges, against the start's error and the base radius.

use super::start::{ELSEWHERE_MM, TOLERANCE_MM, random_start, run};
use crate::plot::HeatMap;
use crate::study::findings::{Findings, Plan, Problem, Table, percent};
use crate::study::scene::{Reach, Scene};
use crate::study::solve::{Knowledge, lengths_in, solve};
use crate::study::{Study, trials};

/// The maps of success.
pub const SUCCESS: Study = Study {
    name: "success",
    about: "success of the plain iteration against start error and base radius; start-free beside it",
    trials: 2_000,
    run: study,
};

const START_ERRORS_MM: [f64; 12] = [5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 45.0, 50.0, 55.0, 60.0];
const BASE_RADII_MM: [f64; 6] = [120.0, 150.0, 200.0, 250.0, 300.0, 350.0];

/// One set of poses: which start errors the plain iteration survived, and whether the start-free solver identified it.
struct Trial {
    plain: [bool; START_ERRORS_MM.len()],
    start_free: bool,
}

fn study(plan: &Plan) -> Result<Findings, Problem> {
    if plan.trials == 0 {
        return Err(Problem::TooFewTrials(1));
    }
    let mut findings = Findings { method: METHOD.to_string(), ..Findings::default() };
    for (poses, table_name, plain_name) in [(3, "success-3", "success-plain-3"), (30, "success-30", "success-plain-30")]
    {
        let columns = [
            "base radius (mm)",
            "±5",
            "±10",
            "±15",
            "±20",
            "±25",
            "±30",
            "±35",
            "±40",
            "±45",
            "±50",
            "±55",
            "±60",
            "start-free",
        ];
        let title =
            format!("Success of the plain iteration by start error (mm), {poses} poses; start-free in the last column");
        let mut table = Table::new(table_name, title, &columns);
        let mut shares = Vec::new();
        for base_radius_mm in BASE_RADII_MM {
            let scene = Scene::table_1(base_radius_mm)?;
            let experiment = format!("success m {poses} R {base_radius_mm}");
            let trials =
                trials::run(plan.seed, &experiment, plan.trials, |_, mut random| trial(&scene, &mut random, poses));
            let count = |of: &dyn Fn(&Trial) -> bool| trials.iter().filter(|trial| of(trial)).count();
            let plain: Vec<_> = (0..START_ERRORS_MM.len()).map(|k| count(&|trial| trial.plain[k])).collect();
            let mut row = vec![base_radius_mm.to_string()];
            row.extend(plain.iter().map(|&converged| percent(converged, trials.len())));
            row.push(percent(count(&|trial| trial.start_free), trials.len()));
            table.rows.push(row);
            shares.push(plain.iter().map(|&converged| converged as f64 / trials.len() as f64).collect());
        }
        findings.tables.push(table);
        let map = HeatMap::new(
            &format!("Success of the paper's plain iteration, {poses} poses"),
            ("start error, ± (mm)", &START_ERRORS_MM),
            ("base radius (mm)", &BASE_RADII_MM),
            "converges to the truth",
            shares,
        );
        let map = map.subtitled(&format!("noise-free, seed {}, {} starts a cell", plan.seed, plan.trials));
        findings.figures.push((plain_name, Box::new(map)));
    }
    Ok(findings)
}

const METHOD: &str = "A trial is a set of random poses (tilt to 45°, torsion ±30°, no noise) on the rig of Table I with one start \
    for each start error: the truth with each parameter off by a number uniform within ±d. Success is convergence to the truth. \
    The start-free solver gets the same poses and no start; what it does not identify it refuses by name. It is told that \
    every pose is sound: otherwise it refuses every set of three, because no other pose could contradict a wrong one.";

fn trial(scene: &Scene, random: &mut rand_chacha::ChaCha8Rng, poses: usize) -> Trial {
    let poses_mm: Vec<_> = (0..poses).map(|_| scene.lengths(&Reach::USUAL.rotation(random))).collect();
    let start_free = solve::<f64>(scene, &poses_mm, Knowledge::NoiseAndSoundPoses);
    let lengths = lengths_in::<f64>(&poses_mm);
    let plain = START_ERRORS_MM.map(|d| {
        let start = random_start(scene, random, d);
        let run = lengths.as_ref().ok().and_then(|lengths| run(scene, &start, lengths, TOLERANCE_MM).ok());
        run.is_some_and(|run| run.largest_error_mm(scene) <= ELSEWHERE_MM)
    });
    Trial { plain, start_free: start_free.is_ok_and(|answer| answer.largest_error_mm(scene) <= ELSEWHERE_MM) }
}
