//! Everything that can be wrong with what comes in: each has its own answer, and nothing collected is lost.

use super::bench::{Bench, SAMPLE_MS};
use glenoid::can::status::Answer;
use glenoid::can::{BaseId, Frame, Message, Opcode, Request};
use glenoid::device::Event;
use glenoid::procedure::{PoseSet, Reason, StateName};

fn faults(bench: &mut Bench) -> Vec<(Reason, u8, bool)> {
    bench
        .take_messages()
        .iter()
        .filter_map(|m| if let Message::Fault(f) = m { Some((f.code, f.cable, f.active)) } else { None })
        .collect()
}

#[test]
fn what_is_no_command_is_answered_with_its_own_code() {
    let mut bench = Bench::new(41);
    bench.lead_to(StateName::Collecting);
    bench.capture(3);
    let id = BaseId::DEFAULT.command().as_raw();
    let mut ask = |bytes: &[u8]| bench.raw(Frame::new(id, bytes).unwrap());
    assert_eq!(ask(&[99, 0, 7, 0, 0, 0, 0, 0]).code, Reason::UnknownOpcode);
    assert_eq!(ask(&[0, 0, 8, 0, 0, 0, 0, 0]).code, Reason::UnknownOpcode);
    assert_eq!(ask(&[7, 0, 9, 0, 0, 0, 0]).code, Reason::WrongLength);
    assert_eq!(ask(&[]).code, Reason::WrongLength);
    assert_eq!(ask(&[7, 1, 10, 0, 0, 0, 0, 0]).code, Reason::ReservedNotZero);
    // abort takes no argument, start no run, accept no other run
    assert_eq!(ask(&[7, 0, 11, 0, 0, 0, 1, 0]).code, Reason::BadArgument);
    assert_eq!(ask(&[1, 0, 12, 0, 1, 0, 0, 0]).code, Reason::BadArgument);
    assert_eq!(ask(&[5, 0, 13, 0, 0, 0, 0, 0]).code, Reason::BadArgument);
    assert_eq!(ask(&[5, 0, 14, 0, 2, 0, 0, 0]).code, Reason::StaleRun);
    assert_eq!(ask(&[7, 0, 15, 0, 2, 0, 0, 0]).code, Reason::StaleRun);
    assert_eq!(ask(&[1, 0, 16, 0, 0, 0, 0, 0]).code, Reason::AlreadyRunning);
    // nonce and opcode come back even from half a frame
    let answer = ask(&[7, 0, 0x34, 0x12]);
    assert_eq!((answer.opcode, answer.nonce, answer.code), (7, 0x1234, Reason::WrongLength));
    assert_eq!((bench.state(), bench.procedure().poses(PoseSet::Identification).len()), (StateName::Collecting, 3));
}

#[test]
fn a_stale_accept_does_not_accept() {
    let mut bench = Bench::new(42);
    bench.lead_to(StateName::Review);
    bench.decide(Opcode::Reject);
    bench.lead_to(StateName::Review);
    assert_eq!(bench.request(Opcode::Accept as u8, 1, 0).code, Reason::StaleRun);
    assert_eq!(bench.state(), StateName::Review);
    assert!(bench.procedure().live().is_none());
}

#[test]
fn a_repeated_frame_is_answered_but_not_obeyed_again() {
    let mut bench = Bench::new(43);
    bench.lead_to(StateName::Collecting);
    bench.next_pose();
    let capture = Frame::new(BaseId::DEFAULT.command().as_raw(), &[2, 0, 77, 0, 0, 0, 0, 0]).unwrap();
    let first = bench.raw(capture);
    bench.pass(200);
    let second = bench.raw(capture);
    assert_eq!((first, first.code), (second, Reason::Fine));
    assert_eq!(bench.procedure().poses(PoseSet::Identification).len(), 1);
    // later it is a new wish
    bench.pass(2_000);
    assert_eq!(bench.raw(capture).code, Reason::PoseTooNear);
}

/// Answers among the messages from `before` on.
fn answers(bench: &Bench, before: usize) -> Vec<Answer> {
    let answers = bench.messages[before..].iter();
    answers.filter_map(|message| if let Message::Answer(answer) = message { Some(*answer) } else { None }).collect()
}

