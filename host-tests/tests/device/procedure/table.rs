//! Every (state, event) pair: the picture in the documentation, the table in the code and the device's behaviour.

use super::bench::Bench;
use glenoid::can::Opcode;
use glenoid::procedure::transition::next;
use glenoid::procedure::{PoseSet, Reason, StateName, Trigger};
use std::collections::BTreeSet;

/// The transitions drawn in the documentation of the procedure.
fn drawn() -> BTreeSet<(String, String, String)> {
    include_str!("../../../../src/procedure/mod.rs")
        .lines()
        .filter_map(|line| {
            let (from, rest) = line.strip_prefix("//! ")?.split_once(" --")?;
            let (trigger, to) = rest.split_once("-->")?;
            Some((from.trim().to_owned(), trigger.to_owned(), to.trim().to_owned()))
        })
        .collect()
}

#[test]
fn every_transition_is_drawn_and_no_other_exists() {
    let mut in_code = BTreeSet::new();
    for state in StateName::ALL {
        for trigger in Trigger::ALL {
            if let Some(to) = next(state, trigger) {
                in_code.insert((format!("{state:?}"), format!("{trigger:?}"), format!("{to:?}")));
            }
        }
    }
    assert_eq!(drawn(), in_code);
    assert_eq!(in_code.len(), 24);
}

#[test]
fn every_state_can_be_left_and_aborted_to_idle() {
    for state in StateName::ALL {
        assert_eq!(next(state, Trigger::Abort), Some(StateName::Idle));
    }
}

/// Each command with the answer to it and the state after it.
type Answers = [(Opcode, Reason, StateName); 8];

/// For each state: what each command is answered, and the state after it. Written from the description of the
/// procedure, not from its code.
const COMMANDS: [(StateName, Answers); 6] = {
    use Opcode::*;
    use Reason::*;
    use StateName::*;
    [
        (
            Idle,
            [
                (Start, Fine, Collecting),
                (Capture, WrongState, Idle),
                (Identify, WrongState, Idle),
                (Verify, WrongState, Idle),
                (Accept, WrongState, Idle),
                (Reject, WrongState, Idle),
                (Abort, Fine, Idle),
                (Acknowledge, Fine, Idle),
            ],
        ),
        (
            Collecting,
            [
                (Start, AlreadyRunning, Collecting),
                (Capture, Fine, Collecting),
                (Identify, TooFewPoses, Collecting),
                (Verify, WrongState, Collecting),
                (Accept, WrongState, Collecting),
                (Reject, WrongState, Collecting),
                (Abort, Fine, Idle),
                (Acknowledge, WrongState, Collecting),
            ],
        ),
        (
            Identifying,
            [
                (Start, AlreadyRunning, Identifying),
                (Capture, WrongState, Identifying),
                (Identify, WrongState, Identifying),
                (Verify, WrongState, Identifying),
                (Accept, WrongState, Identifying),
                (Reject, WrongState, Identifying),
                (Abort, Fine, Idle),
                (Acknowledge, WrongState, Identifying),
            ],
        ),
        (
            Verifying,
            [
                (Start, AlreadyRunning, Verifying),
                // the arm still rests in the last pose of the first set
                (Capture, PoseTooNear, Verifying),
                (Identify, WrongState, Verifying),
                (Verify, TooFewPoses, Verifying),
                (Accept, WrongState, Verifying),
                (Reject, WrongState, Verifying),
                (Abort, Fine, Idle),
                (Acknowledge, WrongState, Verifying),
            ],
        ),
        (
            Review,
            [
                (Start, AlreadyRunning, Review),
                (Capture, WrongState, Review),
                (Identify, WrongState, Review),
                (Verify, WrongState, Review),
                (Accept, Fine, Idle),
                (Reject, Fine, Idle),
                (Abort, Fine, Idle),
                (Acknowledge, Fine, Review),
            ],
        ),
        (
            Failed,
            [
                (Start, AcknowledgeFirst, Failed),
                (Capture, WrongState, Failed),
                (Identify, WrongState, Failed),
                (Verify, WrongState, Failed),
                (Accept, WrongState, Failed),
                (Reject, WrongState, Failed),
                (Abort, Fine, Idle),
                (Acknowledge, Fine, Idle),
            ],
        ),
    ]
};

