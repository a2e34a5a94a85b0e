//! A machine that is not as drawn, with stated tolerances: is the centre as good as they allow, and its bar true?

use super::built::{BuiltMachine, Figures, NOISE_SIGMA_MM, identify};
use super::findings::{Findings, Plan, Problem, Table, Target, percent, short};
use super::scene::Reach;
use super::{Study, trials};
use crate::identify::rig_file::RigFile;
use crate::plot::{Axis, Chart, Series};
use glenoid::rig::Tolerance;

/// Stated tolerances that are true.
pub const STUDY: Study = Study {
    name: "machine",
    about: "a machine off by its stated tolerances: accepted, error of the centre, real over reported sigma",
    trials: 500,
    run,
};

/// What is off by how much, and the limits: share accepted, rms of the centre from 30 and 100 poses (mm), ratio.
struct Case {
    name: &'static str,
    tolerance: Tolerance<f64>,
    accepted: f64,
    rms_mm: [f64; 2],
    ratio: (f64, f64),
}

const fn tolerance(base_mm: f64, edges_mm: f64, offset_mm: f64, drum: f64) -> Tolerance<f64> {
    Tolerance { base_mm, edges_mm, offset_mm, drum }
}

const CASES: [Case; 4] = [
    Case {
        name: "points .5, edges .5, homed exactly",
        tolerance: tolerance(0.5, 0.5, 0.0, 0.0),
        accepted: 0.99,
        rms_mm: [0.11, 0.07],
        ratio: (0.95, 1.05),
    },
    Case {
        name: "+ homing .3, drum .1 %",
        tolerance: tolerance(0.5, 0.5, 0.3, 0.001),
        accepted: 0.99,
        rms_mm: [0.34, 0.32],
        ratio: (0.95, 1.05),
    },
    Case {
        name: "points 1, edges 1, homing .5, drum .3 %",
        tolerance: tolerance(1.0, 1.0, 0.5, 0.003),
        accepted: 0.98,
        rms_mm: [0.58, 0.56],
        ratio: (0.95, 1.05),
    },
    Case {
        name: "offsets unknown (10 mm), points .5, edges .5",
        tolerance: tolerance(0.5, 0.5, 10.0, 0.0),
        accepted: 0.98,
        rms_mm: [0.85, 0.52],
        ratio: (0.95, 1.08),
    },
];

const POSES: [usize; 2] = [30, 100];

fn run(plan: &Plan) -> Result<Findings, Problem> {
    let columns =
        ["off by 1σ (mm), as stated", "poses", "accepted", "rms centre error (mm)", "real / reported σ", "wrong"];
    let mut table = Table::new("machine", "A machine off by its stated tolerances", &columns);
    let mut targets = Vec::new();
    let mut points = [Vec::new(), Vec::new()];
    for (index, case) in CASES.iter().enumerate() {
        for (which, poses) in POSES.into_iter().enumerate() {
            let figures = figures(plan, case, poses, 1.0);
            let name = format!("{}, {poses} poses", case.name);
            targets.push(Target::at_least(format!("{name}: share accepted"), case.accepted, figures.accepted));
            targets.push(Target::at_most(format!("{name}: rms (mm)"), case.rms_mm[which], figures.rms_mm));
            targets.push(Target::between(format!("{name}: real / reported"), case.ratio, figures.ratio));
            targets.push(Target::at_most(format!("{name}: wrong"), 0.0, figures.wrong as f64));
            points[which].push((index as f64 + 1.0, figures.rms_mm));
            table.push(row(case.name, poses, plan.trials, &figures));
        }
    }
    // True errors twice those stated: refused or honest, never wrong.
    let case = &CASES[1];
    let figures = self::figures(plan, case, 30, 2.0);
    targets.push(Target::at_most("twice the stated errors: wrong", 0.0, figures.wrong as f64));
    table.push(row("twice what is stated (.5 .5 .3 .1 %)", 30, plan.trials, &figures));

    // Poses held for forty samples: what averages and what does not are known apart.
    for (name, tolerance) in [("exact", Tolerance::exact()), ("points .5, edges .5", tolerance(0.5, 0.5, 0.0, 0.0))] {
        for poses in POSES {
            let figures = held_figures(plan, &tolerance, poses);
            let name = format!("{name}, held for {HELD_SAMPLES} samples, friction {FRICTION_MM} mm");
            targets.push(Target::at_least(format!("{name}, {poses} poses: share accepted"), 0.99, figures.accepted));
            let ratio = figures.ratio;
            targets.push(Target::between(format!("{name}, {poses} poses: real / reported"), (0.95, 1.05), ratio));
            targets.push(Target::at_most(format!("{name}, {poses} poses: wrong"), 0.0, figures.wrong as f64));
            table.push(row(&name, poses, plan.trials, &figures));
        }
    }

    let mut chart = Chart::new(
        "Centre of a machine that is not as drawn",
        Axis::linear("case of the table"),
        Axis::linear("rms error of the centre (mm)").including(0.0),
    );
    for (points, poses) in points.into_iter().zip(POSES) {
        chart = chart.with(Series::line(&format!("{poses} poses"), points));
    }
    Ok(Findings {
        method: METHOD.to_owned(),
        tables: vec![table],
        targets,
        figures: vec![("machine", Box::new(chart))],
        ..Findings::default()
    })
}

