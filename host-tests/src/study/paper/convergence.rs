//! Fig. 5: δE against the number of steps, from starts off by up to 50 mm.

use super::start::{ELSEWHERE_MM, TOLERANCE_MM, measured, random_rotations, random_start, run};
use crate::plot::{Axis, Chart, Series};
use crate::study::findings::{Findings, Plan, Problem, Table, percent, short};
use crate::study::scene::Scene;
use crate::study::statistics::quantile;
use crate::study::{Study, trials};

/// Fig. 5.
pub const FIG_5: Study = Study {
    name: "fig5",
    about: "Fig. 5: δE against steps, noise-free, starts off by up to 50 mm",
    trials: 20_000,
    run: study,
};

const POSES: usize = 3;
const START_MM: f64 = 50.0;
/// Steps shown.
const STEPS: usize = 8;
/// Runs go on to here, so that each has a δE at every step, mm.
const FAR_BELOW_MM: f64 = 1e-12;
/// Errors below this cannot be distinguished from zero, mm: lengths of some 300 mm have digits down to 6e-14 mm.
const ROUNDING_MM: f64 = 1e-13;

fn study(plan: &Plan) -> Result<Findings, Problem> {
    let columns = ["base radius (mm)", "step", "converging starts", "δE 10 % (mm)", "δE median (mm)", "δE 90 % (mm)"];
    let mut table = Table::new("fig5", "δE before the first step and after each, over the converging starts", &columns);
    let mut chart = Chart::new("Deviation against steps (Fig. 5)", Axis::count("step"), Axis::log10("δE (mm)"))
        .subtitled(&format!(
            "noise-free, three poses, starts off by up to ±50 mm, seed {}, {} starts",
            plan.seed, plan.trials
        ))
        .with_level("tolerance 0.001 mm", TOLERANCE_MM);
    for base_radius_mm in [150.0, 350.0] {
        let scene = Scene::table_1(base_radius_mm)?;
        let outcomes = trials::run(plan.seed, &format!("fig5 R {base_radius_mm}"), plan.trials, |_, mut random| {
            let rotations = random_rotations(&mut random, POSES);
            let poses = measured::<f64>(&scene, &rotations, &mut random, 0.0).ok()?;
            let start = random_start(&scene, &mut random, START_MM);
            let run = run(&scene, &start, &poses, FAR_BELOW_MM).ok()?;
            (run.largest_error_mm(&scene) <= ELSEWHERE_MM).then_some(run.deviations_mm)
        });
        let runs: Vec<_> = outcomes.into_iter().flatten().collect();
        if runs.is_empty() {
            return Err(Problem::TooFewTrials(100));
        }
        let mut curves = [Vec::new(), Vec::new(), Vec::new()];
        for step in 0..=STEPS {
            // A run that has ended stays where it is.
            let mut deviations: Vec<_> = runs.iter().map(|run| run[step.min(run.len() - 1)].max(ROUNDING_MM)).collect();
            let values = [0.1, 0.5, 0.9].map(|share| quantile(&mut deviations, share));
            for (curve, value) in curves.iter_mut().zip(values) {
                curve.push((step as f64, value));
            }
            let [low, middle, high] = values.map(short);
            let converging = percent(runs.len(), plan.trials as usize);
            table.push([short(base_radius_mm), step.to_string(), converging, low, middle, high]);
        }
        let [low, middle, high] = curves;
        let label = |what: &str| format!("{what}, base radius {base_radius_mm} mm");
        chart = chart
            .with(Series::line(&label("median"), middle))
            .with(Series::curve(&label("10 %"), low))
            .with(Series::curve(&label("90 %"), high));
    }
    Ok(Findings {
        method: "As for table2 with d = 50 mm; the iteration goes on past ε until nothing but rounding is left. The paper's \
            single run begins at δE = 31.57 mm and is at about zero within four steps."
            .to_string(),
        tables: vec![table],
        figures: vec![("fig5", Box::new(chart))],
        ..Findings::default()
    })
}
