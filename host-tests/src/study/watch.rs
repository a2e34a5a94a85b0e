//! The watch over a centre in use: does it report what slipped, in time, by its name, and nothing else?

use super::findings::{Findings, Plan, Problem, Table, Target, percent, short};
use super::scene::normal;
use super::statistics::{most_events, quantile};
use super::{Study, trials};
use glenoid::monitor::{Cause, SlipDetector};
use glenoid::rig::CABLES;
use nalgebra::Vector3;
use rand::Rng;
use rand_chacha::ChaCha8Rng;

pub use self::therapy::{Mishap, Motion, Therapy};

mod therapy;

/// Slips of strap, cuff and cable; hours of therapy without any.
pub const STUDY: Study = Study {
    name: "watch",
    about: "slips after acceptance: reported within 2 s, named, direction right; false alarms in hours of therapy",
    trials: 2_000,
    run,
};

/// Samples a second, as the device takes them.
const RATE_HZ: f64 = 100.0;
/// The arm exercises for this long before anything slips, s.
const BEFORE_S: f64 = 2.0;
/// A slip must be reported within this time, s, in which the arm turns by at least this much, rad.
const WITHIN_S: f64 = 2.0;
const SPAN_RAD: f64 = 0.349_065_850_398_865_9;
/// Largest error of a direction, degrees.
const DIRECTION_DEG: f64 = 15.0;
/// Each wearer also exercises for this long without any mishap, s.
const THERAPY_S: f64 = 180.0;

/// What slips.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Strap,
    Cable,
    Cuff,
    Drift,
}

/// An experiment: what slips, by how much (mm), and how much of it must be right (%), if that was aimed at.
struct Case {
    name: &'static str,
    kind: Kind,
    by_mm: f64,
    sweep: bool,
    zeros_known: bool,
    aim: Option<f64>,
}

impl Case {
    const fn new(name: &'static str, kind: Kind, by_mm: f64) -> Self {
        Self { name, kind, by_mm, sweep: false, zeros_known: true, aim: None }
    }

    const fn sweep(self) -> Self {
        Self { sweep: true, ..self }
    }

    const fn zeros_found(self) -> Self {
        Self { zeros_known: false, ..self }
    }

    const fn aim(self, percent: f64) -> Self {
        Self { aim: Some(percent), ..self }
    }
}

const CASES: [Case; 12] = [
    Case::new("strap 3 mm", Kind::Strap, 3.0).aim(99.0),
    Case::new("strap 3 mm, one sweep of 20°", Kind::Strap, 3.0).sweep().aim(99.0),
    Case::new("strap 3 mm, zeros found", Kind::Strap, 3.0).zeros_found().aim(99.0),
    Case::new("strap 1 mm", Kind::Strap, 1.0),
    Case::new("cable 2 mm", Kind::Cable, 2.0).aim(97.0),
    Case::new("cable 2 mm, one sweep of 20°", Kind::Cable, 2.0).sweep().aim(97.0),
    Case::new("cable 2 mm, zeros found", Kind::Cable, 2.0).zeros_found().aim(97.0),
    Case::new("cable 1 mm", Kind::Cable, 1.0),
    Case::new("cuff 3 mm", Kind::Cuff, 3.0),
    Case::new("cuff 3 mm, one sweep of 20°", Kind::Cuff, 3.0).sweep(),
    Case::new("not a ball, 1 mm for 10°", Kind::Drift, 1.0),
    Case::new("not a ball, 3 mm for 10°", Kind::Drift, 3.0),
];

/// What became of one slip.
#[derive(Clone, Copy)]
struct Report {
    /// Time from the slip, s; negative for a false alarm before it.
    after_s: f64,
    cause: Cause<f32>,
    /// Right kind, right cable.
    named: bool,
    /// Angle between the reported and the true direction, degrees; 0 where there is none or the kind is wrong.
    off_deg: f64,
}

