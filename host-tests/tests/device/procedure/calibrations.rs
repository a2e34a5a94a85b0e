//! Whole calibrations by commands over CAN.

use super::bench::Bench;
use glenoid::can::result::Parameter;
use glenoid::can::{Message, Opcode};
use glenoid::procedure::{PoseSet, Reason, Settings, StateName};
use host_tests::wearer::Mishap;

/// The centre and the radii that are in use, as reported.
fn live(messages: &[Message]) -> [Parameter; 6] {
    let mut live = [None; 6];
    for message in messages {
        match message {
            Message::LiveCentre(p) => live[usize::from(p.index)] = Some(*p),
            Message::LiveRadius(p) => live[3 + usize::from(p.index)] = Some(*p),
            _ => {}
        }
    }
    live.map(|parameter| parameter.expect("all six are reported"))
}

#[test]
fn a_run_by_commands_finds_the_centre() {
    let mut bench = Bench::new(7);
    let start = bench.request(Opcode::Start as u8, 0, 1);
    assert_eq!((start.code, start.run_id), (Reason::Fine, 1));
    bench.capture(20);
    assert_eq!(bench.command(Opcode::Identify).code, Reason::Fine);
    bench.pass(500);
    assert_eq!(bench.state(), StateName::Verifying);
    bench.capture(5);
    assert_eq!(bench.command(Opcode::Verify).code, Reason::Fine);
    bench.pass(100);
    assert_eq!(bench.state(), StateName::Review);
    assert_eq!(bench.heartbeat().progress_percent, 100);
    bench.messages.clear();
    assert_eq!(bench.decide(Opcode::Accept).code, Reason::Fine);
    bench.pass(100);

    let truth = bench.wearer.truth().to_array();
    for (value, truth) in live(&bench.messages).iter().zip(truth) {
        assert_eq!(value.run_id, 1);
        // four standard deviations, and the report's own resolution
        let error = (f64::from(value.value_mm) - truth).abs();
        assert!(error < 4.0 * f64::from(value.sigma_mm) + 1e-4, "{value:?} {truth}");
        assert!(value.sigma_mm < 0.2, "{value:?}");
    }
}

#[test]
fn a_run_by_itself_captures_ends_and_verifies() {
    let mut bench = Bench::new(8);
    assert_eq!(bench.command(Opcode::Start).code, Reason::Fine);
    let mut holds = 0;
    while bench.state() != StateName::Review {
        bench.next_pose();
        holds += 1;
        assert!(holds < 80, "{:?}", bench.heartbeat());
    }
    let candidate = bench.procedure().candidate().unwrap();
    let settings = Settings::default();
    assert!(candidate.identified.poses >= u32::from(settings.enough_poses));
    assert_eq!(candidate.verification.poses, settings.verification_poses);
    let (sigma_mm, _) = candidate.identified.worst_centre_sigma_mm();
    // the forecast at the nominal centre holds within a fifth for a centre up to 20 mm off
    assert!(sigma_mm < 1.2 * settings.target_sigma_mm, "{sigma_mm}");
}

#[test]
fn the_second_set_never_identifies() {
    let mut bench = Bench::new(9);
    bench.lead_to(StateName::Verifying);
    let before = bench.procedure().identified().unwrap().parameters;
    let first = bench.procedure().poses(PoseSet::Identification).len();
    bench.capture(4);
    bench.command(Opcode::Verify);
    bench.pass(20);
    assert_eq!(bench.procedure().candidate().unwrap().identified.parameters, before);
    assert_eq!(bench.procedure().poses(PoseSet::Identification).len(), first);
    assert_eq!(bench.procedure().poses(PoseSet::HeldOut).len(), 4);
}

