//! Runs of the procedure on the emulated board: many in a row, with clients that vanish, on a crowded bus.

use crate::scene::Scene;
use glenoid::can::{Message, Opcode};
use glenoid::procedure::{Reason, StateName};
use libtest_mimic::Failed;
use std::path::Path;
use std::time::Instant;

/// Set this to a number to run as many calibrations in a row (100 take about eight minutes).
const RUNS_VARIABLE: &str = "GLENOID_RUNS";

/// Each calibration has its own run id, everything reported in it carries that id, and the centre is right.
pub fn calibrations_in_a_row(image: &Path) -> Result<(), Failed> {
    let runs = std::env::var(RUNS_VARIABLE).ok().and_then(|runs| runs.parse().ok()).unwrap_or(3);
    let mut scene = Scene::new(image, 21)?;
    let truth = scene.wearer.truth().centre_mm;
    for run in 1..=runs {
        let run_id = scene.run_to_review(6)?;
        assert_eq!(run_id, run);
        for axis in 0..3 {
            let candidate = scene.wait("candidate", |message| match message {
                Message::CandidateCentre(p) if p.index == axis => Some(*p),
                _ => None,
            })?;
            assert_eq!(candidate.run_id, run);
            let error_mm = f64::from(candidate.value_mm) - truth[usize::from(axis)];
            assert!(error_mm.abs() < 5.0 * f64::from(candidate.sigma_mm), "run {run}: {candidate:?}, truth {truth}");
        }
        let answer = scene.accept(run_id)?;
        assert_eq!((answer.code, answer.run_id), (Reason::Fine, run));
        let outcome = scene.wait("outcome", |message| match message {
            Message::Outcome(outcome) if outcome.reason != Reason::Fine => Some(*outcome),
            _ => None,
        })?;
        assert_eq!((outcome.run_id, outcome.reason, outcome.live), (run, Reason::Accepted, true));
        assert_eq!(scene.ask(Opcode::Acknowledge, run_id, 0)?.code, Reason::Fine);
    }
    Ok(())
}

/// The client vanishes in the middle of a run; another one comes, knows nothing, and is told where the run stands.
pub fn a_client_that_returns_is_told(image: &Path) -> Result<(), Failed> {
    let mut scene = Scene::new(image, 22)?;
    let run_id = scene.ask_when_still(Opcode::Start, 1)?.run_id;
    scene.capture(3)?;
    let mut scene = scene.with_a_new_client()?;
    let answer = scene.ask(Opcode::Query, 0, 0)?;
    assert_eq!((answer.run_id, answer.detail), (run_id, u16::from(StateName::Collecting.code())));
    let heartbeat = scene.wait("heartbeat", |m| if let Message::Heartbeat(h) = m { Some(*h) } else { None })?;
    assert_eq!((heartbeat.run_id, heartbeat.state, heartbeat.poses), (run_id, StateName::Collecting, 3));
    scene.capture(4)?;
    scene.ask(Opcode::Identify, run_id, 0)?;
    scene.wait_for_state(StateName::Verifying)
}

/// 2 000 foreign frames a second while a calibration runs: the calibration ends as it would, the frames are counted.
pub fn a_crowded_bus_changes_nothing_but_a_counter(image: &Path) -> Result<(), Failed> {
    let mut scene = Scene::new(image, 23)?;
    scene.crowd = 20;
    let began = Instant::now();
    scene.run_to_review(5)?;
    let seconds = began.elapsed().as_secs_f64();
    scene.crowd = 0;
    eprintln!("{:.0} foreign frames a second", f64::from(scene.sent) / seconds);
    assert!(scene.sent > 2_000, "only {} frames in {seconds} s", scene.sent);
    scene.ask(Opcode::Query, 0, 0)?;
    let counters = scene.wait("counters", |m| if let Message::Counters(c) = m { Some(*c) } else { None })?;
    assert_eq!((counters.foreign, counters.malformed), (scene.sent, 0));
    Ok(())
}
