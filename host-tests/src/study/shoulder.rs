//! Shoulders whose centre moves: how good is the path, is its bar true, what do methods for a ball make of it?

mod askew;
mod figures;
mod look_alikes;
mod outcome;
mod set;

use self::figures::{Figures, Limits};
use self::outcome::{Fixed, Path, estimated, fixed_mm};
use self::set::{Person, Trouble};
use super::built::BuiltMachine;
use super::findings::{Findings, Plan, Problem, Table, percent, short};
use super::statistics::root_mean_square;
use super::{Study, trials};
use crate::plot::{Axis, Chart, Series};
use glenoid::identification::Refusal;
use glenoid::rig::Tolerance;

/// People by published regressions.
pub const STUDY: Study = Study {
    name: "shoulder",
    about: "shoulders whose centre moves: path, bar, end-points, live centre; one phase and two, and methods for a ball",
    trials: 40,
    run,
};

/// How the base is worn: the share of the shoulder blade's motion that it makes.
const WORN: [(&str, f64); 3] = [("thorax", 0.0), ("half", 0.5), ("blade", 1.0)];
const TILTS_DEG: [f64; 2] = [30.0, 45.0];
const POSES: [usize; 2] = [60, 30];
const HELD_POSES: usize = 20;
const SECOND_POSES: usize = 60;

/// Machines: exactly as stated, or off by normal errors of the tolerances that are stated.
const EXACT: Tolerance<f64> = Tolerance { base_mm: 0.0, edges_mm: 0.0, offset_mm: 0.0, drum: 0.0 };
const HAND_MADE: Tolerance<f64> = Tolerance { base_mm: 0.5, edges_mm: 0.5, offset_mm: 0.3, drum: 0.001 };

/// Sets that are drawn alike.
#[derive(Clone, Copy, Debug)]
struct Sets {
    machine: Tolerance<f64>,
    follow: f64,
    tilt_deg: f64,
    poses: usize,
    trouble: Trouble,
    /// How far cuffs are askew to the arm, 1σ about each axis.
    askew_deg: f64,
}

/// What was found of one set.
struct Outcome {
    one_phase: Result<Path, Refusal>,
    two_phases: Result<Path, Refusal>,
    fixed_mm: [Option<f64>; 4],
}

const METHODS: [(&str, Fixed); 4] =
    [("ball", Fixed::Ball), ("paper", Fixed::Paper), ("SCoRE", Fixed::Score), ("sphere fit", Fixed::Sphere)];

/// Columns of the tables of paths.
const COLUMNS: [&str; 11] =
    ["machine", "base", "poses", "phases", "accepted", "path", "across", "end-points", "live", "99 % covers", "wrong"];

fn run(plan: &Plan) -> Result<Findings, Problem> {
    let mut table = Table::new("shoulder", "Path of the centre in poses that identified nothing, mm rms", &COLUMNS);
    let fixed_columns = ["base", "ball", "paper", "SCoRE", "sphere fit"];
    let mut fixed = Table::new("shoulder-fixed", "A fixed centre against the moving one, 60 poses", &fixed_columns);
    let (mut targets, mut remarks) = (Vec::new(), Vec::new());
    let mut points = [Vec::new(), Vec::new()];
    for (machine, tolerance) in [("exact", EXACT), (".5 .5 .3 .1 %", HAND_MADE)] {
        for poses in POSES {
            let mut all = Vec::new();
            for (index, (base, follow)) in WORN.into_iter().enumerate() {
                let of_tilt = |tilt_deg| {
                    let trouble = Trouble::None;
                    sets(plan, &Sets { machine: tolerance, follow, tilt_deg, poses, trouble, askew_deg: 0.0 })
                };
                let outcomes: Vec<Outcome> = TILTS_DEG.into_iter().flat_map(of_tilt).collect();
                for (phases, paths) in by_phases(&outcomes) {
                    let figures = Figures::of(&paths, &mut remarks);
                    table.push(figures.row(machine, base, poses, phases));
                    let limits = limits(machine, base, poses, phases);
                    let name = format!("{machine}, {base}, {poses} poses, {phases} phases");
                    targets.extend(limits.map(|limits| figures.targets(&name, &limits)).unwrap_or_default());
                    if (machine, poses) == ("exact", 60) {
                        points[phases - 1].push((index as f64 + 1.0, figures.path_mm));
                    }
                }
                if (machine, poses) == ("exact", 60) {
                    fixed.push(fixed_row(base, &outcomes));
                }
                all.extend(outcomes);
            }
            for (phases, paths) in by_phases(&all) {
                let figures = Figures::of(&paths, &mut Vec::new());
                table.push(figures.row(machine, "all", poses, phases));
                let limits = limits(machine, "all", poses, phases);
                let name = format!("{machine}, all, {poses} poses, {phases} phases");
                targets.extend(limits.map(|limits| figures.targets(&name, &limits)).unwrap_or_default());
            }
        }
    }
    let (askew, of_askew) = askew::cuffs(plan);
    targets.extend(of_askew);
    let (troubles, of_troubles) = look_alikes::troubles(plan);
    let (machines, of_machines) = look_alikes::machines(plan);
    targets.extend(of_troubles);
    targets.extend(of_machines);
    let mut chart = Chart::new(
        "Path of a moving joint centre",
        Axis::linear("base on thorax (1), half (2), shoulder blade (3)"),
        Axis::linear("rms error of the centre (mm)").including(0.0),
    );
    for (points, name) in points.into_iter().zip(["one phase", "two phases"]) {
        chart = chart.with(Series::line(name, points));
    }
    remarks.sort();
    remarks.dedup();
    Ok(Findings {
        method: METHOD.to_owned(),
        tables: vec![table, askew, fixed, troubles, machines],
        targets,
        figures: vec![("shoulder", Box::new(chart))],
        remarks,
    })
}

