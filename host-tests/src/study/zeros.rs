//! Encoder zeros that nobody knows: is the centre as good as the data allow, its standard deviation right, and never a wrong one
//! accepted?

use super::adversarial::is_false;
use super::cramer_rao::{bound, bound_with_zeros};
use super::findings::{Findings, Plan, Problem, Table, Target, percent, short};
use super::scene::{Reach, Scene, symmetric, with_noise};
use super::solve::{Answer, Knowledge, Precision, solve, solve_with_zeros};
use super::statistics::{largest, root_mean_square};
use super::{Study, trials};
use glenoid::identification::Refusal;
use glenoid::rig::CABLES;
use nalgebra::{Rotation3, SMatrix};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// Six unknown zeros of up to 10 mm.
pub const STUDY: Study = Study {
    name: "zeros",
    about: "encoder zeros unknown by ±10 mm: error against the bound of twelve parameters, sigma, false accepts",
    trials: 100_000,
    run,
};

/// Zeros are uniform within this to either side, mm...
const ZEROS_MM: f64 = 10.0;
/// ... and the estimator is given a normal prior of this standard deviation, mm.
const PRIOR_MM: f64 = 10.0;
/// Noise of every length, uniform within this to either side, mm, and its standard deviation.
const NOISE_MM: f64 = 0.1;
const NOISE_SIGMA_MM: f64 = 0.057_735_026_918_962_58;
const REACH: Reach = Reach { tilt_deg: 45.0, torsion_deg: 40.0 };
/// A prior so narrow that the zeros are known by it, mm.
const KNOWN_MM: f64 = 1e-6;

/// Poses of a set.
const CELLS: [Cell; 3] = [Cell { poses: (30, 30) }, Cell { poses: (100, 100) }, Cell { poses: (8, 100) }];

#[derive(Clone, Copy)]
struct Cell {
    poses: (usize, usize),
}

/// What one precision made of a set.
#[derive(Clone, Copy)]
enum Ending {
    Accepted {
        /// Found minus true x, y, z, mm, and 1σ.
        centre: [[f64; 3]; 2],
        /// Found minus true zeros, mm, and 1σ.
        zeros: [[f64; CABLES]; 2],
        wrong: bool,
    },
    Refused(u8),
}

struct Trial {
    /// f64, f32.
    endings: [Ending; 2],
    /// Variances of the centre that no estimate can go below, mm²: nothing known of the zeros; normal prior; zeros known.
    bounds_mm2: [[f64; 3]; 3],
    /// How far the centre moves when a prior of zero becomes one of a nanometre, mm; NaN when either refuses.
    moved_mm: f64,
}

fn run(plan: &Plan) -> Result<Findings, Problem> {
    let mut table = Table::new("zeros", "Centre with encoder zeros unknown by ±10 mm", &COLUMNS);
    let mut refusals =
        Table::new("zeros-refused", "Refusals, by code", &["poses, precision", "refused", "codes (sets)"]);
    let mut targets = Vec::new();
    let mut moved_mm = f64::NAN;
    for cell in CELLS {
        let ideal = Scene::table_1(150.0)?;
        let outcomes = trials::run(plan.seed, &format!("zeros {}", cell.name()), plan.trials, |_, random| {
            trial(&ideal, random, cell)
        });
        let trials: Vec<_> = outcomes.into_iter().flatten().collect();
        for (which, precision) in [f64::NAME, f32::NAME].into_iter().enumerate() {
            let tally = Tally::of(&trials, which);
            let name = format!("{}, {precision}", cell.name());
            targets.extend(tally.targets(&name, cell));
            table.push(tally.row(&name));
            refusals.push([name, percent(tally.refused.len(), trials.len()), tally.codes()]);
        }
        moved_mm = moved_mm.max(largest(trials.iter().map(|trial| trial.moved_mm)));
    }
    targets.push(Target::at_most(
        "prior 0 against a prior of a nanometre: largest move of the centre, mm",
        1e-6,
        moved_mm,
    ));
    Ok(Findings { method: METHOD.to_string(), tables: vec![table, refusals], targets, ..Findings::default() })
}

