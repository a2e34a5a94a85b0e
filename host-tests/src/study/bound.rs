//! Is the centre as good as the data allow, and is its standard deviation right?

use super::cramer_rao;
use super::findings::{Findings, Plan, Problem, Table, Target, percent, short};
use super::scene::{Reach, Scene, with_noise};
use super::solve::{Answer, Knowledge, solve};
use super::statistics::root_mean_square;
use super::{Study, trials};
use crate::plot::{Axis, Chart, Series};
use rand_chacha::ChaCha8Rng;

/// Error against the bound, and calibration of the standard deviation.
pub const STUDY: Study = Study {
    name: "bound",
    about: "±0.1 mm of noise: error against the Cramér-Rao bound, reported sigma against the spread, coverage",
    trials: 20_000,
    run,
};

const POSES: [usize; 4] = [6, 10, 30, 100];
const TORSIONS_DEG: [f64; 2] = [30.0, 60.0];
/// Noise of every length, uniform within this to either side, mm.
const NOISE_MM: f64 = 0.1;
/// Its standard deviation, mm: 0.1 / √3.
const NOISE_SIGMA_MM: f64 = 0.057_735_026_918_962_58;
/// Shares of a normal distribution within one, two and three standard deviations.
const NOMINAL: [f64; 3] = [0.682_689, 0.954_500, 0.997_300];
/// Fewest poses from which coverage must be nominal.
const COVERAGE_FROM: usize = 10;

/// One accepted set.
struct Trial {
    /// Found minus true x, y, z, mm.
    error_mm: [f64; 3],
    /// Reported 1σ, noise known, mm.
    sigma_mm: [f64; 3],
    /// Reported 1σ, noise estimated, mm, and the error with it; `None` when refused.
    estimated: Option<([f64; 3], [f64; 3])>,
    /// Variance of each coordinate that no estimate can go below, mm².
    bound_mm2: [f64; 3],
}

/// A set of trials with the same number of poses and the same reach.
struct Cell {
    poses: usize,
    torsion_deg: f64,
    refused: usize,
    trials: Vec<Trial>,
}

fn run(plan: &Plan) -> Result<Findings, Problem> {
    let mut cells = Vec::new();
    for torsion_deg in TORSIONS_DEG {
        let reach = Reach { torsion_deg, ..Reach::USUAL };
        for poses in POSES {
            let ideal = Scene::table_1(150.0)?;
            let experiment = format!("bound m {poses} torsion {torsion_deg}");
            let outcomes =
                trials::run(plan.seed, &experiment, plan.trials, |_, random| trial(&ideal, random, poses, reach));
            let trials: Vec<_> = outcomes.into_iter().flatten().collect();
            cells.push(Cell { poses, torsion_deg, refused: plan.trials as usize - trials.len(), trials });
        }
    }
    if cells.iter().any(|cell| cell.trials.is_empty()) {
        return Err(Problem::TooFewTrials(100));
    }
    Ok(Findings {
        method: METHOD.to_string(),
        tables: vec![efficiency(&cells), coverage(&cells, false), coverage(&cells, true)],
        targets: cells.iter().flat_map(Cell::targets).collect(),
        figures: vec![("bound", Box::new(chart(&cells, plan)))],
        ..Findings::default()
    })
}

const METHOD: &str = "A trial is a set of random poses (tilt to 45°) with noise uniform within ±0.1 mm on the 150 mm rig, the centre up to \
    ±20 mm and the cuff up to ±10 mm off along each axis. The bound is that of normal noise with the same variance, from \
    the whole Jacobian of all lengths in all parameters and all rotations, at the truth. Sets that are refused (as weak) count \
    in neither.";

fn trial(ideal: &Scene, mut random: ChaCha8Rng, poses: usize, reach: Reach) -> Option<Trial> {
    let scene = ideal.worn(&mut random, 20.0, 10.0);
    let rotations: Vec<_> = (0..poses).map(|_| reach.rotation(&mut random)).collect();
    let poses_mm: Vec<_> =
        rotations.iter().map(|rotation| with_noise(scene.lengths(rotation), &mut random, NOISE_MM)).collect();
    let errors = |answer: &Answer| <[f64; 3]>::from(answer.centre_error_mm(&scene));
    let answer = solve::<f64>(&scene, &poses_mm, Knowledge::Noise).ok()?;
    let bound = cramer_rao::bound(&scene, &rotations, NOISE_SIGMA_MM)?;
    let estimated = solve::<f64>(&scene, &poses_mm, Knowledge::Nothing).ok();
    Some(Trial {
        error_mm: errors(&answer),
        sigma_mm: centre(&answer.sigma_mm),
        estimated: estimated.map(|answer| (errors(&answer), centre(&answer.sigma_mm))),
        bound_mm2: std::array::from_fn(|k| bound[(k, k)]),
    })
}

fn centre(sigma_mm: &[f64; 6]) -> [f64; 3] {
    std::array::from_fn(|k| sigma_mm[k])
}

impl Cell {
    fn name(&self) -> String {
        format!("m = {}, torsion ±{}°", self.poses, self.torsion_deg)
    }

    fn error_mm(&self) -> f64 {
        root_mean_square(self.trials.iter().flat_map(|trial| trial.error_mm)) * libm::sqrt(3.0)
    }

