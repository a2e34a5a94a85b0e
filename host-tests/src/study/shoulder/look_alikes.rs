//! What may not pass for a moving centre: joints that no model explains, and balls in a machine that is not as stated.

use super::super::built::BuiltMachine;
use super::super::findings::{Plan, Table, Target, percent};
use super::super::trials;
use super::outcome::{Path, estimated};
use super::set::{Person, Trouble};
use super::{EXACT, HAND_MADE, POSES, SECOND_POSES};
use glenoid::identification::Refusal;
use glenoid::rig::Tolerance;

/// Of 99 % the jumps and slips are to be refused.
const MAX_ACCEPTED: f64 = 0.01;
/// Balls taken for a moving centre.
const MAX_FALSELY_MOVING: f64 = 0.001;
/// Balls for each set of another kind: the rate is small.
const BALLS: u64 = 25;

const fn tolerance(base_mm: f64, edges_mm: f64, offset_mm: f64, drum: f64) -> Tolerance<f64> {
    Tolerance { base_mm, edges_mm, offset_mm, drum }
}

/// Machines that are worse than stated: how, what is true, what is stated, 1σ.
const WORSE: [(&str, Tolerance<f64>, Tolerance<f64>); 6] = [
    ("points and edges .5 mm, stated exact", tolerance(0.5, 0.5, 0.0, 0.0), EXACT),
    (".5 .5 .3 .1 %, stated exact", HAND_MADE, EXACT),
    ("2 2 1 .5 %, stated exact", tolerance(2.0, 2.0, 1.0, 0.005), EXACT),
    ("drums 1 %, stated exact", tolerance(0.0, 0.0, 0.0, 0.01), EXACT),
    ("1.5 1.5 .9 .3 %, stated .5 .5 .3 .1 %", tolerance(1.5, 1.5, 0.9, 0.003), HAND_MADE),
    ("3 3 2 1 %, stated .5 .5 .3 .1 %", tolerance(3.0, 3.0, 2.0, 0.01), HAND_MADE),
];

/// Joints that neither model explains, and true balls.
pub fn troubles(plan: &Plan) -> (Table, Vec<Target>) {
    let columns = ["", "poses", "sets", "accepted", "refused as"];
    let mut table = Table::new("shoulder-troubles", "What no model explains, and true balls; one phase", &columns);
    let mut targets = Vec::new();
    for poses in POSES {
        for (name, trouble) in [("jumps by 3 mm", Trouble::Jumps), ("strap slips by 3 mm midway", Trouble::Slips)] {
            let found = ball_or_moving(plan, plan.trials, &EXACT, &EXACT, poses, trouble);
            let accepted = found.iter().filter(|found| found.is_ok()).count();
            table.push(row(name, poses, &found, accepted));
            let share = accepted as f64 / found.len() as f64;
            targets.push(Target::at_most(format!("{name}, {poses} poses: share accepted"), MAX_ACCEPTED, share));
        }
        let found = ball_or_moving(plan, plan.trials * BALLS, &EXACT, &EXACT, poses, Trouble::Ball);
        let moving = moving(&found);
        table.push(row("a true ball, as a moving centre", poses, &found, moving));
        let share = moving as f64 / found.len() as f64;
        targets.push(Target::at_most(format!("{poses} poses, true balls as moving: share"), MAX_FALSELY_MOVING, share));
    }
    (table, targets)
}

/// True balls in machines that are worse than stated.
pub fn machines(plan: &Plan) -> (Table, Vec<Target>) {
    let columns = ["a true ball in a machine with", "poses", "sets", "as a moving centre", "refused as"];
    let title = "Machines that are worse than stated; one phase";
    let mut table = Table::new("shoulder-machines", title, &columns);
    let mut falsely = 0;
    for (name, truth, stated) in &WORSE {
        for poses in POSES {
            let found = ball_or_moving(plan, plan.trials, truth, stated, poses, Trouble::Ball);
            let moving = moving(&found);
            falsely += moving;
            table.push(row(name, poses, &found, moving));
        }
    }
    let target = Target::at_most("machines worse than stated, taken for a moving centre", 0.0, falsely as f64);
    (table, vec![target])
}

type Found = Result<Path, Refusal>;

fn moving(found: &[Found]) -> usize {
    found.iter().filter(|found| found.is_ok_and(|path| path.moves)).count()
}

fn row(name: &str, poses: usize, found: &[Found], counted: usize) -> [String; 5] {
    let mut reasons = std::collections::BTreeMap::<u8, usize>::new();
    for refusal in found.iter().filter_map(|found| found.as_ref().err()) {
        *reasons.entry(refusal.code()).or_default() += 1;
    }
    let reasons: Vec<_> = reasons.iter().map(|(code, count)| format!("{code} ({count})")).collect();
    let sets = found.len();
    [name.to_owned(), poses.to_string(), sets.to_string(), percent(counted, sets), reasons.join(" ")]
}

fn ball_or_moving(
    plan: &Plan,
    sets: u64,
    truth: &Tolerance<f64>,
    stated: &Tolerance<f64>,
    poses: usize,
    trouble: Trouble,
) -> Vec<Found> {
    let name = format!("shoulder {truth:?} {stated:?} {poses} {trouble:?}");
    let found = trials::run(plan.seed, &name, sets, |trial, mut random| {
        let machine = BuiltMachine::random(&mut random, truth, *stated).ok()?;
        let person = Person::new(machine, plan.seed * 1_000_000 + trial, 0.0, 45.0, &mut random);
        let free = person.free(poses, trouble, &mut random);
        let second = person.free(SECOND_POSES, trouble, &mut random);
        Some(estimated(&person, &[], &free, &second))
    });
    found.into_iter().flatten().collect()
}
