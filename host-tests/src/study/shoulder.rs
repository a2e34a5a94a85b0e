//! Shoulders whose centre moves: how good is the path, is its bar true, what do methods for a ball make of it?

mod outcome;
mod set;

use self::outcome::{Fixed, Path, estimated, fixed_mm};
use self::set::{Person, Trouble};
use super::findings::{Findings, Plan, Problem, Table, Target, percent, short};
use super::statistics::root_mean_square;
use super::{Study, trials};
use crate::plot::{Axis, Chart, Series};
use glenoid::identification::Refusal;
use glenoid::rig::{ASSUMED_BASE_RADIUS_MM, Rig};
use std::collections::BTreeMap;

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

/// What was found of one set.
struct Outcome {
    one_phase: Result<Path, Refusal>,
    two_phases: Result<Path, Refusal>,
    fixed_mm: [Option<f64>; 4],
}

const METHODS: [(&str, Fixed); 4] =
    [("ball", Fixed::Ball), ("paper", Fixed::Paper), ("SCoRE", Fixed::Score), ("sphere fit", Fixed::Sphere)];

fn run(plan: &Plan) -> Result<Findings, Problem> {
    let columns =
        ["base", "poses", "phases", "accepted", "path", "across", "end-points", "live", "99 % covers", "wrong"];
    let mut table = Table::new("shoulder", "Path of the centre in poses that identified nothing, mm rms", &columns);
    let fixed_columns = ["base", "ball", "paper", "SCoRE", "sphere fit"];
    let mut fixed = Table::new("shoulder-fixed", "A fixed centre against the moving one, 60 poses", &fixed_columns);
    let mut targets = Vec::new();
    let mut remarks = Vec::new();
    let mut points = [Vec::new(), Vec::new()];
    for poses in POSES {
        let mut all = Vec::new();
        for (index, (name, follow)) in WORN.into_iter().enumerate() {
            let mut outcomes = Vec::new();
            for tilt_deg in TILTS_DEG {
                outcomes.extend(sets(plan, follow, tilt_deg, poses, Trouble::None));
            }
            for (phases, paths) in by_phases(&outcomes) {
                let figures = Figures::of(&paths, &mut remarks);
                table.push(figures.row(name, poses, phases));
                if index == 0 {
                    targets.extend(figures.targets_on_thorax(poses, phases));
                }
                if poses == 60 {
                    points[phases - 1].push((index as f64 + 1.0, figures.path_mm));
                }
            }
            if poses == 60 {
                fixed.push(fixed_row(name, &outcomes));
            }
            all.extend(outcomes);
        }
        for (phases, paths) in by_phases(&all) {
            let figures = Figures::of(&paths, &mut Vec::new());
            table.push(figures.row("all", poses, phases));
            targets.extend(figures.targets_of_all(poses, phases));
        }
    }
    let mut troubles =
        Table::new("shoulder-troubles", "What no model explains, 60 poses, one phase", &["", "accepted"]);
    for (name, trouble) in [("jumps by 3 mm", Trouble::Jumps), ("strap slips by 3 mm midway", Trouble::Slips)] {
        let accepted = sets(plan, 0.0, 45.0, 60, trouble).iter().filter(|set| set.one_phase.is_ok()).count();
        troubles.push([name.to_owned(), percent(accepted, plan.trials as usize)]);
        let share = accepted as f64 / plan.trials as f64;
        targets.push(Target::at_most(format!("{name}: share accepted"), 0.01, share));
    }
    let balls = sets(plan, 0.0, 45.0, 60, Trouble::Ball);
    let moving = balls.iter().filter(|set| set.one_phase.as_ref().is_ok_and(|path| path.moves)).count();
    troubles.push(["a true ball, taken for a moving centre".to_owned(), percent(moving, balls.len())]);
    targets.push(Target::at_most("true balls taken for moving: share", 0.001, moving as f64 / balls.len() as f64));

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
        tables: vec![table, fixed, troubles],
        targets,
        figures: vec![("shoulder", Box::new(chart))],
        remarks,
    })
}