#[test]
fn every_command_in_every_state() {
    for (state, commands) in COMMANDS {
        let mut led = Bench::new(21);
        led.lead_to(state);
        assert_eq!(led.state(), state);
        // as if a run had been before, so that a run can be named in every state
        for (opcode, reason, after) in commands {
            let mut bench = led.fork();
            let named = matches!(opcode, Opcode::Accept | Opcode::Reject | Opcode::Acknowledge);
            let run_id = if named { bench.procedure().run_id() } else { 0 };
            let answer = match (opcode, state) {
                (Opcode::Accept, StateName::Review) => bench.accept(),
                _ => bench.request(opcode as u8, run_id, 0),
            };
            let reason = match (state, named) {
                // before the first run there is no run that could be named
                (StateName::Idle, true) => Reason::BadArgument,
                _ => reason,
            };
            assert_eq!((answer.code, bench.state()), (reason, after), "{opcode:?} in {state:?}");
        }
    }
}

/// In the idle state after a run, the run can be named.
#[test]
fn decisions_after_the_run_are_refused() {
    let mut bench = Bench::new(22);
    bench.lead_to(StateName::Collecting);
    bench.command(Opcode::Abort);
    let idle = COMMANDS[0].1;
    for (opcode, reason, after) in &idle[4..6] {
        let answer = bench.decide(*opcode);
        assert_eq!((answer.code, bench.state()), (*reason, *after), "{opcode:?}");
    }
    assert_eq!(bench.decide(Opcode::Acknowledge).code, Reason::Fine);
}

#[test]
fn a_refused_command_changes_nothing() {
    for (state, commands) in COMMANDS {
        let mut led = Bench::new(23);
        led.lead_to(state);
        for (opcode, reason, _) in commands {
            if reason == Reason::Fine || (state, opcode) == (StateName::Verifying, Opcode::Capture) {
                continue;
            }
            let mut bench = led.fork();
            let run_id = if opcode as u8 >= 5 { bench.procedure().run_id() } else { 0 };
            bench.request(opcode as u8, run_id, 0);
            assert_eq!(format!("{:?}", bench.procedure()), format!("{:?}", led.procedure()), "{opcode:?} in {state:?}");
        }
    }
}

/// The triggers that no command sends, in the states in which they mean something.
#[test]
fn what_happens_by_itself() {
    // solver: found
    let mut bench = Bench::new(24);
    bench.lead_to(StateName::Identifying);
    bench.pass(300);
    assert_eq!(bench.state(), StateName::Verifying);
    // second set: nobody goes on
    let mut late = bench.fork();
    late.pass(120_000);
    assert_eq!((late.state(), late.heartbeat().reason), (StateName::Failed, Reason::VerifyingTimeout));
    assert_eq!(late.procedure().poses(PoseSet::Identification).len(), 12, "the poses can still be read out");
    // review: nobody decides
    let mut undecided = Bench::new(24);
    undecided.lead_to(StateName::Review);
    undecided.pass(300_000);
    assert_eq!((undecided.state(), undecided.heartbeat().reason), (StateName::Failed, Reason::ReviewTimeout));
    // collecting: nobody goes on
    let mut idle = Bench::new(24);
    idle.lead_to(StateName::Failed);
    assert_eq!((idle.state(), idle.heartbeat().reason), (StateName::Failed, Reason::CollectingTimeout));
}

/// The solver refuses again and again: the run goes on collecting a few times, then it gives up with the reason.
#[test]
fn the_solver_gives_up_after_some_attempts() {
    let mut bench = Bench::turning_only(25);
    bench.lead_to(StateName::Collecting);
    let mut attempts = 0;
    bench.capture(6);
    while bench.state() == StateName::Collecting {
        assert_eq!(bench.command(Opcode::Identify).code, Reason::Fine);
        bench.pass(100);
        attempts += 1;
    }
    assert_eq!(attempts, 5);
    assert_eq!((bench.state(), bench.heartbeat().reason), (StateName::Failed, Reason::OneAxis));
}
