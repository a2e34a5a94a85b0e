//! Poses captured while the arm moves freely against poses held still: the same people, through the whole procedure of the
//! device.

use super::findings::{Findings, Plan, Problem, Table, Target, percent, short};
use super::statistics::root_mean_square;
use super::{Study, trials};
use crate::rehearse::{Display, InProcess, KnownMachine, Options, Report, ShoulderReport, Status, rehearse};
use crate::wearer::Wearer;
use clap::Parser;
use glenoid::device::Config;
use glenoid::rig::Rig;

/// A minute of free movement.
pub const STUDY: Study = Study {
    name: "free-motion",
    about: "moving shoulders by a minute of free movement, through the whole procedure, against the same people held still",
    trials: 24,
    run,
};

/// How the base is worn: the share of the shoulder blade's motion that it makes.
const WORN: [(&str, f64); 3] = [("thorax", 0.0), ("half", 0.5), ("blade", 1.0)];
/// How the poses are captured: in motion, the head sliding to and fro within a second or in 3 to 7; or held still.
#[derive(Clone, Copy, PartialEq, Eq)]
enum How {
    Moving,
    SlowSlides,
    Held,
}

impl How {
    const fn name(self) -> &'static str {
        match self {
            Self::Moving => "moving",
            Self::SlowSlides => "slow slides",
            Self::Held => "held",
        }
    }
}
/// From the start to the new centre, s.
const A_MINUTE_S: f64 = 60.0;
/// A free movement may be worse than poses held still by this factor.
const GRANTED: f64 = 1.3;

fn run(plan: &Plan) -> Result<Findings, Problem> {
    let columns =
        ["base", "phases", "poses", "right", "seconds", "path", "said", "across", "said", "live", "99 % covers"];
    let mut table = Table::new("free-motion", "Path of the centre in the second set, mm rms", &columns);
    let (mut targets, mut remarks) = (Vec::new(), Vec::new());
    for (base, follow) in WORN {
        for phases in [1, 2] {
            for how in [How::Moving, How::SlowSlides, How::Held] {
                let people = format!("free motion {follow} {phases}");
                let reports = trials::run(plan.seed, &people, plan.trials, |trial, _| {
                    rehearsal(plan.seed * 1_000_000 + trial, follow, phases == 2, how)
                });
                let reports = reports.into_iter().collect::<Result<Vec<_>, _>>()?;
                let figures = Figures::of(&reports);
                let name = how.name();
                table.push(figures.row(base, phases, name));
                remarks.extend(
                    figures.objections.iter().map(|objection| format!("{base}, {phases}, {name}: {objection}")),
                );
                if how != How::Held {
                    targets.extend(figures.targets(&format!("{base}, {phases} phases, {name}"), base, phases));
                }
            }
        }
    }
    remarks.sort();
    remarks.dedup();
    Ok(Findings { method: METHOD.to_owned(), tables: vec![table], targets, figures: Vec::new(), remarks })
}

const METHOD: &str = "A trial is a person drawn around the scapulohumeral rhythm of de Groot and Brand 2001 who moves the arm \
    freely, tilt to 45° and torsion to ±30° at up to 0.6 rad/s, or holds it still pose by pose; noise within ±0.1 mm, the head slides \
    by 0.35 mm an axis. The device of the firmware captures by itself, identifies, verifies and is asked to accept: 60 free poses, 20 \
    held ones before them in two phases, 20 that verify. The default machine with its stated tolerances. Seconds: the \
    wearer's, from the start to the new centre.";

/// One person through the procedure.
fn rehearsal(person: u64, follow: f64, two_phases: bool, how: How) -> Result<Report, Problem> {
    let (person, follow) = (person.to_string(), follow.to_string());
    let mut arguments = vec![
        "rehearse",
        "--shoulder",
        &person,
        "--follow",
        &follow,
        "--seed",
        &person,
        "--poses",
        "60",
        "--tilt",
        "45",
    ];
    arguments.extend(two_phases.then_some("--two-phase"));
    arguments.extend((how != How::Held).then_some("--free-motion"));
    arguments.extend((how == How::SlowSlides).then_some("--slow-slides"));
    let options = Options::parse_from(arguments);
    let (rig, single) = (Rig::<f64>::shoulder(150.0)?, Rig::<f32>::shoulder(150.0)?);
    let mut bench = InProcess::new(Config::for_rig(single));
    let mut wearer = Wearer::new(rig, options.wearer());
    let known = KnownMachine::built_in(rig, single);
    Ok(rehearse(&mut bench, &mut wearer, &known, &options, &Display::Silent, None))
}

/// Of many people.
struct Figures {
    sets: usize,
    right: usize,
    found: Vec<ShoulderReport>,
    objections: Vec<String>,
}

impl Figures {
    fn of(reports: &[Report]) -> Self {
        let right = reports.iter().filter(|report| report.status == Status::Right).count();
        let found = reports.iter().filter_map(|report| report.shoulder.clone()).collect();
        let objections = reports.iter().flat_map(|report| report.reasons.clone()).collect();
        Self { sets: reports.len(), right, found, objections }
    }

    fn rms(&self, of: fn(&ShoulderReport) -> f64) -> f64 {
        root_mean_square(self.found.iter().map(of))
    }

    fn covered(&self) -> f64 {
        self.found.iter().map(|shoulder| shoulder.covered).sum::<f64>() / self.found.len() as f64
    }

    fn row(&self, base: &str, phases: usize, how: &str) -> [String; 11] {
        [
            base.to_owned(),
            phases.to_string(),
            how.to_owned(),
            percent(self.right, self.sets),
            short(self.found.iter().map(|shoulder| shoulder.wearer_s).sum::<f64>() / self.found.len() as f64),
            short(self.rms(|shoulder| shoulder.path_error_mm)),
            short(self.rms(|shoulder| shoulder.path_sigma_mm)),
            short(self.rms(|shoulder| shoulder.across_error_mm)),
            short(self.rms(|shoulder| shoulder.across_sigma_mm)),
            short(self.rms(|shoulder| shoulder.live_error_mm)),
            format!("{:.1} %", 100.0 * self.covered()),
        ]
    }

    /// Limits of poses held still, with what is granted.
    fn targets(&self, name: &str, base: &str, phases: usize) -> Vec<Target> {
        let (path_mm, across_mm) = if phases == 1 { (3.3, 1.2) } else { (1.8, 1.2) };
        let mut targets = vec![
            Target::at_least(format!("{name}: share right"), 0.95, self.right as f64 / self.sets as f64),
            Target::between(format!("{name}: 99 % bar covers"), (0.96, 1.0), self.covered()),
        ];
        let longest_s = self.found.iter().map(|shoulder| shoulder.wearer_s).fold(0.0, f64::max);
        targets.push(Target::at_most(format!("{name}: longest (s)"), A_MINUTE_S, longest_s));
        if base == "thorax" {
            let [path, across] =
                [self.rms(|shoulder| shoulder.path_error_mm), self.rms(|shoulder| shoulder.across_error_mm)];
            targets.push(Target::at_most(format!("{name}: path (mm)"), GRANTED * path_mm, path));
            targets.push(Target::at_most(format!("{name}: across the arm (mm)"), GRANTED * across_mm, across));
        }
        targets
    }
}