const METHOD: &str = "A trial is a set of random poses (tilt to 45°, torsion to ±40°) on the 150 mm rig, the centre up to ±20 mm \
    and the cuff up to ±10 mm off along each axis, noise uniform within ±0.1 mm; every length of a cable reads too much by \
    the same zero, uniform within ±10 mm. The estimator is given a normal prior of 10 mm: wider than the zeros' own spread \
    (5.8 mm), as whoever did not home the machine would say. The first bound holds no prior at all, for a uniform \
    distribution tells nothing inside its limits; it is of twelve parameters and all rotations. The second holds the prior as \
    the solver does; where the two differ, an error below the first is no wonder. A false accept is a centre further off than \
    five times its standard deviation plus 0.05 mm.";

const COLUMNS: [&str; 11] = [
    "poses, precision",
    "accepted",
    "false",
    "RMS centre error (mm)",
    "bound (mm)",
    "error / bound",
    "error / bound with prior",
    "with known zeros (mm)",
    "sigma / spread x, y, z",
    "RMS zero error (mm)",
    "sigma / spread of zeros",
];

fn trial(ideal: &Scene, mut random: ChaCha8Rng, cell: Cell) -> Option<Trial> {
    let scene = ideal.worn(&mut random, 20.0, 10.0);
    let poses = random.random_range(cell.poses.0..=cell.poses.1);
    let rotations: Vec<_> = (0..poses).map(|_| REACH.rotation(&mut random)).collect();
    let zeros_mm: [f64; CABLES] = std::array::from_fn(|_| symmetric(&mut random, ZEROS_MM));
    let sound: Vec<_> = rotations.iter().map(|r| with_noise(scene.lengths(r), &mut random, NOISE_MM)).collect();
    let shifted: Vec<_> = sound.iter().map(|pose| std::array::from_fn(|k| pose[k] + zeros_mm[k])).collect();
    let of = |result| Ending::of(result, &scene, &zeros_mm);
    Some(Trial {
        endings: [
            of(solve_with_zeros::<f64>(&scene, &shifted, Knowledge::Noise, PRIOR_MM)),
            of(solve_with_zeros::<f32>(&scene, &shifted, Knowledge::Noise, PRIOR_MM)),
        ],
        bounds_mm2: bounds(&scene, &rotations)?,
        moved_mm: moved_mm(&scene, &sound),
    })
}

fn bounds(scene: &Scene, rotations: &[Rotation3<f64>]) -> Option<[[f64; 3]; 3]> {
    let of_all = |b: SMatrix<f64, 12, 12>| [0, 1, 2].map(|k| b[(k, k)]);
    let known = bound(scene, rotations, NOISE_SIGMA_MM)?;
    Some([
        of_all(bound_with_zeros(scene, rotations, NOISE_SIGMA_MM, None)?),
        of_all(bound_with_zeros(scene, rotations, NOISE_SIGMA_MM, Some(PRIOR_MM))?),
        [0, 1, 2].map(|k| known[(k, k)]),
    ])
}

fn moved_mm(scene: &Scene, poses_mm: &[[f64; CABLES]]) -> f64 {
    let known = solve::<f64>(scene, poses_mm, Knowledge::Noise);
    let nearly = solve_with_zeros::<f64>(scene, poses_mm, Knowledge::Noise, KNOWN_MM);
    match (known, nearly) {
        (Ok(known), Ok(nearly)) => largest((0..3).map(|k| (known.parameters_mm[k] - nearly.parameters_mm[k]).abs())),
        (Err(_), Err(_)) => f64::NAN,
        _ => f64::INFINITY,
    }
}

