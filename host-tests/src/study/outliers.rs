//! Bad readings: are they found, named and left out, and does the centre suffer?

use super::findings::{Findings, Plan, Problem, Table, Target, percent, short};
use super::scene::{Reach, Scene, with_noise};
use super::solve::{Knowledge, solve};
use super::statistics::root_mean_square;
use super::{Study, trials};
use glenoid::rig::CABLES;
use rand::Rng;
use rand::seq::index::sample;
use rand_chacha::ChaCha8Rng;

/// Outliers, exchanged cables, broken lengths, a slip.
pub const STUDY: Study =
    Study { name: "outliers", about: "bad cable readings in 30 poses: found, named, left out", trials: 20_000, run };

const POSES: usize = 30;
const NOISE_MM: f64 = 0.1;

/// What goes wrong with a set.
#[derive(Clone, Copy, PartialEq)]
enum Mishap {
    /// One cable of as many poses, off by an amount between two limits, mm, to either side.
    Outliers { poses: usize, least_mm: f64, most_mm: f64 },
    /// Two cables of one pose exchanged.
    Exchanged,
    /// One length of one pose ten times as long as it should be, or a hundredth.
    Broken,
    /// One cable off by an amount, mm, in all poses from the one with this number on.
    Slip { from: usize, by_mm: f64 },
}

const MISHAPS: [(&str, Mishap); 7] = [
    ("one of 5 mm", Mishap::Outliers { poses: 1, least_mm: 5.0, most_mm: 5.0 }),
    ("20 % of the poses, 2-20 mm", Mishap::Outliers { poses: 6, least_mm: 2.0, most_mm: 20.0 }),
    ("30 % of the poses, 2-20 mm", Mishap::Outliers { poses: 9, least_mm: 2.0, most_mm: 20.0 }),
    ("two cables exchanged in one pose", Mishap::Exchanged),
    ("one length x 10 or / 100", Mishap::Broken),
    ("slip of 5 mm, last 6 poses", Mishap::Slip { from: 24, by_mm: 5.0 }),
    ("slip of 5 mm, last 15 poses", Mishap::Slip { from: 15, by_mm: 5.0 }),
];

/// One set.
struct Trial {
    /// Poses with a bad cable.
    bad: usize,
    /// `None` when the set was refused.
    accepted: Option<Accepted>,
}

struct Accepted {
    /// Error of the centre, and with the same poses without mishap, mm.
    error_mm: f64,
    clean_error_mm: f64,
    /// Bad poses that were left out, those whose bad cables are among the named, and those with other cables named too.
    named: usize,
    cable_named: usize,
    more_named: usize,
    /// Sound poses that were left out.
    wrongly_left_out: usize,
    /// Error beyond five of its sigmas plus 0.05 mm.
    is_false: bool,
}

fn run(plan: &Plan) -> Result<Findings, Problem> {
    let columns = [
        "mishap",
        "sets",
        "refused",
        "bad poses named",
        "cable named",
        "another cable named too",
        "sound poses left out",
        "RMS centre error (mm)",
        "clean (mm)",
        "ratio",
        "false accepts",
    ];
    let mut table = Table::new("outliers", format!("Bad readings in {POSES} poses"), &columns);
    let mut targets = Vec::new();
    for (name, mishap) in MISHAPS {
        let ideal = Scene::table_1(150.0)?;
        let experiment = format!("outliers {name}");
        let trials = trials::run(plan.seed, &experiment, plan.trials, |_, random| trial(&ideal, random, mishap));
        let tally = Tally::of(&trials);
        targets.extend(tally.targets(name, mishap));
        table.push(tally.row(name));
    }
    Ok(Findings { method: METHOD.to_string(), tables: vec![table], targets, ..Findings::default() })
}

const METHOD: &str = "A trial is a set of 30 random poses (tilt to 45°, torsion ±30°) with noise uniform within ±0.1 mm on the 150 mm rig, \
    the centre up to ±20 mm and the cuff up to ±10 mm off along each axis. Something goes wrong with it; the same set without that \
    is the clean one. Shares of poses are over the accepted sets. More than a fifth of bad poses is to be refused.";

fn trial(ideal: &Scene, mut random: ChaCha8Rng, mishap: Mishap) -> Trial {
    let scene = ideal.worn(&mut random, 20.0, 10.0);
    let clean: Vec<_> = (0..POSES)
        .map(|_| with_noise(scene.lengths(&Reach::USUAL.rotation(&mut random)), &mut random, NOISE_MM))
        .collect();
    let mut poses_mm = clean.clone();
    let bad = spoil(&mut poses_mm, &mut random, mishap);
    let answers = (solve::<f64>(&scene, &poses_mm, Knowledge::Noise), solve::<f64>(&scene, &clean, Knowledge::Noise));
    let accepted = if let (Ok(answer), Ok(clean)) = answers {
        let error_mm = libm::sqrt(answer.centre_error_mm(&scene).norm_squared());
        let bad_bits = |pose: u32| bad.iter().find(|(index, _)| *index == pose as usize).map(|(_, bits)| *bits);
        let count = |is: &dyn Fn(u8, Option<u8>) -> bool| {
            answer.rejected.iter().filter(|rejected| is(rejected.cables, bad_bits(rejected.pose))).count()
        };
        Some(Accepted {
            error_mm,
            clean_error_mm: libm::sqrt(clean.centre_error_mm(&scene).norm_squared()),
            named: count(&|_, bits| bits.is_some()),
            cable_named: count(&|named, bits| bits.is_some_and(|bits| named & bits == bits)),
            more_named: count(&|named, bits| bits.is_some_and(|bits| named & !bits != 0)),
            wrongly_left_out: count(&|_, bits| bits.is_none()),
            is_false: answer.is_false(|_| scene.centre_mm),
        })
    } else {
        None
    };
    Trial { bad: bad.len(), accepted }
}