#[test]
fn a_frame_repeated_while_the_pose_is_looked_at_is_answered_once() {
    let mut bench = Bench::new(43);
    bench.lead_to(StateName::Collecting);
    bench.next_pose();
    let before = bench.messages.len();
    let capture = Frame::new(BaseId::DEFAULT.command().as_raw(), &[2, 0, 77, 0, 0, 0, 0, 0]).unwrap();
    bench.event(Event::Can(capture));
    bench.event(Event::Can(capture));
    assert!(answers(&bench, before).is_empty(), "the pose has not been looked at yet");
    bench.pass(20);
    let codes: Vec<Reason> = answers(&bench, before).iter().map(|answer| answer.code).collect();
    assert_eq!(codes, [Reason::Fine]);
    assert_eq!(bench.procedure().poses(PoseSet::Identification).len(), 1);
}

#[test]
fn a_capture_that_the_end_of_the_run_overtakes_is_answered_and_takes_no_pose() {
    let mut bench = Bench::new(45);
    bench.lead_to(StateName::Collecting);
    bench.next_pose();
    let before = bench.messages.len();
    bench.event(Event::Can(Frame::new(BaseId::DEFAULT.command().as_raw(), &[2, 0, 78, 0, 0, 0, 0, 0]).unwrap()));
    bench.command(Opcode::Abort);
    bench.pass(20);
    let codes: Vec<(u8, Reason)> = answers(&bench, before).iter().map(|answer| (answer.opcode, answer.code)).collect();
    assert!(codes.contains(&(Opcode::Capture as u8, Reason::WrongState)), "{codes:?}");
    assert!(codes.contains(&(Opcode::Abort as u8, Reason::Fine)), "{codes:?}");
    assert_eq!(codes.len(), 2);
    assert_eq!(bench.state(), StateName::Idle);
    assert!(bench.procedure().poses(PoseSet::Identification).is_empty());
}

fn command(opcode: Opcode, nonce: u16, argument: u16) -> Event {
    let request = Request { opcode: opcode as u8, boot: 0, nonce, run_id: 0, argument };
    Event::Can(request.pack(BaseId::DEFAULT.command()))
}

/// Every asker gets his own answer, also when the next one asks before the last has been answered.
#[test]
fn a_second_capture_between_a_pose_and_its_answer_takes_no_answer_away() {
    let mut bench = Bench::new(46);
    bench.lead_to(StateName::Verifying);
    bench.next_pose();
    let before = bench.messages.len();
    bench.event(command(Opcode::Capture, 501, 0));
    while bench.device.is_busy() {
        bench.event(Event::Tick);
    }
    bench.event(command(Opcode::Capture, 502, 0));
    bench.pass(20);
    let codes: Vec<(u16, Reason)> = answers(&bench, before).iter().map(|answer| (answer.nonce, answer.code)).collect();
    assert_eq!(codes, [(501, Reason::Fine), (502, Reason::PoseTooNear)]);
}

#[test]
fn a_capture_of_the_next_run_does_not_get_the_answer_of_the_last() {
    let mut bench = Bench::new(47);
    bench.lead_to(StateName::Collecting);
    bench.next_pose();
    let before = bench.messages.len();
    bench.event(command(Opcode::Capture, 501, 0));
    bench.event(command(Opcode::Abort, 502, 0));
    bench.event(command(Opcode::Start, 503, 1));
    bench.event(command(Opcode::Capture, 504, 0));
    bench.pass(20);
    let mut codes: Vec<(u16, Reason)> =
        answers(&bench, before).iter().map(|answer| (answer.nonce, answer.code)).collect();
    codes.sort_by_key(|(nonce, _)| *nonce);
    assert_eq!(codes, [(501, Reason::WrongState), (502, Reason::Fine), (503, Reason::Fine), (504, Reason::Fine)]);
}

