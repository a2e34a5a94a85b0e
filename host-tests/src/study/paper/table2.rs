//! Table II: errors assigned to the start are recovered from three noise-free poses.

use super::start::{ELSEWHERE_MM, TOLERANCE_MM, measured, one_more_step, random_rotations, random_start, run};
use crate::study::findings::{Findings, Plan, Problem, Table, Target, percent, short};
use crate::study::scene::Scene;
use crate::study::solve::Precision;
use crate::study::statistics::quantile;
use crate::study::{Study, cramer_rao, trials};
use nalgebra::Rotation3;

/// Table II.
pub const TABLE_2: Study = Study {
    name: "table2",
    about: "Table II: starts off by 10, 30, 50 mm, three noise-free poses, the paper's plain iteration",
    trials: 20_000,
    run: study,
};

/// Poses of the paper's Table II.
const POSES: usize = 3;
/// Steps within which the paper says that δE falls below ε.
const STEPS: usize = 5;
/// Converging starts that a target needs to mean something.
const ENOUGH: usize = 1000;

/// The errors that the paper's Table II assigns, mm.
const ASSIGNED: [(f64, [f64; 6]); 3] = [
    (10.0, [2.54, -1.39, 8.36, 9.56, -4.21, 5.23]),
    (30.0, [18.44, 25.37, 14.61, -8.05, -28.8, 25.44]),
    (50.0, [-45.02, -17.8, -45.55, 7.95, -45.29, -40.33]),
];

/// How a start is chosen.
#[derive(Clone, Copy)]
enum Start {
    Uniform(f64),
    /// The paper's own errors times this sign.
    Assigned([f64; 6], f64),
}

/// A converged start: steps, and the largest parameter error at the end and after at most one more step, mm.
struct Converged {
    steps: usize,
    error_mm: f64,
    refined_error_mm: f64,
    /// Whether the three poses determine the centre: they need not, and δE does not tell.
    determined: bool,
}

fn study(plan: &Plan) -> Result<Findings, Problem> {
    let mut findings = Findings { method: METHOD.to_string(), ..Findings::default() };
    let mut double = table("table2-f64", "f64");
    let mut single = table("table2-f32", "f32");
    for base_radius_mm in [150.0, 200.0, 350.0] {
        let scene = Scene::table_1(base_radius_mm)?;
        for (d, errors) in ASSIGNED {
            let starts = [
                (format!("uniform ±{d}"), Start::Uniform(d)),
                (format!("paper's, actual + δ, d = {d}"), Start::Assigned(errors, 1.0)),
                (format!("paper's, actual - δ, d = {d}"), Start::Assigned(errors, -1.0)),
            ];
            for (name, start) in starts {
                let name = format!("R {base_radius_mm}, {name}");
                let outcomes = converging::<f64>(plan, &name, &scene, start);
                if matches!(start, Start::Uniform(_)) {
                    findings.targets.extend(targets(&name, &outcomes));
                }
                double.push(row(&name, &outcomes));
                single.push(row(&name, &converging::<f32>(plan, &name, &scene, start)));
            }
        }
    }
    findings.tables = vec![double, single];
    Ok(findings)
}

const METHOD: &str = "A trial is a set of three random poses (tilt to 45°, torsion ±30°, no noise) on the rig of Table I and a \
    start: the truth with each parameter off by a number uniform within ±d, or with the paper's own assigned errors, in either \
    sign (the paper does not say which). The plain iteration of Fig. 4 runs until δE < 1e-3 mm. Three random poses need not \
    determine the centre; they do where ±0.1 mm of noise would leave it known to 1 mm (1σ) along each axis.";