impl Ending {
    fn of(result: Result<Answer, Refusal>, scene: &Scene, zeros_mm: &[f64; CABLES]) -> Self {
        match result {
            Err(refusal) => Self::Refused(refusal.code()),
            Ok(answer) => Self::Accepted {
                wrong: is_false(&answer, scene),
                centre: [answer.centre_error_mm(scene).into(), std::array::from_fn(|k| answer.sigma_mm[k])],
                zeros: [std::array::from_fn(|k| answer.zeros_mm[k] - zeros_mm[k]), answer.zero_sigmas_mm],
            },
        }
    }
}

impl Cell {
    fn name(self) -> String {
        let (least, most) = self.poses;
        if least == most { format!("m = {least}") } else { format!("m = {least} to {most}") }
    }
}

/// Sums over the sets of a cell in one precision.
#[derive(Default)]
struct Tally {
    /// Errors and 1σ of each axis.
    centre: Vec<[[f64; 3]; 2]>,
    zeros: Vec<[[f64; CABLES]; 2]>,
    bounds_mm2: Vec<[[f64; 3]; 3]>,
    wrong: usize,
    refused: Vec<u8>,
}

impl Tally {
    fn of(trials: &[Trial], which: usize) -> Self {
        let mut tally = Self::default();
        for trial in trials {
            match trial.endings[which] {
                Ending::Refused(code) => tally.refused.push(code),
                Ending::Accepted { centre, zeros, wrong } => {
                    tally.centre.push(centre);
                    tally.zeros.push(zeros);
                    tally.bounds_mm2.push(trial.bounds_mm2);
                    tally.wrong += usize::from(wrong);
                }
            }
        }
        tally
    }

    fn error_mm(&self) -> f64 {
        root_mean_square(self.centre.iter().flat_map(|[error, _]| *error)) * libm::sqrt(3.0)
    }

    fn bound_mm(&self, which: usize) -> f64 {
        root_mean_square(self.bounds_mm2.iter().flat_map(|b| b[which].map(libm::sqrt))) * libm::sqrt(3.0)
    }

    /// Reported over true spread along an axis.
    fn calibration(&self, axis: usize) -> f64 {
        let of = |what: usize| root_mean_square(self.centre.iter().map(|c| c[what][axis]));
        of(1) / of(0)
    }

    fn zeros_mm(&self, what: usize) -> f64 {
        root_mean_square(self.zeros.iter().flat_map(|z| z[what]))
    }

    fn codes(&self) -> String {
        let count = |code| self.refused.iter().filter(|c| **c == code).count();
        let codes = (1..=u8::MAX).filter(|&code| count(code) > 0);
        let codes: Vec<_> = codes.map(|code| format!("{code} ({})", count(code))).collect();
        if codes.is_empty() { "-".to_string() } else { codes.join(" ") }
    }

    fn targets(&self, name: &str, cell: Cell) -> Vec<Target> {
        let mut targets = vec![Target::at_most(format!("{name}: false accepts"), 0.0, self.wrong as f64)];
        // Over sets of all sizes the smallest alone would decide a ratio.
        if cell.poses.0 == cell.poses.1 {
            let ratio = self.error_mm() / self.bound_mm(0);
            targets.push(Target::at_most(format!("{name}: RMS centre error over the bound"), 1.05, ratio));
            for (axis, letter) in ["x", "y", "z"].into_iter().enumerate() {
                let what = format!("{name}: reported sigma over spread, {letter}");
                targets.push(Target::between(what, (0.95, 1.05), self.calibration(axis)));
            }
        }
        targets
    }

    fn row(&self, name: &str) -> [String; COLUMNS.len()] {
        let ratio = |a: f64, b: f64| format!("{:.4}", a / b);
        [
            name.to_string(),
            self.centre.len().to_string(),
            self.wrong.to_string(),
            short(self.error_mm()),
            short(self.bound_mm(0)),
            ratio(self.error_mm(), self.bound_mm(0)),
            ratio(self.error_mm(), self.bound_mm(1)),
            short(self.bound_mm(2)),
            [0, 1, 2].map(|axis| format!("{:.3}", self.calibration(axis))).join(" "),
            short(self.zeros_mm(0)),
            ratio(self.zeros_mm(1), self.zeros_mm(0)),
        ]
    }
}
