//! The rehearsal of an arm against three devices on one bus within this process.

use clap::Parser;
use glenoid::can::{BaseId, Message, Opcode, Request};
use host_tests::rehearse::arm::{ArmReport, Bus, InProcessBus, rehearse_arm};
use host_tests::rehearse::{Display, Options, Status};

fn rehearsed(arguments: &str) -> ArmReport {
    let options = Options::try_parse_from(format!("rehearse --arm {arguments}").split_whitespace()).unwrap();
    rehearse_arm(&mut InProcessBus::default(), &options, &Display::Silent)
}

/// The one reason why it failed.
fn failure(arguments: &str) -> String {
    let report = rehearsed(arguments);
    assert_eq!(report.status, Status::Failed, "{report}");
    let [reason] = &report.reasons[..] else { panic!("{report}") };
    reason.clone()
}

#[test]
fn three_boards_on_one_bus_find_the_hand() {
    let report = rehearsed("--poses 20 --seed 5");
    assert_eq!(report.status, Status::Right, "{report}");
    for ball in &report.balls {
        let found = ball.rehearsal.found.as_ref().unwrap();
        assert_eq!(found.host.difference_mm, 0.0);
        assert_eq!(found.centre_mm, found.centre_after_restart_mm);
    }
    let elbow = report.elbow.as_ref().unwrap();
    assert!(elbow.host_agrees && elbow.survives_restart, "{report}");
    assert_eq!(report.hand.len(), 3);
    for hand in &report.hand {
        // The elbow's axis and the mounts leave the hand to a few millimetres.
        assert!(hand.error_mm < 8.0, "{report}");
    }
    let text = report.to_string();
    assert!(text.contains("agree to the bit") && text.contains("the hand is where the arm says"), "{text}");
}

#[test]
fn machines_that_are_not_as_drawn_find_the_hand() {
    let report = rehearsed("--machine-tolerance --seed 1");
    assert_eq!(report.status, Status::Right, "{report}");
    assert!(report.host_agrees(), "{report}");
    // Three degrees of freedom; beyond 30 lies one hand in a million.
    assert!(report.hand.len() == 3 && report.hand.iter().all(|hand| hand.chi_square < 30.0), "{report}");
    assert!(report.to_string().contains("machines             off by these"), "{report}");
}

/// An elbow in a machine with tolerances and a vague drawing is refused now and then.
#[test]
fn an_elbow_that_two_axes_fit_is_named() {
    let reason = failure("--machine-tolerance --seed 4");
    assert!(reason.starts_with("the elbow: the board wants more poses: two different axes fit the poses"), "{reason}");
    assert!(reason.contains("What to do: capture more poses"), "{reason}");
}

#[test]
fn a_missing_board_is_named() {
    let reason = failure("--arm-fault missing");
    assert!(reason.starts_with("no board at 0x740, where the wrist's should be. What to do:"), "{reason}");
}

#[test]
fn two_boards_at_one_place_are_named() {
    let reason = failure("--arm-fault twice");
    let what = "more than one board at 0x740, where the wrist's should be: serial numbers 103 and 999, with";
    assert!(reason.starts_with(what), "{reason}");
    assert!(reason.contains("the shoulder's rig") && reason.contains("the wrist's rig"), "{reason}");
}

#[test]
fn modules_out_of_order_are_named() {
    let reason = failure("--arm-fault swapped");
    assert!(reason.starts_with("the board at 0x700, where the elbow's should be, has the wrist's rig."), "{reason}");
}

#[test]
fn an_elbow_that_never_bends_is_named() {
    let reason = failure("--arm-fault straight --poses 12");
    assert!(reason.starts_with("the elbow: it never bends: 1 of its angles are far enough apart;"), "{reason}");
    assert!(reason.contains("What to do: "), "{reason}");
}

/// Frames of others that the board at these identifiers has counted, and how many were heard meanwhile.
fn foreign(bus: &mut InProcessBus, base: BaseId, nonce: u16) -> (u32, u32) {
    let query = Request { opcode: Opcode::Query as u8, boot: 0, nonce, run_id: 0, argument: 0 };
    bus.send(&query.pack(base.command())).unwrap();
    let mut heard = 0;
    for _ in 0..1_000 {
        for frame in bus.pass(1).unwrap() {
            match Message::unpack(&frame, base) {
                Ok(Message::Counters(counters)) => return (counters.foreign, heard),
                Ok(_) => {}
                Err(_) => heard += 1,
            }
        }
    }
    panic!("no counters");
}

#[test]
fn what_a_board_sends_reaches_the_others() {
    let mut bus = InProcessBus::default();
    let options = Options::try_parse_from(["rehearse", "--arm", "--arm-fault", "straight"]).unwrap();
    rehearse_arm(&mut bus, &options, &Display::Silent);
    let elbow = BaseId::new(0x700).unwrap();
    let (before, _) = foreign(&mut bus, elbow, 60_001);
    let mut heard = 0;
    for _ in 0..2_000 {
        let others = bus.pass(1).unwrap();
        heard += others.iter().filter(|frame| !elbow.owns(frame.raw_id())).count() as u32;
    }
    let (after, on_the_way) = foreign(&mut bus, elbow, 60_002);
    // Two boards, each with twenty heartbeats and as many identities, ten sets of eight frames and two others.
    assert!(heard > 200, "{heard}");
    let counted = after - before;
    assert!(counted.abs_diff(heard + on_the_way) <= 16, "{counted} counted, {heard} and {on_the_way} heard");
}