const METHOD: &str = "A trial is a person drawn around the scapulohumeral rhythm of de Groot and Brand 2001, the base worn \
    on the thorax, half following the shoulder blade, or on it; 60 or 30 free poses to 30° or 45° of tilt and ±30° of torsion, \
    noise within ±0.1 mm, slides of the head of 0.35 mm an axis; 20 held poses with a tenth of the motion left; 60 poses \
    that identify nothing. Wrong: more than 2 % of these beyond 5 σ + 0.05 mm. The machine is exact, or off by normal errors of \
    the tolerances that are stated of it. 420 trials make 10 000 sets of exact machines.";

/// What is asked of a row; `None` where nothing is.
fn limits(machine: &str, base: &str, poses: usize, phases: usize) -> Option<Limits> {
    let of = |path_mm, across_mm| Limits { path_mm: Some(path_mm), across_mm: Some(across_mm), ..Limits::default() };
    let one_or_two = |one, two| if phases == 1 { one } else { two };
    match (machine, base, poses) {
        ("exact", "thorax", 60) => Some(of(one_or_two(3.0, 1.6), 1.0)),
        ("exact", "thorax", _) => Some(of(one_or_two(3.4, 1.9), 1.3)),
        ("exact", "all", 60) => Some(Limits {
            path_mm: Some(one_or_two(2.2, 1.2)),
            across_mm: None,
            end_points_mm: Some(0.4),
            live_mm: (phases == 2).then_some(1.4),
        }),
        ("exact", "all", _) => Some(Limits { live_mm: (phases == 2).then_some(1.4), ..Limits::default() }),
        (_, "thorax", 60) => Some(of(one_or_two(3.3, 1.8), 1.2)),
        (_, "all", _) => Some(Limits::default()),
        _ => None,
    }
}

/// One set a trial: the person is the trial's number under the plan's seed.
fn sets(plan: &Plan, of: &Sets) -> Vec<Outcome> {
    let Sets { machine, follow, tilt_deg, poses, trouble, askew_deg } = *of;
    let name = format!("shoulder {follow} {tilt_deg} {poses} {trouble:?} {}", machine.base_mm);
    let outcomes = trials::run(plan.seed, &name, plan.trials, |trial, mut random| {
        let built = BuiltMachine::random(&mut random, &machine, machine).ok()?;
        let person = Person::new(built, plan.seed * 1_000_000 + trial, follow, tilt_deg, &mut random);
        let person = if askew_deg > 0.0 { person.with_cuff_askew(askew_deg, &mut random) } else { person };
        let free = person.free(poses, trouble, &mut random);
        let held = person.held(HELD_POSES, &mut random);
        let unlike = if trouble == Trouble::Ball { Trouble::Ball } else { Trouble::None };
        let second = person.free(SECOND_POSES, unlike, &mut random);
        Some(Outcome {
            one_phase: estimated(&person, &[], &free, &second),
            two_phases: estimated(&person, &held, &free, &second),
            fixed_mm: METHODS.map(|(_, method)| fixed_mm(method, &person, &free, &second)),
        })
    });
    outcomes.into_iter().flatten().collect()
}

type Paths = Vec<Result<Path, Refusal>>;

fn by_phases(outcomes: &[Outcome]) -> [(usize, Paths); 2] {
    let one = outcomes.iter().map(|outcome| outcome.one_phase).collect();
    [(1, one), (2, outcomes.iter().map(|outcome| outcome.two_phases).collect())]
}

fn fixed_row(name: &str, outcomes: &[Outcome]) -> [String; 5] {
    let mut row = std::array::from_fn(|_| name.to_owned());
    for (index, cell) in row.iter_mut().skip(1).enumerate() {
        let found: Vec<f64> = outcomes.iter().filter_map(|outcome| outcome.fixed_mm[index]).collect();
        *cell =
            format!("{} ({})", short(root_mean_square(found.iter().copied())), percent(found.len(), outcomes.len()));
    }
    row
}