fn run(plan: &Plan) -> Result<Findings, Problem> {
    let mut table = Table::new("watch", "What the watch says of slips", &COLUMNS);
    let mut targets = Vec::new();
    for case in &CASES {
        let outcomes =
            trials::run(plan.seed, &format!("watch {}", case.name), plan.trials, |_, random| slip(case, random));
        let reports = outcomes.into_iter().collect::<Result<Vec<_>, Problem>>()?;
        let reports: Vec<_> = reports.into_iter().flatten().collect();
        let tally = Tally::of(&reports);
        table.push(tally.row(case));
        if let Some(aim) = case.aim {
            let what = format!("{}: reported within 2 s, named, direction within 15°, %", case.name);
            targets.push(Target::at_least(what, aim, tally.right()));
        }
    }
    let mut alarms =
        Table::new("watch-alarms", "Alarms without any slip", &["zeros", "hours", "alarms", "an hour, at most (95 %)"]);
    for zeros_known in [true, false] {
        let name = if zeros_known { "known" } else { "found with the centre" };
        let outcomes = trials::run(plan.seed, &format!("watch therapy {zeros_known}"), plan.trials, |_, random| {
            exercise(random, zeros_known)
        });
        let counts = outcomes.into_iter().collect::<Result<Vec<_>, Problem>>()?;
        let hours = counts.iter().flatten().count() as f64 * THERAPY_S / 3600.0;
        let seen: usize = counts.iter().flatten().sum();
        let most = most_events(seen) / hours;
        alarms.push([name.to_string(), short(hours), seen.to_string(), short(most)]);
        targets.push(Target::at_most(format!("zeros {name}: false alarms in 8 h"), 1.0, 8.0 * seen as f64 / hours));
    }
    Ok(Findings { method: METHOD.to_string(), tables: vec![table, alarms], targets, ..Findings::default() })
}

const METHOD: &str = "A trial is a wearer (centre up to ±20 mm, cuff up to ±10 mm off along each axis, 150 mm rig) whose centre the \
    device's solver finds in single precision from twelve poses (thirty when the zeros are unknown), and an arm that then exercises: three angles, each the \
    sum of two slow oscillations; 100 samples a second, noise uniform within ±0.1 mm, rounded to encoder counts. After two seconds \
    something slips at once, in a random direction; the next two seconds turn the arm by 20° or more. One sweep: the arm \
    rests, and turns by exactly 20° about one random axis in those two seconds, and that is all. Zeros found: the encoders' zeros are \
    off by up to ±10 mm, and identified with the centre. Therapy: each wearer exercises for three minutes, resting \
    now and then.";

const COLUMNS: [&str; 9] = [
    "what slips",
    "trials",
    "reported in 2 s",
    "right kind and cable",
    "direction within 15°",
    "all right",
    "direction error, 99 % (°)",
    "after, median (s)",
    "named instead",
];

/// The mishap of a trial, and what was reported within the time. `None` when the poses of the calibration were refused.
fn slip(case: &Case, random: ChaCha8Rng) -> Result<Option<Option<Report>>, Problem> {
    let Some((mut therapy, mut watch)) = Therapy::begin(random, case.zeros_known)? else { return Ok(None) };
    let random = therapy.random();
    let direction = Vector3::from_fn(|_, _| normal(random)).normalize();
    let (cable, sign) = (random.random_range(0..CABLES), if random.random_bool(0.5) { 1.0 } else { -1.0 });
    let mishap = match case.kind {
        Kind::Strap => Mishap::Strap(direction * case.by_mm),
        Kind::Cuff => Mishap::Cuff(direction * case.by_mm),
        Kind::Drift => Mishap::Drift(direction * case.by_mm),
        Kind::Cable => Mishap::Cable(cable, sign * case.by_mm),
    };
    let motion = motion(case, random);
    let samples = ((BEFORE_S + WITHIN_S) * RATE_HZ) as u32;
    for sample in 0..=samples {
        let seconds = f64::from(sample) / RATE_HZ;
        let after_s = seconds - BEFORE_S;
        let now = if after_s >= 0.0 { mishap } else { Mishap::None };
        let at = if case.sweep { after_s } else { seconds };
        let warning = therapy.lengths(&motion.at(at), now).and_then(|lengths| watch.sample(&lengths));
        if let Some(warning) = warning {
            return Ok(Some(Some(Report::of(warning.cause, mishap, after_s))));
        }
    }
    Ok(Some(None))
}

fn motion(case: &Case, random: &mut ChaCha8Rng) -> Motion {
    if case.sweep {
        return Motion::sweep(random, SPAN_RAD, WITHIN_S);
    }
    loop {
        let motion = Motion::free(random);
        if motion.span_rad(BEFORE_S, WITHIN_S) >= SPAN_RAD {
            return motion;
        }
    }
}

