//! The watch over a hinge in use, on the board.

use super::elbow_board::Bench;
use glenoid::can::{Message, Opcode, Standing};
use glenoid::procedure::Reason;
use nalgebra::Vector3;

/// A board with an accepted hinge.
fn in_use() -> Bench {
    let mut bench = Bench::new();
    bench.lead_to_review();
    bench.hold(300);
    assert_eq!(bench.accept(), Reason::Fine);
    bench
}

fn exercise(bench: &mut Bench) {
    for degrees in [100.0, 10.0, 90.0, 20.0] {
        bench.bend_to(degrees);
    }
}

fn watch(bench: &Bench) -> Option<glenoid::can::watch::WatchReport> {
    bench.last(|m| if let Message::Watch(report) = m { Some(*report) } else { None })
}

#[test]
fn motion_confirms_a_hinge_from_the_record() {
    let mut bench = in_use();
    let record = bench.records[0];
    bench.start(Ok(record));
    assert_eq!(bench.device.live_set().standing, Standing::Unconfirmed);
    exercise(&mut bench);
    bench.hold(300);
    assert_eq!(bench.device.live_set().standing, Standing::Confirmed);
    assert!(watch(&bench).is_none());
}

#[test]
fn a_base_that_slips_is_named_with_its_movement_until_somebody_has_seen_it() {
    let mut bench = in_use();
    let run_id = bench.device.live_set().run_id;
    exercise(&mut bench);
    assert!(watch(&bench).is_none());
    let moved = Vector3::new(1.5, 2.0, -2.5);
    bench.elbow = bench.elbow.clone().with_axis_moved(&moved);
    exercise(&mut bench);
    bench.hold(1_500);
    let report = watch(&bench).expect("a warning");
    assert_eq!((report.run_id, report.cause, report.cable), (run_id, Reason::StrapSlipped, 0));
    let off = Vector3::from(report.moved_mm).map(f64::from) - moved;
    assert!(off.norm() < 1.0, "{report:?}");
    assert_eq!(bench.device.live_set().standing, Standing::NotToBeUsed);
    // Seen, it watches on: what slipped is still where it slipped to.
    assert_eq!(bench.ask(Opcode::Acknowledge, run_id, 0), Reason::Fine);
    bench.messages.clear();
    exercise(&mut bench);
    bench.hold(1_500);
    assert_eq!(watch(&bench).map(|report| report.cause), Some(Reason::StrapSlipped));
}

#[test]
fn a_cuff_that_slips_is_named() {
    let mut bench = in_use();
    bench.elbow = bench.elbow.clone().with_cuff_moved(&Vector3::new(0.5, -2.0, 2.0));
    exercise(&mut bench);
    bench.hold(1_500);
    assert_eq!(watch(&bench).map(|report| report.cause), Some(Reason::CuffSlipped));
}
