//! Everything that can go wrong, mixed: is a wrong centre ever accepted?
//!
//! A false accept is an accepted centre further from the truth than five times its reported standard deviation plus 0.05 mm;
//! of a moving joint, a centre's path that is so in more than 2 % of the poses.

use super::findings::{Findings, Plan, Problem, Table, Target, percent};
use super::scene::Scene;
use super::solve::{Answer, Knowledge, solve, solve_with, solve_with_zeros};
use super::{Study, trials};
use glenoid::identification::{JointChoice, Refusal};
use glenoid::rig::CABLES;
use std::fmt::Write as _;

pub use self::mixture::{Case, case};

mod mixture;

/// All evils at once.
pub const STUDY: Study = Study {
    name: "adversarial",
    about: "mixtures of outliers, centre migration, degenerate motion, exchanged cables, glitches: no false accept",
    trials: 100_000,
    run,
};

/// How the solver is asked. The data choose the joint's model but for the first way.
const WAYS: [Way; 5] = [
    Way { name: "f64, noise known, a ball", ask: as_a_ball },
    Way { name: "f64, noise known", ask: |scene, poses| solve::<f64>(scene, poses, Knowledge::Noise) },
    Way { name: "f32, noise known", ask: |scene, poses| solve::<f32>(scene, poses, Knowledge::Noise) },
    Way { name: "f64, noise estimated", ask: |scene, poses| solve::<f64>(scene, poses, Knowledge::Nothing) },
    Way { name: "f32, noise known, zeros unknown", ask: with_unknown_zeros },
];

/// What the encoders read too much when their zeros are unknown, mm: any six numbers within ±10 mm.
const ZEROS_MM: [f64; CABLES] = [7.0, -4.0, 9.0, -8.0, 2.0, -5.5];
/// The prior that the estimator is given for them, 1σ, mm.
const ZERO_PRIOR_MM: f64 = 10.0;

/// The same set from encoders that nobody homed.
fn with_unknown_zeros(scene: &Scene, poses_mm: &[[f64; CABLES]]) -> Result<Answer, Refusal> {
    let shifted: Vec<_> = poses_mm.iter().map(|pose| std::array::from_fn(|k| pose[k] + ZEROS_MM[k])).collect();
    solve_with_zeros::<f32>(scene, &shifted, Knowledge::Noise, ZERO_PRIOR_MM)
}

/// The same for a joint that is taken for a ball.
fn as_a_ball(scene: &Scene, poses_mm: &[[f64; CABLES]]) -> Result<Answer, Refusal> {
    solve_with::<f64>(scene, poses_mm, Knowledge::Noise, JointChoice::Ball, 0.0)
}

struct Way {
    name: &'static str,
    ask: fn(&Scene, &[[f64; CABLES]]) -> Result<Answer, Refusal>,
}

/// What a set ended with.
#[derive(Clone, Copy, PartialEq)]
enum Ending {
    Accepted,
    FalselyAccepted,
    Refused(u8),
}

struct Trial {
    kind: &'static str,
    endings: [Ending; WAYS.len()],
}

fn run(plan: &Plan) -> Result<Findings, Problem> {
    let outcomes = trials::run(plan.seed, STUDY.name, plan.trials, |trial, _| {
        let case = case(plan.seed, trial)?;
        let endings = WAYS.map(|way| ending(&case, &(way.ask)(&case.scene, &case.poses_mm)));
        Ok(Trial { kind: case.kind, endings })
    });
    let trials = outcomes.into_iter().collect::<Result<Vec<_>, Problem>>()?;
    let mut remarks = Vec::new();
    for (index, trial) in trials.iter().enumerate() {
        for (way, ending) in WAYS.iter().zip(trial.endings) {
            if ending == Ending::FalselyAccepted {
                remarks.push(description(plan.seed, index as u64, way)?);
            }
        }
    }
    let targets = WAYS.iter().enumerate().map(|(way, Way { name, .. })| {
        let wrong = trials.iter().filter(|trial| trial.endings[way] == Ending::FalselyAccepted).count();
        Target::at_most(format!("false accepts, {name}"), 0.0, wrong as f64)
    });
    Ok(Findings {
        method: METHOD.to_string(),
        tables: (0..WAYS.len()).map(|way| table(&trials, way)).collect(),
        targets: targets.collect(),
        remarks,
        ..Findings::default()
    })
}

