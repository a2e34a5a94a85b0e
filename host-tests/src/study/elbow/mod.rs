//! The elbow: is its axis as good as the lengths allow, is its bar true, and is everything else refused by name?

pub mod bound;
pub mod scene;
mod trial;
mod watch;

pub use self::trial::RANGE_RAD;
pub use self::watch::WATCH;

use self::trial::{Case, Cell, Fault};
use super::findings::{Findings, Plan, Problem, Table, Target, percent, short};
use super::{Study, trials};
use crate::plot::{Axis, Chart, Series};
use glenoid::rig::Tolerance;

/// A hinge of two to four cables.
pub const STUDY: Study = Study {
    name: "elbow",
    about: "a hinge from its cables: error against the Cramér-Rao bound, real over reported sigma, refusals by name",
    trials: 1_000,
    run,
};

/// Four cables and nothing else, many times.
pub const ACCEPTS: Study = Study {
    name: "elbow-accepts",
    about: "a hundred thousand hinges from four cables: accepted further off than 5 sigma + 0.05 mm",
    trials: 100_000,
    run: accepts,
};

/// How far somebody's elbow is from a good drawing (2.9°, 3 mm): 1σ of each unknown, rad and mm.
const GOOD_DRAWING: [f64; 9] = [0.05, 0.05, 3.0, 3.0, 0.05, 0.05, 3.0, 3.0, 3.0];
/// Somebody's own elbow, measured (1.4°, 1.5 mm).
const FINE_DRAWING: [f64; 9] = [0.025, 0.025, 1.5, 1.5, 0.025, 0.025, 1.5, 1.5, 1.5];
/// The same of one drawing for everybody (8.6°, 12 and 8 mm).
pub const ANYBODY: [f64; 9] = [0.15, 0.15, 12.0, 12.0, 0.15, 0.15, 8.0, 8.0, 5.0];

/// Nothing known but the lengths.
const FREE: Case =
    Case { cables: 4, poses: 30, flexion_deg: 120.0, tolerance: EXACT, drawing: None, fault: Fault::None };
const EXACT: Tolerance<f64> = Tolerance { base_mm: 0.0, edges_mm: 0.0, offset_mm: 0.0, drum: 0.0 };
const HAND_BUILT: Tolerance<f64> = Tolerance { base_mm: 0.5, edges_mm: 0.5, offset_mm: 0.3, drum: 0.001 };

const POSES: [usize; 3] = [12, 30, 100];

fn run(plan: &Plan) -> Result<Findings, Problem> {
    let mut findings = Findings { method: METHOD.to_owned(), ..Findings::default() };
    accuracy(plan, &mut findings);
    drawings(plan, &mut findings);
    refusals(plan, &mut findings);
    Ok(findings)
}

fn accepts(plan: &Plan) -> Result<Findings, Problem> {
    let mut findings = Findings { method: METHOD.to_owned(), ..Findings::default() };
    let mut table = Table::new("elbow-accepts", "Four cables, nothing known but the lengths", &COLUMNS);
    let cell = cell(plan, "accepts", &FREE);
    table.push(row("exact machine", &FREE, &cell));
    findings.tables.push(table);
    let accepted = cell.accepted().count();
    for (name, part) in [("axis", &[0, 1]), ("place", &[2, 3])] {
        findings.targets.push(Target::at_most(format!("{name} over its bound"), 1.03, cell.over_bound(part)));
    }
    findings.targets.push(Target::between("real / reported σ", (0.95, 1.05), cell.ratio()));
    findings.targets.push(Target::at_most(format!("wrong, of {accepted} accepted"), 0.0, cell.wrong() as f64));
    Ok(findings)
}

const METHOD: &str = "A trial is somebody's elbow in the default rig (rings of 60 and 45 mm, ends turned by ±25° alternately): both axes \
    off by 8.6° (1σ) a component, their places by 12 and 8 mm, the forearm's frame anywhere; 0 to 120° of flexion, noise \
    within ±0.1 mm. The bound is that of normal noise of the same variance, by central differences of the lengths in all \
    unknowns and all angles, inverted whole. Wrong is any unknown beyond 5 σ + 0.05 mm (0.3 mrad). Where a machine has \
    tolerances, the truth is meant in the frames best fitted to the points as they are.";

fn cell(plan: &Plan, name: &str, case: &Case) -> Cell {
    // A hundred poses take as long as all else.
    let trials = if case.poses > 30 { plan.trials.div_ceil(4) } else { plan.trials };
    let outcomes = trials::run(plan.seed, &format!("elbow {name}"), trials, |_, random| case.trial(random));
    Cell { outcomes }
}

const COLUMNS: [&str; 8] = [
    "set",
    "poses",
    "accepted",
    "two axes fit",
    "error of the axis (°)",
    "of its place (mm)",
    "real / reported σ",
    "wrong",
];

fn row(name: &str, case: &Case, cell: &Cell) -> [String; 8] {
    let count = cell.outcomes.len();
    [
        name.to_owned(),
        case.poses.to_string(),
        percent(cell.accepted().count(), count),
        percent(cell.refused("TwoAxesFit"), count),
        short(cell.rms(&[0, 1]).to_degrees()),
        short(cell.rms(&[2, 3])),
        short(cell.ratio()),
        cell.wrong().to_string(),
    ]
}