/// Alarms of a wearer to whom nothing happens. `None` when the poses of the calibration were refused.
fn exercise(random: ChaCha8Rng, zeros_known: bool) -> Result<Option<usize>, Problem> {
    let Some((mut therapy, mut watch)) = Therapy::begin(random, zeros_known)? else { return Ok(None) };
    let motion = Motion::free(therapy.random());
    let (mut alarms, mut at) = (0, 0.0);
    for sample in 0..(THERAPY_S * RATE_HZ) as u32 {
        // The arm slows down to rest once in forty seconds.
        let pace = 1.0 + libm::sin(f64::from(sample) / RATE_HZ * (std::f64::consts::TAU / 40.0));
        at += pace.min(1.0) / RATE_HZ;
        let warning = therapy.lengths(&motion.at(at), Mishap::None).and_then(|lengths| watch.sample(&lengths));
        if warning.is_some() {
            alarms += 1;
            SlipDetector::rearm(&mut watch);
        }
    }
    Ok(Some(alarms))
}

impl Report {
    fn of(cause: Cause<f32>, mishap: Mishap, after_s: f64) -> Self {
        let angle = |found: Vector3<f32>, true_: Vector3<f64>| found.map(f64::from).angle(&true_).to_degrees();
        let off_deg = match (cause, mishap) {
            (Cause::StrapSlipped(found), Mishap::Strap(moved)) => Some(angle(found, moved)),
            // The platform moved on the arm by d: in {P}, whose axes at home are those of {B} turned about z, the
            // centre moved by -d. Only the angle to z can be compared without that turn.
            (Cause::CuffSlipped(found), Mishap::Cuff(moved)) => {
                Some((angle(found, Vector3::z()) - moved.angle(&-Vector3::z()).to_degrees()).abs())
            }
            (Cause::CableSlipped { cable, .. }, Mishap::Cable(slipped, _)) => {
                (usize::from(cable) == slipped + 1).then_some(0.0)
            }
            (Cause::NotABall(found), Mishap::Drift(per_ten)) => Some(angle(found, per_ten)),
            _ => None,
        };
        Self { after_s, cause, named: off_deg.is_some(), off_deg: off_deg.unwrap_or(0.0) }
    }

    fn is_in_time(&self) -> bool {
        (0.0..=WITHIN_S).contains(&self.after_s)
    }

    fn is_right(&self) -> bool {
        self.is_in_time() && self.named && self.off_deg <= DIRECTION_DEG
    }
}

struct Tally<'a> {
    trials: usize,
    reports: Vec<&'a Report>,
}

impl<'a> Tally<'a> {
    fn of(outcomes: &'a [Option<Report>]) -> Self {
        Self { trials: outcomes.len(), reports: outcomes.iter().flatten().collect() }
    }

    fn count(&self, which: impl Fn(&Report) -> bool) -> usize {
        self.reports.iter().filter(|report| which(report)).count()
    }

    /// All right, %.
    fn right(&self) -> f64 {
        100.0 * self.count(Report::is_right) as f64 / self.trials as f64
    }

    fn row(&self, case: &Case) -> [String; COLUMNS.len()] {
        let share = |which: &dyn Fn(&Report) -> bool| percent(self.count(which), self.trials);
        let mut off: Vec<f64> = self.reports.iter().filter(|r| r.named).map(|r| r.off_deg).collect();
        let mut after: Vec<f64> = self.reports.iter().map(|r| r.after_s).collect();
        [
            case.name.to_string(),
            self.trials.to_string(),
            share(&Report::is_in_time),
            share(&|r| r.named),
            share(&|r| r.named && r.off_deg <= DIRECTION_DEG),
            format!("{} %", short(self.right())),
            if case.kind == Kind::Cable { "-".to_string() } else { short(quantile(&mut off, 0.99)) },
            short(quantile(&mut after, 0.5)),
            self.instead(),
        ]
    }

    /// What was named when it was something else.
    fn instead(&self) -> String {
        let name = |report: &Report| match report.cause {
            Cause::StrapSlipped(_) => "strap",
            Cause::CuffSlipped(_) => "cuff",
            Cause::CableSlipped { .. } => "cable",
            Cause::NotABall(_) => "not a ball",
            Cause::Unknown => "unknown",
        };
        let count = |what| self.count(|report| !report.named && name(report) == what);
        let names = ["strap", "cuff", "cable", "not a ball", "unknown"].into_iter().filter(|&what| count(what) > 0);
        let text: Vec<_> = names.map(|what| format!("{what} ({})", count(what))).collect();
        if text.is_empty() { "-".to_string() } else { text.join(", ") }
    }
}