/// A cable that slips between the two sets leaves the first set's own deviation untouched; only a second set tells.
#[test]
fn a_slip_between_the_sets_is_contradicted() {
    let mut bench = Bench::new(10);
    bench.lead_to(StateName::Verifying);
    bench.wearer.suffer(Mishap::Slip { pose: 0, cable: 2, by_mm: 6.0 });
    bench.capture(5);
    bench.take_messages();
    bench.command(Opcode::Verify);
    bench.pass(100);
    assert_eq!(bench.state(), StateName::Failed);
    let outcome =
        bench.take_messages().into_iter().find_map(|m| if let Message::Outcome(o) = m { Some(o) } else { None });
    let outcome = outcome.unwrap();
    assert_eq!(outcome.reason, Reason::VerificationFailed);
    assert!(outcome.size_mm.unwrap() > Settings::default().verification_deviation_mm, "{outcome:?}");
    assert!(!outcome.live);
}

#[test]
fn the_old_centre_stays_in_use_until_the_new_one_is_accepted() {
    let mut bench = Bench::new(11);
    bench.lead_to(StateName::Review);
    bench.decide(Opcode::Accept);
    let old = bench.procedure().live().unwrap().clone();
    for (opcode, ending) in [(Opcode::Reject, Reason::Rejected), (Opcode::Abort, Reason::Aborted)] {
        bench.lead_to(StateName::Review);
        bench.take_messages();
        bench.pass(1_100);
        let messages = bench.take_messages();
        // both stand side by side in the report
        let old_x = messages.iter().find_map(|m| if let Message::LiveCentre(p) = m { Some(p.run_id) } else { None });
        let new_x =
            messages.iter().find_map(|m| if let Message::CandidateCentre(p) = m { Some(p.run_id) } else { None });
        assert_eq!((old_x, new_x), (Some(old.run_id), Some(bench.procedure().run_id())));
        assert_eq!(bench.decide(opcode).code, Reason::Fine);
        assert_eq!(bench.procedure().live(), Some(&old));
        assert_eq!(bench.procedure().ending().unwrap().detail.reason, ending);
    }
    bench.lead_to(StateName::Review);
    bench.decide(Opcode::Accept);
    assert_eq!(bench.procedure().live().unwrap().run_id, old.run_id + 3);
}

#[test]
fn the_final_report_is_complete_and_repeated_until_acknowledged() {
    let mut bench = Bench::new(12);
    bench.lead_to(StateName::Review);
    bench.decide(Opcode::Accept);
    bench.take_messages();
    for second in 0..3 {
        bench.pass(1_000);
        let messages = bench.take_messages();
        live(&messages);
        let outcomes =
            messages.iter().filter(|m| matches!(m, Message::Outcome(o) if o.reason == Reason::Accepted && o.live));
        assert_eq!(outcomes.count(), 1, "second {second}");
        assert!(messages.iter().any(|m| matches!(m, Message::Quality(_))));
        assert!(messages.iter().any(|m| matches!(m, Message::Verification(_))));
        assert!(messages.iter().any(|m| matches!(m, Message::WeakDirection(_))));
    }
    assert!(bench.heartbeat().flags.unacknowledged);
    assert_eq!(bench.decide(Opcode::Acknowledge).code, Reason::Fine);
    bench.pass(100);
    bench.take_messages();
    bench.pass(3_000);
    assert!(!bench.take_messages().iter().any(|m| matches!(m, Message::Outcome(_))));
    assert!(!bench.heartbeat().flags.unacknowledged);
}

#[test]
fn progress_never_shows_100_before_success() {
    let mut bench = Bench::new(13);
    bench.command(Opcode::Start);
    let mut percents = Vec::new();
    while bench.state() != StateName::Review {
        bench.next_pose();
        percents.extend(bench.take_messages().iter().filter_map(|m| match m {
            Message::Heartbeat(h) => Some((h.state, h.progress_percent)),
            _ => None,
        }));
    }
    for (state, percent) in &percents {
        assert_eq!(*percent == 100, *state == StateName::Review, "{state:?} {percent}");
    }
    // it rises in a sound run
    assert!(percents.is_sorted_by_key(|(_, percent)| *percent), "{percents:?}");
}