/// The solver works on the poses that were there when it was asked.
#[test]
fn a_capture_that_the_solver_overtakes_is_answered_and_takes_no_pose() {
    let mut bench = Bench::new(48);
    bench.lead_to(StateName::Collecting);
    while bench.procedure().poses(PoseSet::Identification).len() < 6 {
        bench.next_pose();
        bench.command(Opcode::Capture);
        bench.pass(20);
    }
    bench.next_pose();
    let (before, poses) = (bench.messages.len(), bench.procedure().poses(PoseSet::Identification).len());
    bench.event(command(Opcode::Capture, 501, 0));
    bench.event(command(Opcode::Identify, 502, 0));
    bench.pass(20);
    let codes: Vec<(u16, Reason)> = answers(&bench, before).iter().map(|answer| (answer.nonce, answer.code)).collect();
    assert!(codes.contains(&(501, Reason::WrongState)), "{codes:?}");
    assert!(codes.contains(&(502, Reason::Fine)), "{codes:?}");
    assert_eq!(bench.procedure().poses(PoseSet::Identification).len(), poses);
}

#[test]
fn foreign_traffic_changes_nothing_but_a_counter() {
    let mut calm = Bench::new(44);
    calm.lead_to(StateName::Collecting);
    calm.capture(4);
    let mut flooded = calm.fork();
    // two frames a millisecond for two seconds, also such as look like the device's own
    for step in 0..2_000u16 {
        for id in [step % 0x680, 0x681 + step % 23] {
            let bytes = step.to_le_bytes();
            flooded.event(Event::Can(Frame::new(id, &[bytes[0], bytes[1], 5, 5, 5, 5, 5, 5]).unwrap()));
        }
        flooded.pass(1);
    }
    calm.pass(2_000);
    assert_eq!(format!("{:?}", flooded.procedure()), format!("{:?}", calm.procedure()));
    assert_eq!(flooded.take_messages().len(), calm.take_messages().len());
    flooded.command(Opcode::Query);
    flooded.pass(100);
    let counters =
        flooded.take_messages().into_iter().find_map(|m| if let Message::Counters(c) = m { Some(c) } else { None });
    assert_eq!(counters.unwrap().foreign, 4_000);
}

#[test]
fn a_receive_overrun_is_counted_and_told_without_flooding() {
    let mut bench = Bench::new(45);
    bench.take_messages();
    for _ in 0..500 {
        bench.event(Event::ReceiveOverrun { lost: 2 });
        bench.pass(2);
    }
    bench.pass(1_100);
    let faults = faults(&mut bench);
    assert!(faults.iter().all(|f| *f == (Reason::ReceiveOverrun, 0, false)));
    assert!((1..=3).contains(&faults.len()), "{faults:?}");
    bench.command(Opcode::Query);
    bench.pass(50);
    assert!(bench.messages.iter().any(|m| matches!(m, Message::Counters(c) if c.overruns == 1_000)));
}

#[test]
fn a_moving_arm_is_neither_captured_nor_does_it_start_a_run() {
    let mut bench = Bench::new(46);
    let pose = bench.wearer.next_pose();
    bench.move_to(pose);
    assert_eq!(bench.command(Opcode::Start).code, Reason::ArmMoving);
    bench.pass(600);
    assert_eq!(bench.request(Opcode::Start as u8, 0, 1).code, Reason::Fine);
    let pose = bench.wearer.next_pose();
    bench.move_to(pose);
    assert_eq!(bench.command(Opcode::Capture).code, Reason::ArmMoving);
}

#[test]
fn silent_encoders_are_told_and_nothing_is_lost() {
    let mut bench = Bench::new(47);
    bench.lead_to(StateName::Collecting);
    bench.capture(5);
    bench.take_messages();
    bench.silent = true;
    bench.pass(2_000);
    assert_eq!(faults(&mut bench).first(), Some(&(Reason::EncoderSilent, 0, true)));
    assert_eq!(bench.command(Opcode::Capture).code, Reason::EncoderSilent);
    assert_eq!(bench.heartbeat().reason, Reason::EncoderSilent);
    assert!(!bench.heartbeat().flags.encoders);
    bench.silent = false;
    bench.pass(600);
    assert_eq!(faults(&mut bench).last(), Some(&(Reason::EncoderSilent, 0, false)));
    assert_eq!((bench.state(), bench.procedure().poses(PoseSet::Identification).len()), (StateName::Collecting, 5));
    bench.capture(1);
}

#[test]
fn without_encoders_no_run_starts() {
    let mut bench = Bench::new(48);
    bench.silent = true;
    bench.pass(1_000);
    assert_eq!(bench.command(Opcode::Start).code, Reason::EncoderSilent);
}