const METHOD: &str = "A trial is a machine on the 150 mm base whose attachment points, edges, offsets and drums are off by \
    normal errors of the stated sizes (unknown offsets: uniform within 10 mm), a wearer in it, and poses to 45° of tilt and \
    ±30° of torsion, noise within ±0.1 mm. The centre is compared in the frame best fitted to the true points. Wrong is \
    beyond 5 σ + 0.05 mm.";

fn row(name: &str, poses: usize, trials: u64, figures: &Figures) -> [String; 6] {
    let accepted = (figures.accepted * trials as f64).round() as usize;
    [
        name.to_owned(),
        poses.to_string(),
        percent(accepted, trials as usize),
        short(figures.rms_mm),
        short(figures.ratio),
        figures.wrong.to_string(),
    ]
}

/// Samples of a held pose, and what is the same in all of them, 1σ, mm.
const HELD_SAMPLES: u16 = 40;
const FRICTION_MM: f64 = 0.02;

/// Poses held for [`HELD_SAMPLES`], by a rig that states both parts of the noise.
fn held_figures(plan: &Plan, tolerance: &Tolerance<f64>, poses: usize) -> Figures {
    let name = format!("machine held {} {poses}", tolerance.base_mm);
    let outcomes = trials::run(plan.seed, &name, plan.trials, |_, mut random| {
        let machine = BuiltMachine::random(&mut random, tolerance, *tolerance).ok()?;
        let worn = machine.worn(&mut random, 20.0);
        let mut reading = || {
            let rotation = Reach::USUAL.rotation(&mut random);
            machine.held_reading(&mut random, &worn, &rotation, HELD_SAMPLES, FRICTION_MM)
        };
        let readings: Vec<_> = (0..poses).map(|_| reading()).collect();
        let stated = machine.stated.with_noise(FRICTION_MM, NOISE_SIGMA_MM).ok()?;
        let rig = RigFile { samples_a_row: Some(HELD_SAMPLES), ..RigFile::of(stated) };
        identify(&rig, &readings, &machine.centre_in_base_mm(&worn))
    });
    Figures::of(&outcomes)
}

/// Errors of the machine `times` as large as stated.
fn figures(plan: &Plan, case: &Case, poses: usize, times: f64) -> Figures {
    let stated = case.tolerance;
    let truth =
        tolerance(stated.base_mm * times, stated.edges_mm * times, stated.offset_mm * times, stated.drum * times);
    let name = format!("machine {} {poses} {times}", case.name);
    let outcomes = trials::run(plan.seed, &name, plan.trials, |_, mut random| {
        let machine = BuiltMachine::random(&mut random, &truth, stated).ok()?;
        let worn = machine.worn(&mut random, 20.0);
        let readings = machine.readings(&mut random, &worn, poses, Reach::USUAL);
        let rig = RigFile::of(machine.stated);
        identify(&rig, &readings, &machine.centre_in_base_mm(&worn))
    });
    Figures::of(&outcomes)
}