/// Lets the mishap happen; the poses that suffer, each with the bits of its bad cables.
fn spoil(poses_mm: &mut [[f64; CABLES]], random: &mut impl Rng, mishap: Mishap) -> Vec<(usize, u8)> {
    let cable = random.random_range(0..CABLES);
    match mishap {
        Mishap::Outliers { poses, least_mm, most_mm } => sample(random, poses_mm.len(), poses)
            .into_iter()
            .map(|pose| {
                let cable = random.random_range(0..CABLES);
                let size = random.random_range(least_mm..=most_mm);
                poses_mm[pose][cable] += if random.random_bool(0.5) { size } else { -size };
                (pose, 1 << cable)
            })
            .collect(),
        Mishap::Exchanged => {
            let pose = random.random_range(0..poses_mm.len());
            let other = (cable + random.random_range(1..CABLES)) % CABLES;
            poses_mm[pose].swap(cable, other);
            vec![(pose, 1 << cable | 1 << other)]
        }
        Mishap::Broken => {
            let pose = random.random_range(0..poses_mm.len());
            poses_mm[pose][cable] *= if random.random_bool(0.5) { 10.0 } else { 0.01 };
            vec![(pose, 1 << cable)]
        }
        Mishap::Slip { from, by_mm } => {
            let by_mm = if random.random_bool(0.5) { by_mm } else { -by_mm };
            poses_mm
                .iter_mut()
                .enumerate()
                .skip(from)
                .map(|(pose, lengths)| {
                    lengths[cable] += by_mm;
                    (pose, 1 << cable)
                })
                .collect()
        }
    }
}

/// Sums over the accepted sets.
struct Tally<'a> {
    sets: usize,
    accepted: Vec<&'a Accepted>,
    bad: usize,
}

impl<'a> Tally<'a> {
    fn of(trials: &'a [Trial]) -> Self {
        let bad = trials.iter().filter(|trial| trial.accepted.is_some()).map(|trial| trial.bad).sum();
        Self { sets: trials.len(), accepted: trials.iter().filter_map(|trial| trial.accepted.as_ref()).collect(), bad }
    }

    fn sum(&self, of: fn(&Accepted) -> usize) -> usize {
        self.accepted.iter().map(|accepted| of(accepted)).sum()
    }

    fn sound(&self) -> usize {
        self.accepted.len() * POSES - self.bad
    }

    fn errors(&self) -> (f64, f64) {
        let rms = |of: fn(&Accepted) -> f64| root_mean_square(self.accepted.iter().map(|accepted| of(accepted)));
        (rms(|accepted| accepted.error_mm), rms(|accepted| accepted.clean_error_mm))
    }

    fn row(&self, name: &str) -> [String; 11] {
        let (error, clean) = self.errors();
        [
            name.to_string(),
            self.sets.to_string(),
            percent(self.sets - self.accepted.len(), self.sets),
            percent(self.sum(|a| a.named), self.bad),
            percent(self.sum(|a| a.cable_named), self.bad),
            percent(self.sum(|a| a.more_named), self.bad),
            percent(self.sum(|a| a.wrongly_left_out), self.sound()),
            short(error),
            short(clean),
            short(error / clean),
            self.sum(|a| usize::from(a.is_false)).to_string(),
        ]
    }

    fn targets(&self, name: &str, mishap: Mishap) -> Vec<Target> {
        let (error, clean) = self.errors();
        let share = |part: usize, whole: usize| 100.0 * part as f64 / whole as f64;
        let named = share(self.sum(|a| a.named), self.bad);
        let mut targets =
            vec![Target::at_most(format!("{name}: false accepts"), 0.0, self.sum(|a| usize::from(a.is_false)) as f64)];
        match mishap {
            Mishap::Outliers { poses: 1, .. } => targets.extend([
                Target::at_least(format!("{name}: pose named, %"), 99.9, named),
                Target::at_least(format!("{name}: cable named, %"), 97.0, share(self.sum(|a| a.cable_named), self.bad)),
                Target::at_most(format!("{name}: RMS centre error over the clean one"), 1.1, error / clean),
            ]),
            Mishap::Outliers { poses: 6, .. } => targets.extend([
                Target::at_least(format!("{name}: poses named, %"), 95.0, named),
                Target::at_most(format!("{name}: RMS centre error over the clean one"), 1.3, error / clean),
                Target::at_most(
                    format!("{name}: sound poses left out, %"),
                    1.0,
                    share(self.sum(|a| a.wrongly_left_out), self.sound()),
                ),
            ]),
            _ => {}
        }
        targets
    }
}
