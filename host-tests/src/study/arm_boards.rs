//! The whole arm on three boards: what `cargo rehearse --arm` does, with the devices in this process, for many arms.

use super::findings::{Findings, Plan, Problem, Table, Target, percent, short};
use super::statistics::root_mean_square;
use super::{Study, trials};
use crate::rehearse::arm::{ArmReport, InProcessBus, Limb, rehearse_arm};
use crate::rehearse::{Display, Options, Status};
use clap::Parser;
use rand::Rng;

/// Three devices on one bus, many times.
pub const STUDY: Study = Study {
    name: "arm-boards",
    about: "the whole arm on three boards of one bus: the hand's real error over its reported sigma, host and boards to the bit",
    trials: 1_000,
    run,
};

/// Trials with machines that are as drawn for each one with machines that are not, whose elbow takes long.
const FEWER: u64 = 5;

const METHOD: &str = "A trial is `cargo rehearse --arm` with a seed of its own and the devices of the three boards in this process, on one \
    bus: told their rigs and identifiers, calibrated from the thorax outwards by 30 poses (the elbow by 20 angles) with noise within ±0.1 mm, accepted, \
    restarted; then the hand in three postures, from the lengths that the boards send, against where it is. Machines are as \
    drawn; or, in a fifth as many trials, off by .5/.5/.3/.1 % (`--machine-tolerance`), which the boards are told. Mounts are off by \
    .3 mm and 2 mrad, which the chain is told. An arm counts when all three boards accept.";

fn run(plan: &Plan) -> Result<Findings, Problem> {
    let columns =
        ["machines", "arms accepted", "host and boards to the bit", "hand: real / reported σ", "upper arm", "forearm"];
    let mut table = Table::new("arm-boards", "The hand through three boards", &columns);
    let columns = ["machines", "hand: rms error (mm)", "σ from shoulder", "elbow", "wrist", "mounts (mm)"];
    let mut parts = Table::new("arm-boards-parts", "What the hand's error is made of", &columns);
    let mut findings = Findings { method: METHOD.to_owned(), ..Findings::default() };
    for (case, machine_tolerance) in [("as drawn", false), (".5/.5/.3/.1 %", true)] {
        let options = Options { machine_tolerance, ..Options::parse_from(["rehearse", "--arm"]) };
        let (name, trials) = match machine_tolerance {
            false => ("arm-boards", plan.trials),
            true => ("arm-boards not as drawn", plan.trials.div_ceil(FEWER)),
        };
        let outcomes = trials::run(plan.seed, name, trials, |_, mut random| {
            let options = Options { seed: random.random(), ..options.clone() };
            rehearse_arm(&mut InProcessBus::default(), &options, &Display::Silent)
        });
        let arms: Vec<&ArmReport> = outcomes.iter().filter(|arm| arm.status != Status::Failed).collect();
        let (count, all) = (arms.len(), trials as usize);
        let hands = || arms.iter().flat_map(|arm| &arm.hand);
        let hand = root_mean_square(hands().map(|hand| libm::sqrt(hand.chi_square / 3.0)));
        let limb = |which: usize| {
            let limbs = arms.iter().filter_map(|arm| arm.limbs.as_ref().map(|limbs| &limbs[which]));
            root_mean_square(limbs.map(|Limb { length_mm, sigma_mm, true_mm }| (length_mm - true_mm) / sigma_mm))
        };
        let (upper_arm, forearm) = (limb(0), limb(1));
        let agree = arms.iter().filter(|arm| arm.host_agrees()).count();
        let (accepted, agreed) = (percent(count, all), percent(agree, count));
        table.push([case.to_owned(), accepted, agreed, short(hand), short(upper_arm), short(forearm)]);
        let part = |k: usize| short(root_mean_square(hands().map(|hand| hand.by_module_mm[k])));
        let error = short(root_mean_square(hands().map(|hand| hand.error_mm)));
        parts.push([case.to_owned(), error, part(0), part(1), part(2), part(3)]);
        for (name, ratio) in [("hand", hand), ("upper arm's length", upper_arm), ("forearm's length", forearm)] {
            // A fifth of the arms scatter more.
            let within = if machine_tolerance { (0.85, 1.15) } else { (0.95, 1.05) };
            findings.targets.push(Target::between(format!("{case}: {name}: real / reported σ"), within, ratio));
        }
        let share = agree as f64 / count.max(1) as f64;
        findings.targets.push(Target::at_least(format!("{case}: host and boards to the bit"), 1.0, share));
        let wrong = hands().filter(|hand| hand.objection().is_some()).count();
        findings.targets.push(Target::at_most(format!("{case}: hands outside their bar"), 0.0, wrong as f64));
        let mut reasons: Vec<_> = outcomes.iter().filter(|arm| arm.status == Status::Failed).map(reason).collect();
        reasons.sort();
        let mut counted: Vec<(String, usize)> = Vec::new();
        for reason in reasons {
            match counted.last_mut().filter(|(last, _)| *last == reason) {
                Some((_, count)) => *count += 1,
                None => counted.push((reason, 1)),
            }
        }
        let remark = |(reason, count): (String, usize)| format!("{case}: {count} refused: {reason}");
        findings.remarks.extend(counted.into_iter().map(remark));
    }
    findings.tables.extend([table, parts]);
    Ok(findings)
}

/// Why an arm was refused: the reason without its figures.
fn reason(arm: &ArmReport) -> String {
    let reason = arm.reasons.first().map_or("", String::as_str);
    reason.split(['(', '.']).next().unwrap_or_default().trim().to_owned()
}