const METHOD: &str = "A trial is a person drawn around the scapulohumeral rhythm of de Groot and Brand 2001, the base worn \
    on the thorax, half following the shoulder blade, or on it; 60 or 30 free poses to 30° or 45° of tilt and ±30° of torsion, \
    noise within ±0.1 mm, slides of the head of 0.35 mm an axis; 20 held poses with a tenth of the motion left; 60 poses \
    that identify nothing. Wrong: more than 2 % of these beyond 5 σ + 0.05 mm.";

/// One set a trial: the person is the trial's number under the plan's seed.
fn sets(plan: &Plan, follow: f64, tilt_deg: f64, poses: usize, trouble: Trouble) -> Vec<Outcome> {
    let name = format!("shoulder {follow} {tilt_deg} {poses} {trouble:?}");
    let outcomes = trials::run(plan.seed, &name, plan.trials, |trial, mut random| {
        let rig = Rig::shoulder(ASSUMED_BASE_RADIUS_MM).ok()?;
        let person = Person::new(rig, plan.seed * 1_000_000 + trial, follow, tilt_deg, &mut random);
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

/// Of many sets.
struct Figures {
    sets: usize,
    accepted: usize,
    path_mm: f64,
    across_mm: f64,
    end_points_mm: f64,
    live_mm: f64,
    covered: f64,
    wrong: usize,
}

impl Figures {
    fn of(paths: &[Result<Path, Refusal>], remarks: &mut Vec<String>) -> Self {
        let accepted: Vec<Path> = paths.iter().filter_map(|path| path.as_ref().ok()).copied().collect();
        let mut refused = BTreeMap::<&str, usize>::new();
        for refusal in paths.iter().filter_map(|path| path.as_ref().err()) {
            *refused.entry(refusal.text()).or_default() += 1;
        }
        remarks.extend(refused.iter().map(|(text, count)| format!("refused, {count} of {}: {text}", paths.len())));
        let rms = |of: fn(&Path) -> f64| root_mean_square(accepted.iter().map(of));
        Self {
            sets: paths.len(),
            accepted: accepted.len(),
            path_mm: rms(|path| path.centre_mm),
            across_mm: rms(|path| path.across_mm),
            end_points_mm: rms(|path| path.end_points_mm),
            live_mm: rms(|path| path.live_mm),
            covered: accepted.iter().map(|path| path.covered).sum::<f64>() / accepted.len() as f64,
            wrong: accepted.iter().filter(|path| path.is_wrong).count(),
        }
    }

    fn row(&self, name: &str, poses: usize, phases: usize) -> [String; 10] {
        [
            name.to_owned(),
            poses.to_string(),
            phases.to_string(),
            percent(self.accepted, self.sets),
            short(self.path_mm),
            short(self.across_mm),
            short(self.end_points_mm),
            short(self.live_mm),
            format!("{:.1} %", 100.0 * self.covered),
            self.wrong.to_string(),
        ]
    }

    fn targets_on_thorax(&self, poses: usize, phases: usize) -> Vec<Target> {
        let name = format!("thorax, {poses} poses, {phases} phases");
        let (path_mm, across_mm) = match (poses, phases) {
            (60, 1) => (3.0, 1.0),
            (60, _) => (1.6, 1.0),
            (_, 1) => (3.4, 1.3),
            _ => (1.9, 1.3),
        };
        vec![
            Target::at_most(format!("{name}: path (mm)"), path_mm, self.path_mm),
            Target::at_most(format!("{name}: across the arm (mm)"), across_mm, self.across_mm),
        ]
    }

    fn targets_of_all(&self, poses: usize, phases: usize) -> Vec<Target> {
        let name = format!("all, {poses} poses, {phases} phases");
        let share = self.accepted as f64 / self.sets as f64;
        let mut targets = vec![
            Target::at_least(format!("{name}: share accepted"), 0.95, share),
            Target::between(format!("{name}: 99 % bar covers"), (0.96, 1.0), self.covered),
            Target::at_most(format!("{name}: wrong"), 0.0, self.wrong as f64),
        ];
        if poses == 60 {
            let path_mm = if phases == 1 { 2.2 } else { 1.2 };
            targets.push(Target::at_most(format!("{name}: path (mm)"), path_mm, self.path_mm));
            targets.push(Target::at_most(format!("{name}: end-points (mm)"), 0.4, self.end_points_mm));
        }
        if phases == 2 {
            targets.push(Target::at_most(format!("{name}: live centre (mm)"), 1.4, self.live_mm));
        }
        targets
    }
}