#[test]
fn raw_poses_come_through_to_the_bit() {
    let mut bench = Bench::new(14);
    bench.lead_to(StateName::Review);
    let run_id = bench.procedure().run_id();
    for (set, offset) in [(PoseSet::Identification, 0), (PoseSet::HeldOut, 256)] {
        for (index, pose) in bench.procedure().poses(set).to_vec().iter().enumerate() {
            bench.take_messages();
            let answer = bench.request(Opcode::ReadPose as u8, run_id, offset + index as u16);
            assert_eq!(answer.code, Reason::Fine);
            bench.pass(30);
            let mut lengths = [0.0; 6];
            for message in bench.take_messages() {
                if let Message::RawLength(raw) = message {
                    assert_eq!((raw.run_id, raw.set, usize::from(raw.index)), (run_id, set, index));
                    lengths[usize::from(raw.cable) - 1] = raw.length_mm;
                }
            }
            assert_eq!(&lengths, pose.lengths().as_mm());
        }
    }
    assert_eq!(bench.request(Opcode::ReadPose as u8, run_id, 12).code, Reason::NoSuchPose);
}

#[test]
fn a_client_that_comes_back_is_told_where_the_run_stands() {
    let mut bench = Bench::new(15);
    bench.lead_to(StateName::Verifying);
    bench.pass(5_000);
    bench.take_messages();
    // a new client that knows nothing
    let answer = bench.command(Opcode::Query);
    assert_eq!((answer.code, answer.run_id, answer.detail), (Reason::Fine, 1, u16::from(StateName::Verifying.code())));
    bench.pass(100);
    let messages = bench.take_messages();
    assert!(
        messages.iter().any(|m| matches!(m, Message::Heartbeat(h) if h.state == StateName::Verifying && h.run_id == 1))
    );
    let candidates = messages.iter().filter(|m| matches!(m, Message::CandidateCentre(_) | Message::CandidateRadius(_)));
    assert_eq!(candidates.count(), 6);
    assert!(messages.iter().any(|m| matches!(m, Message::Versions(v) if v.protocol == 2 && v.capacity == 128)));
    assert!(messages.iter().any(|m| matches!(m, Message::Counters(_))));
}

#[test]
fn each_run_has_its_own_id_and_none_is_confused() {
    let mut bench = Bench::new(16);
    for run in 1..=100 {
        bench.take_messages();
        bench.lead_to(StateName::Review);
        assert_eq!(bench.decide(Opcode::Accept).run_id, run);
        bench.pass(50);
        for message in bench.take_messages() {
            match message {
                Message::CandidateCentre(p) | Message::CandidateRadius(p) => assert_eq!(p.run_id, run),
                Message::Pose(p) => assert_eq!(p.run_id, run),
                // until the run starts, the end of the last one is still reported
                Message::Outcome(o) => assert!(o.run_id == run || o.run_id == run - 1),
                _ => {}
            }
        }
        assert_eq!(bench.procedure().live().unwrap().run_id, run);
    }
}

#[test]
fn guidance_leads_out_of_a_degenerate_set() {
    let mut bench = Bench::turning_only(17);
    bench.request(Opcode::Start as u8, 0, 1);
    bench.capture(8);
    assert_eq!(bench.heartbeat().guidance, glenoid::procedure::Guidance::TiltMore);
    bench.command(Opcode::Identify);
    bench.take_messages();
    bench.pass(200);
    // more poses can cure it: the run goes on, and says which axis
    assert_eq!((bench.state(), bench.heartbeat().reason), (StateName::Collecting, Reason::OneAxis));
    let axis =
        bench.take_messages().into_iter().find_map(|m| if let Message::Axis(a) = m { Some(a.axis) } else { None });
    assert!(axis.unwrap()[2].abs() > 0.99, "{axis:?}");
    assert_eq!(bench.procedure().poses(PoseSet::Identification).len(), 8);
}