    fn bound_mm(&self) -> f64 {
        root_mean_square(self.trials.iter().flat_map(|trial| trial.bound_mm2.map(libm::sqrt))) * libm::sqrt(3.0)
    }

    /// Reported over true spread along an axis.
    fn calibration(&self, axis: usize) -> f64 {
        let reported = root_mean_square(self.trials.iter().map(|trial| trial.sigma_mm[axis]));
        reported / root_mean_square(self.trials.iter().map(|trial| trial.error_mm[axis]))
    }

    /// Share of coordinates that lie within one, two, three of their own sigmas.
    fn coverage(&self, estimated: bool) -> [f64; 3] {
        let pairs = || {
            self.trials.iter().filter_map(move |trial| {
                if estimated { trial.estimated } else { Some((trial.error_mm, trial.sigma_mm)) }
            })
        };
        let all = (3 * pairs().count()) as f64;
        [1.0, 2.0, 3.0].map(|sigmas| {
            let within =
                |(error, sigma): ([f64; 3], [f64; 3])| (0..3).filter(|&k| error[k].abs() <= sigmas * sigma[k]).count();
            pairs().map(within).sum::<usize>() as f64 / all
        })
    }

    fn targets(&self) -> Vec<Target> {
        let name = self.name();
        let ratio = self.error_mm() / self.bound_mm();
        let calibration = furthest([0, 1, 2].map(|axis| self.calibration(axis)), 1.0);
        let mut targets = vec![
            Target::at_most(format!("{name}: RMS centre error over the bound"), 1.03, ratio),
            Target::between(
                format!("{name}: reported sigma over spread, the worst of x, y, z"),
                (0.95, 1.05),
                calibration,
            ),
        ];
        if self.poses >= COVERAGE_FROM {
            for (noise, estimated) in [("known", false), ("estimated", true)] {
                let covered = self.coverage(estimated);
                let excess = furthest(std::array::from_fn(|k| 100.0 * (covered[k] - NOMINAL[k])), 0.0);
                let what =
                    format!("{name}: coverage less the nominal, points, the worst of 1, 2, 3 sigma, noise {noise}");
                targets.push(Target::between(what, (-2.0, 2.0), excess));
            }
        }
        targets
    }
}

/// The value furthest from `ideal`.
fn furthest(values: [f64; 3], ideal: f64) -> f64 {
    values.into_iter().fold(ideal, |worst, v| if (v - ideal).abs() > (worst - ideal).abs() { v } else { worst })
}

fn efficiency(cells: &[Cell]) -> Table {
    let columns = [
        "poses, reach",
        "sets",
        "refused",
        "RMS centre error (mm)",
        "bound (mm)",
        "error / bound",
        "sigma / spread x",
        "y",
        "z",
    ];
    let mut table = Table::new("bound", "Error of the centre against the Cramér-Rao bound", &columns);
    for cell in cells {
        table.push([
            cell.name(),
            cell.trials.len().to_string(),
            cell.refused.to_string(),
            short(cell.error_mm()),
            short(cell.bound_mm()),
            format!("{:.4}", cell.error_mm() / cell.bound_mm()),
            format!("{:.4}", cell.calibration(0)),
            format!("{:.4}", cell.calibration(1)),
            format!("{:.4}", cell.calibration(2)),
        ]);
    }
    table
}

fn coverage(cells: &[Cell], estimated: bool) -> Table {
    let columns = ["poses, reach", "refused", "within 1 sigma (68.27 %)", "2 sigma (95.45 %)", "3 sigma (99.73 %)"];
    let noise = if estimated { "estimated" } else { "known" };
    let name = if estimated { "coverage-estimated" } else { "coverage-known" };
    let mut table = Table::new(
        name,
        format!("How often a coordinate lies within 1, 2, 3 standard deviations, noise {noise}"),
        &columns,
    );
    for cell in cells {
        let [one, two, three] = cell.coverage(estimated).map(|share| format!("{:.2} %", 100.0 * share));
        let refused = cell.trials.iter().filter(|trial| estimated && trial.estimated.is_none()).count();
        table.push([cell.name(), percent(refused, cell.trials.len()), one, two, three]);
    }
    table
}

fn chart(cells: &[Cell], plan: &Plan) -> Chart {
    let mut chart = Chart::new(
        "RMS centre error against the Cramér-Rao bound",
        Axis::log10("poses"),
        Axis::log10("RMS centre error (mm)"),
    )
    .subtitled(&format!(
        "noise ±0.1 mm, base radius 150 mm, tilt to 45°, seed {}, {} sets a point",
        plan.seed, plan.trials
    ));
    for torsion_deg in TORSIONS_DEG {
        let of = |value: fn(&Cell) -> f64| {
            let cells = cells.iter().filter(|cell| cell.torsion_deg == torsion_deg);
            cells.map(|cell| (cell.poses as f64, value(cell))).collect()
        };
        chart = chart
            .with(Series::scatter(&format!("measured, torsion ±{torsion_deg}°"), of(Cell::error_mm)))
            .with(Series::curve(&format!("bound, torsion ±{torsion_deg}°"), of(Cell::bound_mm)));
    }
    chart
}
