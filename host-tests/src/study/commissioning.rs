//! A machine commissioned from logs: how good is the joint centre of the next wearer, and is its bar true?

use super::built::{Accepted, BuiltMachine, Figures, NOISE_SIGMA_MM, identify};
use super::findings::{Findings, Plan, Problem, Table, Target, percent, short};
use super::scene::{Reach, normal};
use super::{Study, trials};
use crate::commission::{Readings, of_readings};
use crate::identify::rig_file::RigFile;
use crate::plot::{Axis, Chart, Series};
use glenoid::rig::Tolerance;
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;

/// From points 1, edges 1, offsets 10 mm, drums .5 %.
pub const STUDY: Study = Study {
    name: "commissioning",
    about: "a machine commissioned on a ball or on wearers: error and sigma of the next wearer's centre",
    trials: 500,
    run,
};

const TOLERANCE: Tolerance<f64> = Tolerance { base_mm: 1.0, edges_mm: 1.0, offset_mm: 10.0, drum: 0.005 };
/// How well the places of the ball are known, 1σ of each coordinate, mm.
const PLACE_SIGMA_MM: f64 = 0.1;
/// Poses of the next wearer.
const NEXT_POSES: usize = 30;
/// What a ball on a bench reaches.
const BENCH: Reach = Reach { tilt_deg: 55.0, torsion_deg: 55.0 };

/// What is recorded, and the limit of the next wearer's rms error, mm.
struct Case {
    name: &'static str,
    logs: usize,
    poses: usize,
    known: bool,
    limit_mm: f64,
}

const CASES: [Case; 3] = [
    Case { name: "ball at three places known to .1 mm, 300 poses", logs: 3, poses: 100, known: true, limit_mm: 0.12 },
    Case { name: "five wearers, 1000 poses", logs: 5, poses: 200, known: false, limit_mm: 0.45 },
    Case { name: "ball at one place, 300 poses", logs: 1, poses: 300, known: true, limit_mm: 0.25 },
];

fn run(plan: &Plan) -> Result<Findings, Problem> {
    let columns = ["recorded", "next wearer accepted", "rms centre error (mm)", "real / reported σ", "wrong"];
    let mut table = Table::new("commissioning", "The next wearer of a commissioned machine, 30 poses", &columns);
    let (mut targets, mut points) = (Vec::new(), Vec::new());
    for (index, case) in CASES.iter().enumerate() {
        let outcomes = trials::run(plan.seed, case.name, plan.trials, |_, mut random| trial(&mut random, case));
        let figures = Figures::of(&outcomes);
        targets.push(Target::at_least(format!("{}: share accepted", case.name), 0.98, figures.accepted));
        targets.push(Target::at_most(format!("{}: rms (mm)", case.name), case.limit_mm, figures.rms_mm));
        targets.push(Target::between(format!("{}: real / reported", case.name), (0.9, 1.1), figures.ratio));
        targets.push(Target::at_most(format!("{}: wrong", case.name), 0.0, figures.wrong as f64));
        points.push((index as f64 + 1.0, figures.rms_mm));
        table.push([
            case.name.to_owned(),
            percent(outcomes.iter().flatten().count(), outcomes.len()),
            short(figures.rms_mm),
            short(figures.ratio),
            figures.wrong.to_string(),
        ]);
    }
    let chart = Chart::new(
        "The next wearer of a commissioned machine",
        Axis::linear("row of the table"),
        Axis::linear("rms error of the centre (mm)").including(0.0),
    )
    .with(Series::line("30 poses of the next wearer", points));
    Ok(Findings {
        method: METHOD.to_owned(),
        tables: vec![table],
        targets,
        figures: vec![("commissioning", Box::new(chart))],
        ..Findings::default()
    })
}

const METHOD: &str = "A trial is a machine whose points and edges are off by 1 mm (1σ), encoder offsets by up to 10 mm and \
    drums by .5 %, stated so; it is commissioned from the logs named, and the next wearer moves through 30 poses (45° of \
    tilt, ±30° of torsion) on the rig as found. Noise within ±0.1 mm; a ball on a bench reaches 55° of both.";

fn trial(random: &mut ChaCha8Rng, case: &Case) -> Option<Accepted> {
    let machine = BuiltMachine::random(random, &TOLERANCE, TOLERANCE).ok()?;
    let reach = if case.known { BENCH } else { Reach::USUAL };
    let logs: Vec<Readings> = (0..case.logs)
        .map(|_| {
            let worn = machine.worn(random, 25.0);
            let error = Vector3::from_fn(|_, _| normal(random) * PLACE_SIGMA_MM);
            let place_mm = machine.centre_in_base_mm(&worn) + error;
            Readings {
                readings_mm: machine.readings(random, &worn, case.poses, reach),
                known: case.known.then_some((place_mm, PLACE_SIGMA_MM)),
            }
        })
        .collect();
    let stated = RigFile::of(machine.stated);
    debug_assert!((stated.rig.length_noise_mm() - NOISE_SIGMA_MM).abs() < 1e-12);
    let found = of_readings(&stated, &logs).ok()?;
    let worn = machine.worn(random, 20.0);
    let readings = machine.readings(random, &worn, NEXT_POSES, Reach::USUAL);
    identify(&found, &readings, &machine.centre_in_base_mm(&worn))
}