#[test]
fn a_frozen_encoder_is_named() {
    for cable in 0..6 {
        let mut bench = Bench::new(49);
        bench.lead_to(StateName::Collecting);
        bench.capture(2);
        bench.frozen = Some(cable);
        bench.take_messages();
        bench.next_pose();
        bench.next_pose();
        let answer = bench.command(Opcode::Capture);
        assert_eq!((answer.code, answer.detail), (Reason::EncoderFrozen, cable as u16 + 1));
        assert!(faults(&mut bench).contains(&(Reason::EncoderFrozen, cable as u8 + 1, true)));
        assert_eq!(bench.procedure().poses(PoseSet::Identification).len(), 2);
    }
}

#[test]
fn a_glitch_is_told_and_forgotten() {
    let mut bench = Bench::new(50);
    bench.lead_to(StateName::Collecting);
    bench.capture(3);
    bench.take_messages();
    let mut counts = bench.at.counts;
    counts[3] += 20_000;
    bench.event(Event::Counts(counts));
    bench.pass(SAMPLE_MS);
    bench.pass(600);
    let faults = faults(&mut bench);
    assert_eq!(faults, [(Reason::EncoderJumped, 4, true), (Reason::EncoderJumped, 4, false)]);
    assert_eq!(bench.state(), StateName::Collecting);
    bench.capture(1);
}

#[test]
fn a_lost_count_ends_the_run_and_keeps_its_poses() {
    let mut bench = Bench::new(51);
    bench.lead_to(StateName::Collecting);
    bench.capture(7);
    let mut counts = bench.at.counts;
    counts[1] -= 20_000;
    bench.set_counts(counts);
    bench.take_messages();
    bench.pass(300);
    assert_eq!(bench.state(), StateName::Failed);
    let outcome =
        bench.take_messages().into_iter().find_map(|m| if let Message::Outcome(o) = m { Some(o) } else { None });
    let outcome = outcome.unwrap();
    assert_eq!((outcome.reason, outcome.cable, outcome.poses), (Reason::EncoderJumped, 2, 7));
    let run_id = bench.procedure().run_id();
    assert_eq!(bench.request(Opcode::ReadPose as u8, run_id, 6).code, Reason::Fine);
}

#[test]
fn a_loose_cable_is_named() {
    let mut bench = Bench::new(52);
    bench.lead_to(StateName::Collecting);
    // the slack of cable 5 runs on its drum while the arm rests
    let mut counts = bench.at.counts;
    for _ in 0..100 {
        counts[4] += 12;
        bench.set_counts(counts);
        bench.pass(SAMPLE_MS);
    }
    let answer = bench.command(Opcode::Capture);
    assert_eq!((answer.code, answer.detail), (Reason::CableLoose, 5));
}

/// Pays out `counts` of the cables (from 0) while the arm rests, and captures.
fn capture_with_slack(seed: u64, cables: &[usize], counts: i32) -> glenoid::can::status::Answer {
    let mut bench = Bench::new(seed);
    bench.lead_to(StateName::Collecting);
    let home = bench.at.counts;
    for step in 1..=100 {
        let mut paid_out = home;
        for cable in cables {
            paid_out[*cable] += counts * step / 100;
        }
        bench.set_counts(paid_out);
        bench.pass(SAMPLE_MS);
    }
    bench.pass(600);
    bench.command(Opcode::Capture)
}

#[test]
fn lengths_that_cannot_be_are_refused() {
    // 300 mm of slack: with the 260 mm between its attachment points, cable 1 reaches nowhere
    let answer = capture_with_slack(53, &[0], 13_000);
    assert_eq!((answer.code, answer.detail), (Reason::LengthImpossible, 1));
    // 200 mm on both cables of an end-point: further from its neighbours than the platform is wide
    assert_eq!(capture_with_slack(53, &[0, 1], 8_700).code, Reason::PlatformDoesNotClose);
}

#[test]
fn the_clock_may_wrap_in_the_middle_of_a_run() {
    let mut bench = Bench::starting_at(54, u32::MAX - 8_000);
    bench.lead_to(StateName::Review);
    assert!(bench.now_ms < 60_000);
    assert_eq!(bench.state(), StateName::Review);
}