fn converging<T: Precision>(plan: &Plan, name: &str, scene: &Scene, start: Start) -> Vec<Option<Converged>> {
    // Both precisions get the same poses and starts.
    trials::run(plan.seed, &format!("table2 {name}"), plan.trials, |_, mut random| {
        let rotations = random_rotations(&mut random, POSES);
        let poses = measured::<T>(scene, &rotations, &mut random, 0.0).ok()?;
        let start = match start {
            Start::Uniform(d) => random_start(scene, &mut random, d),
            Start::Assigned(errors, sign) => {
                let truth = scene.truth().to_array();
                std::array::from_fn(|k| truth[k] + sign * errors[k])
            }
        };
        let run = run(scene, &start, &poses, TOLERANCE_MM).ok()?;
        let (steps, error_mm) = (run.steps(), run.largest_error_mm(scene));
        let refined_error_mm = one_more_step(scene, run, &poses).largest_error_mm(scene).min(error_mm);
        Some(Converged { steps, error_mm, refined_error_mm, determined: determined(scene, &rotations) })
    })
}

/// Would noise of ±0.1 mm leave the centre known to 1 mm (1σ) along each axis?
fn determined(scene: &Scene, rotations: &[Rotation3<f64>]) -> bool {
    let sigma_mm = 0.1 / libm::sqrt(3.0);
    cramer_rao::bound(scene, rotations, sigma_mm).is_some_and(|bound| (0..3).all(|k| bound[(k, k)] <= 1.0))
}

/// Converged to the truth.
fn right(outcomes: &[Option<Converged>]) -> impl Iterator<Item = &Converged> {
    outcomes.iter().flatten().filter(|run| run.error_mm <= ELSEWHERE_MM)
}

fn targets(name: &str, outcomes: &[Option<Converged>]) -> [Target; 3] {
    let count = right(outcomes).count();
    let quick = right(outcomes).filter(|run| run.steps <= STEPS).count();
    [
        Target::at_least(format!("{name}: converging starts"), ENOUGH as f64, count as f64),
        Target::at_least(
            format!("{name}: δE < 1e-3 mm within {STEPS} steps, % of converging starts"),
            95.0,
            100.0 * quick as f64 / count as f64,
        ),
        Target::at_most(
            format!(
                "{name}: largest parameter error after at most one more step where the poses determine the centre, mm"
            ),
            1e-6,
            refined_error(right(outcomes).filter(|run| run.determined)),
        ),
    ]
}

/// Largest error after at most one more step, mm; NaN of nothing.
fn refined_error<'a>(runs: impl Iterator<Item = &'a Converged>) -> f64 {
    quantile(&mut runs.map(|run| run.refined_error_mm).collect::<Vec<_>>(), 1.0)
}

fn table(name: &'static str, precision: &str) -> Table {
    let columns = [
        "base radius (mm), start",
        "starts",
        "converge",
        "do not converge",
        "converge elsewhere",
        "within 4 steps",
        "within 5 steps",
        "median error (mm)",
        "after one more step (mm)",
        "largest (mm)",
        "where determined (mm)",
    ];
    Table::new(name, format!("The plain iteration from three poses, {precision}"), &columns)
}

fn row(name: &str, outcomes: &[Option<Converged>]) -> [String; 11] {
    let converged = outcomes.iter().flatten().count();
    let count = right(outcomes).count();
    let within = |steps| percent(right(outcomes).filter(|run| run.steps <= steps).count(), count);
    let mut errors: Vec<_> = right(outcomes).map(|run| run.error_mm).collect();
    let mut refined: Vec<_> = right(outcomes).map(|run| run.refined_error_mm).collect();
    [
        name.to_string(),
        outcomes.len().to_string(),
        percent(count, outcomes.len()),
        percent(outcomes.len() - converged, outcomes.len()),
        percent(converged - count, outcomes.len()),
        within(4),
        within(5),
        short(quantile(&mut errors, 0.5)),
        short(quantile(&mut refined, 0.5)),
        short(quantile(&mut refined, 1.0)),
        short(refined_error(right(outcomes).filter(|run| run.determined))),
    ]
}