/// Without a start and without a drawing.
fn accuracy(plan: &Plan, findings: &mut Findings) {
    let mut table = Table::new("elbow", "Four cables, nothing known but the lengths", &COLUMNS);
    let columns = ["poses", "axis", "place", "axis in the forearm", "place in the forearm", "along"];
    let mut bounds = Table::new("elbow-bound", "Error over the Cramér-Rao bound", &columns);
    let (mut measured, mut bound) = (Vec::new(), Vec::new());
    for poses in POSES {
        let case = Case { poses, ..FREE };
        let cell = cell(plan, &format!("free {poses}"), &case);
        table.push(row("exact machine", &case, &cell));
        let parts = [&[0, 1][..], &[2, 3], &[4, 5], &[6, 7], &[8]].map(|part| cell.over_bound(part));
        let [axis, place, axis_in_forearm, place_in_forearm, along] = parts.map(short);
        bounds.push([poses.to_string(), axis, place, axis_in_forearm, place_in_forearm, along]);
        measured.push((poses as f64, cell.rms(&[0, 1]).to_degrees()));
        bound.push((poses as f64, cell.bound(&[0, 1]).to_degrees()));
        if poses == 30 {
            findings.targets.push(Target::at_most("30 poses: axis over its bound", 1.03, parts[0]));
            findings.targets.push(Target::at_most("30 poses: place over its bound", 1.03, parts[1]));
            findings.targets.push(Target::between("30 poses: real / reported σ", (0.95, 1.05), cell.ratio()));
        }
        let name = format!("{poses} poses: wrong, of {} accepted", cell.accepted().count());
        findings.targets.push(Target::at_most(name, 0.0, cell.wrong() as f64));
    }
    for (name, case) in [
        ("60° of flexion", Case { flexion_deg: 60.0, ..FREE }),
        ("2-20 mm on one cable of every sixth pose", Case { fault: Fault::Outliers, ..FREE }),
    ] {
        let cell = cell(plan, name, &case);
        table.push(row(name, &case, &cell));
        findings.targets.push(Target::at_most(format!("{name}: wrong"), 0.0, cell.wrong() as f64));
        if case.fault == Fault::Outliers {
            let share = cell.mean(|outcome| outcome.named);
            findings
                .remarks
                .push(format!("{name}: of the bad poses {} are left out with their cable named", short(share)));
        }
    }
    findings.tables.extend([table, bounds]);
    let chart = Chart::new(
        "Axis of an elbow from four cables",
        Axis::linear("poses").including(0.0),
        Axis::linear("rms error of the direction (degrees)").including(0.0),
    );
    let chart = chart.with(Series::line("measured", measured)).with(Series::line("Cramér-Rao bound", bound));
    findings.figures.push(("elbow", Box::new(chart)));
}

/// Machines with tolerances, and fewer cables with a drawing.
fn drawings(plan: &Plan, findings: &mut Findings) {
    let mut table = Table::new("elbow-drawing", "With a drawing as prior (its 1σ is true)", &COLUMNS);
    let with = |cables, tolerance, drawing| Case { cables, tolerance, drawing: Some(drawing), ..FREE };
    for (name, case) in [
        ("4 cables, .5/.5/.3/.1 %, drawing 8.6°, 12 and 8 mm", with(4, HAND_BUILT, ANYBODY)),
        ("4 cables, .5/.5/.3/.1 %, drawing 2.9°, 3 mm", with(4, HAND_BUILT, GOOD_DRAWING)),
        ("4 cables, exact, drawing 2.9°, 3 mm", with(4, EXACT, GOOD_DRAWING)),
        ("3 cables, exact, drawing 2.9°, 3 mm", with(3, EXACT, GOOD_DRAWING)),
        ("3 cables, exact, drawing 1.4°, 1.5 mm", with(3, EXACT, FINE_DRAWING)),
        ("2 cables, exact, drawing 2.9°, 3 mm", with(2, EXACT, GOOD_DRAWING)),
    ] {
        let cell = cell(plan, name, &case);
        table.push(row(name, &case, &cell));
        findings.targets.push(Target::between(format!("{name}: real / reported σ"), (0.95, 1.05), cell.ratio()));
        findings.targets.push(Target::at_most(format!("{name}: wrong"), 0.0, cell.wrong() as f64));
    }
    findings.tables.push(table);
}

/// Sets that cannot give a hinge.
fn refusals(plan: &Plan, findings: &mut Findings) {
    let columns = ["set", "refused by name", "refused", "accepted", "size found / true"];
    let mut table = Table::new("elbow-refused", "Sets that give no hinge", &columns);
    for (name, reason, case, least) in [
        ("2 cables, no drawing", "TooFewCables", Case { cables: 2, ..FREE }, 1.0),
        ("3 cables, no drawing", "TooFewCables", Case { cables: 3, ..FREE }, 1.0),
        ("never bends", "TooLittleFlexion", Case { flexion_deg: 0.0, ..FREE }, 1.0),
        ("bends by at most 20°", "TooLittleFlexion", Case { flexion_deg: 20.0, ..FREE }, 0.95),
        ("a second axis, 1° (1σ)", "SecondAxis", Case { fault: Fault::SecondAxis(1.0), ..FREE }, 0.9),
        ("a second axis, 3° (1σ)", "SecondAxis", Case { fault: Fault::SecondAxis(3.0), ..FREE }, 0.9),
    ] {
        let cell = cell(plan, name, &case);
        let count = cell.outcomes.len();
        let named = cell.refused(reason);
        let size = cell.mean(|outcome| outcome.size_ratio);
        table.push([
            name.to_owned(),
            percent(named, count),
            percent(count - cell.accepted().count(), count),
            percent(cell.accepted().count(), count),
            short(size),
        ]);
        findings.targets.push(Target::at_least(format!("{name}: {reason}"), least, named as f64 / count as f64));
        findings.targets.push(Target::at_most(format!("{name}: wrong"), 0.0, cell.wrong() as f64));
    }
    findings.tables.push(table);
}
