//! Fig. 6 and 7: δE against the number of poses with ±0.1 mm of noise, over the poses used to identify and over a
//! second set of as many.

use super::start::{TOLERANCE_MM, measured, random_rotations, random_start, run};
use crate::plot::{Axis, Chart, Series};
use crate::study::findings::{Findings, Plan, Problem, Table, short};
use crate::study::scene::Scene;
use crate::study::statistics::quantile;
use crate::study::{Study, trials};
use glenoid::paper::verify;
use glenoid::rig::Parameters;

/// Fig. 6.
pub const FIG_6: Study = Study {
    name: "fig6",
    about: "Fig. 6: δE against the number of poses, ±0.1 mm of noise, starts off by up to 25 mm",
    trials: 200,
    run: |plan| study(plan, "fig6", 25.0),
};

/// Fig. 7.
pub const FIG_7: Study = Study {
    name: "fig7",
    about: "Fig. 7: the same with starts off by up to 50 mm",
    trials: 200,
    run: |plan| study(plan, "fig7", 50.0),
};

const NOISE_MM: f64 = 0.1;
const MAX_POSES: usize = 100;
/// What the paper's figures settle at, mm.
const PAPER_MM: f64 = 0.07;
/// Starts drawn before a set is given up.
const MAX_STARTS: usize = 1000;

/// One set that was identified and verified.
struct Verified {
    identification_mm: f64,
    verification_mm: f64,
    /// Largest parameter error, mm.
    error_mm: f64,
    /// Starts that failed before one converged.
    failed_starts: usize,
}

fn study(plan: &Plan, name: &'static str, d: f64) -> Result<Findings, Problem> {
    let columns = [
        "base radius (mm)",
        "poses",
        "δE identification, median (mm)",
        "δE verification, median (mm)",
        "δE verification, 90 % (mm)",
        "largest parameter error, median (mm)",
        "failed starts",
        "sets given up",
    ];
    let whole = format!("δE with ±0.1 mm of noise, starts off by up to {d} mm, every number of poses");
    let mut all = Table::new(if name == "fig6" { "fig6" } else { "fig7" }, whole, &columns).filed_only();
    let title = format!("δE with ±0.1 mm of noise, starts off by up to {d} mm (the paper settles at {PAPER_MM} mm)");
    let mut some = Table::new(if name == "fig6" { "fig6-some" } else { "fig7-some" }, title, &columns);
    let mut chart = Chart::new(
        &format!("Deviation against poses (Fig. {})", &name[3..]),
        Axis::linear("poses").including(0.0),
        Axis::linear("δE (mm)").including(0.0),
    )
    .subtitled(&format!(
        "noise ±0.1 mm, starts off by up to ±{d} mm, seed {}, medians of {} sets",
        plan.seed, plan.trials
    ))
    .with_level("the paper's 0.07 mm", PAPER_MM);
    let mut remarks = Vec::new();
    for base_radius_mm in [150.0, 350.0] {
        let scene = Scene::table_1(base_radius_mm)?;
        let (mut identification, mut verification) = (Vec::new(), Vec::new());
        for poses in 3..=MAX_POSES {
            let experiment = format!("{name} R {base_radius_mm} m {poses}");
            let sets =
                trials::run(plan.seed, &experiment, plan.trials, |_, mut random| set(&scene, &mut random, poses, d));
            let done: Vec<_> = sets.iter().flatten().collect();
            let middle = |share: f64, of: fn(&Verified) -> f64| {
                quantile(&mut done.iter().map(|set| of(set)).collect::<Vec<_>>(), share)
            };
            let medians = [middle(0.5, |set| set.identification_mm), middle(0.5, |set| set.verification_mm)];
            identification.push((poses as f64, medians[0]));
            verification.push((poses as f64, medians[1]));
            let row = [
                short(base_radius_mm),
                poses.to_string(),
                short(medians[0]),
                short(medians[1]),
                short(middle(0.9, |set| set.verification_mm)),
                short(middle(0.5, |set| set.error_mm)),
                done.iter().map(|set| set.failed_starts).sum::<usize>().to_string(),
                (sets.len() - done.len()).to_string(),
            ];
            if poses == MAX_POSES {
                remarks.push(format!(
                    "verification δE at {poses} poses, base radius {base_radius_mm} mm: {} mm; the paper's: {PAPER_MM} mm",
                    short(medians[1])
                ));
            }
            if [3, 4, 6, 10, 20, 30, 50, 100].contains(&poses) {
                some.push(row.clone());
            }
            all.push(row);
        }
        chart = chart
            .with(Series::curve(&format!("identification, base radius {base_radius_mm} mm"), identification))
            .with(Series::curve(&format!("verification, base radius {base_radius_mm} mm"), verification));
    }
    Ok(Findings {
        method: format!(
            "A trial is two sets of m random poses (tilt to 45°, torsion ±30°) with noise uniform within ±0.1 mm on the rig \
             of Table I, for every m from 3 to 100. The plain iteration runs on the first set from a start with each parameter \
             off by up to ±{d} mm; when it does not converge another start is drawn, and counted. δE of the second set is the \
             verification. The paper's figure settles at {PAPER_MM} mm."
        ),
        tables: vec![some, all],
        figures: vec![(name, Box::new(chart))],
        remarks,
        ..Findings::default()
    })
}

fn set(scene: &Scene, random: &mut rand_chacha::ChaCha8Rng, poses: usize, d: f64) -> Option<Verified> {
    let (first, second) = (random_rotations(random, poses), random_rotations(random, poses));
    let first = measured::<f64>(scene, &first, random, NOISE_MM).ok()?;
    let second = measured::<f64>(scene, &second, random, NOISE_MM).ok()?;
    for failed_starts in 0..MAX_STARTS {
        let start = random_start(scene, random, d);
        let Ok(run) = run(scene, &start, &first, TOLERANCE_MM) else { continue };
        let parameters = Parameters::from_array(run.parameters_mm);
        let Ok(verification_mm) = verify(scene.rig(), &parameters, &second) else { continue };
        return Some(Verified {
            identification_mm: run.deviation_mm(),
            verification_mm,
            error_mm: run.largest_error_mm(scene),
            failed_starts,
        });
    }
    None
}