const METHOD: &str = "A trial is a set of 4 to 100 poses (half of the sets have fewer than 16) with ±0.1 mm of noise, on the \
    150 mm rig or on a random one, with usual, extreme or small motion. To it are added, each with a probability of its \
    own and in any combination: outliers of 2-50 mm on up to 40 % of the poses, a joint centre that migrates, a degenerate \
    family with up to three odd poses, exchanged cables in some or all poses, one huge glitch. A set counts under \
    the evils it holds.";

/// Whether an accepted centre is further off than its standard deviation allows.
pub(super) fn is_false(answer: &Answer, scene: &Scene) -> bool {
    answer.is_false(|_| scene.centre_mm)
}

fn ending(case: &Case, answer: &Result<Answer, Refusal>) -> Ending {
    match answer {
        Ok(answer) if is_false(answer, &case.scene) => Ending::FalselyAccepted,
        Ok(_) => Ending::Accepted,
        Err(refusal) => Ending::Refused(refusal.code()),
    }
}

/// Everything needed to look into a false accept.
fn description(seed: u64, trial: u64, way: &Way) -> Result<String, Problem> {
    let case = case(seed, trial)?;
    let mut text = format!("FALSE ACCEPT ({}): seed {seed} trial {trial}: {}", way.name, case.description);
    if let Ok(answer) = (way.ask)(&case.scene, &case.poses_mm) {
        let error = answer.centre_error_mm(&case.scene);
        let left_out: Vec<_> = answer.rejected.iter().map(|r| (r.pose, r.cables)).collect();
        let _ = write!(
            text,
            "\n    error ({:.3}, {:.3}, {:.3}) mm = {:.2} sigma of {:.4} mm; deviation {:.4} mm, noise {:.4} mm, excitation {:.2}°; \
             {}; left out (pose, cable bits) {left_out:?}",
            error.x,
            error.y,
            error.z,
            libm::sqrt(error.norm_squared()) / answer.centre_sigma_mm(),
            answer.centre_sigma_mm(),
            answer.deviation_mm,
            answer.noise_mm,
            answer.excitation_rad.to_degrees(),
            if answer.path.is_empty() { "a ball" } else { "a moving centre" },
        );
    }
    Ok(text)
}

fn table(trials: &[Trial], way: usize) -> Table {
    const FILES: [&str; WAYS.len()] =
        ["adversarial-ball", "adversarial-f64", "adversarial-f32", "adversarial-estimated", "adversarial-zeros"];
    let columns = ["evils", "sets", "accepted", "falsely", "refused", "refusal codes (sets)"];
    let title = format!("Outcomes by what a set holds ({})", WAYS[way].name);
    let mut table = Table::new(FILES[way], title, &columns);
    let mut row = |name: &str, belongs: &dyn Fn(&Trial) -> bool| {
        let endings: Vec<_> = trials.iter().filter(|t| belongs(t)).map(|t| t.endings[way]).collect();
        let count = |ending| endings.iter().filter(|e| **e == ending).count();
        let accepted = count(Ending::Accepted) + count(Ending::FalselyAccepted);
        let codes = (1..=u8::MAX).filter(|&code| count(Ending::Refused(code)) > 0);
        let codes: Vec<_> = codes.map(|code| format!("{code} ({})", count(Ending::Refused(code)))).collect();
        table.push([
            name.to_string(),
            endings.len().to_string(),
            accepted.to_string(),
            count(Ending::FalselyAccepted).to_string(),
            percent(endings.len() - accepted, endings.len()),
            codes.join(" "),
        ]);
    };
    row("all", &|_| true);
    for kind in mixture::KINDS {
        row(kind, &|trial| trial.kind == kind);
    }
    table
}
