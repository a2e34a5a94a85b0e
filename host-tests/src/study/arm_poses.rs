//! Which further poses narrow the hand's covariance: those that are proposed, or any others?

mod person;

use super::arm::{CASES, Case, HAND_MM};
use super::findings::{Findings, Plan, Problem, Table, Target, percent, short};
use super::statistics::{quantile, root_mean_square};
use super::{Study, trials};
use crate::arm::{PROPOSED, Proposer};
use glenoid::identification::arm::{ArmPose, FurtherPoses, Module};
use nalgebra::Vector3;
use person::{Found, Logs, Person};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// Proposed poses against random ones.
pub const STUDY: Study = Study {
    name: "arm-poses",
    about: "the hand's sigma from 30 random poses of each module, then with 5 proposed ones each, and with 5 random ones",
    trials: 300,
    run,
};

/// Random poses of each module.
const POSES: usize = 30;

const METHOD: &str = "A trial is an arm of `cargo study arm`, identified from 30 random poses of each module, and a posture. Then five \
    further poses of each module: those that `cargo arm` would propose for the hand in that posture, and, from the same 30 again, \
    random ones. The arm goes there and is identified anew each time. σ is the root of the hand's summed variances, as reported. An \
    arm counts when all of its modules are accepted all three times.";

/// The hand by one identification.
#[derive(Clone, Copy)]
struct Hand {
    sigma_mm: f64,
    /// Squared error over the covariance, three degrees of freedom.
    chi_square: f64,
}

/// An arm: with its first poses, with proposed ones, with random ones.
struct Outcome {
    hands: [Hand; 3],
    /// σ with the proposed ones as it was predicted, mm.
    predicted_mm: f64,
}

fn run(plan: &Plan) -> Result<Findings, Problem> {
    let columns = [
        "machines",
        "arms that count",
        "30 poses: median σ of the hand (mm)",
        "5 proposed more: σ (mm)",
        "5 random more: σ (mm)",
        "proposed: σ over before",
        "random: σ over before",
        "proposed: σ over predicted",
    ];
    let mut table = Table::new("arm-poses", "The hand's σ after further poses of each module (medians)", &columns);
    let columns = ["machines", "30 poses", "5 proposed more", "5 random more"];
    let mut bars = Table::new("arm-poses-bars", "Real over reported σ of the hand", &columns);
    let mut findings = Findings { method: METHOD.to_owned(), ..Findings::default() };
    for case in &CASES {
        let name = case.name;
        let outcomes =
            trials::run(plan.seed, &format!("arm-poses {name}"), plan.trials, |_, random| trial(case, random));
        let arms: Vec<_> = outcomes.into_iter().flatten().collect();
        let median = |of: &dyn Fn(&Outcome) -> f64| quantile(&mut arms.iter().map(of).collect::<Vec<_>>(), 0.5);
        let sigma = |which: usize| median(&|arm| arm.hands[which].sigma_mm);
        let over_before = |which: usize| median(&|arm| arm.hands[which].sigma_mm / arm.hands[0].sigma_mm);
        let over_predicted = median(&|arm| arm.hands[1].sigma_mm / arm.predicted_mm);
        table.push([
            name.to_owned(),
            percent(arms.len(), plan.trials as usize),
            short(sigma(0)),
            short(sigma(1)),
            short(sigma(2)),
            short(over_before(1)),
            short(over_before(2)),
            short(over_predicted),
        ]);
        let ratio =
            |which: usize| root_mean_square(arms.iter().map(|arm| libm::sqrt(arm.hands[which].chi_square / 3.0)));
        bars.push([name.to_owned(), short(ratio(0)), short(ratio(1)), short(ratio(2))]);
        findings.targets.extend([
            Target::at_most(format!("{name}: σ with proposed poses over that with random ones"), 1.0, {
                median(&|arm| arm.hands[1].sigma_mm / arm.hands[2].sigma_mm)
            }),
            Target::between(
                format!("{name}: σ with proposed poses over the predicted one"),
                (0.95, 1.05),
                over_predicted,
            ),
        ]);
    }
    findings.tables.extend([table, bars]);
    Ok(findings)
}

fn trial(case: &Case, mut random: ChaCha8Rng) -> Option<Outcome> {
    let random = &mut random;
    let person = Person::new(random, case)?;
    let mut first = Logs::default();
    person.go_anywhere(random, &mut first, POSES);
    let found = person.identified(&first)?;
    let (posture, at_mm) = person.posture(random)?;
    let hand = |found: &Found| hand(&person, found, &posture, &at_mm);

    let chain = person.chain(&found);
    let proposer = Proposer { arm: &chain, posture: &posture, hand_mm: HAND_MM, seed: random.random() };
    let shoulder = proposer.of_ball(Module::Shoulder, &found.shoulder.poses, person.shoulder.home_mm(), 1);
    let elbow = proposer.of_elbow(&found.elbow.poses);
    let wrist = proposer.of_ball(Module::Wrist, &found.wrist.poses, person.wrist.home_mm(), 1);
    let mut proposed = first.clone();
    for at in &shoulder {
        person.shoulder.go_to(random, &mut proposed.shoulder, &found.shoulder, &at.pose.rotation());
    }
    elbow.iter().for_each(|at| person.elbow.go_to(random, &mut proposed.elbow, &found.elbow, at.pose));
    for at in &wrist {
        person.wrist.go_to(random, &mut proposed.wrist, &found.wrist, &at.pose.rotation());
    }
    let predicted_mm = proposer.sigma_mm(&FurtherPoses {
        shoulder: &shoulder.iter().map(|at| at.pose).collect::<Vec<_>>(),
        elbow_rad: &elbow.iter().map(|at| at.pose).collect::<Vec<_>>(),
        wrist: &wrist.iter().map(|at| at.pose).collect::<Vec<_>>(),
    })?;
    let mut others = first;
    person.go_anywhere(random, &mut others, PROPOSED);
    let hands = [hand(&found)?, hand(&person.identified(&proposed)?)?, hand(&person.identified(&others)?)?];
    Some(Outcome { hands, predicted_mm })
}

fn hand(person: &Person, found: &Found, posture: &ArmPose<f64>, at_mm: &Vector3<f64>) -> Option<Hand> {
    let hand = person.chain(found).position(posture, &HAND_MM).ok()?.hand;
    let error = hand.at_mm - at_mm;
    let chi_square = error.dot(&(hand.covariance_mm2.try_inverse()? * error));
    Some(Hand { sigma_mm: libm::sqrt(hand.covariance_mm2.trace()), chi_square })
}
