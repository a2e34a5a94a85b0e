//! A whole calibration with nothing but a button and a status LED.

use super::bench::Bench;
use glenoid::can::Message;
use glenoid::device::BlinkPattern;
use glenoid::procedure::{Reason, StateName};

const SHORT_MS: u32 = 200;
const LONG_MS: u32 = 2_000;
const VERY_LONG_MS: u32 = 4_500;

#[test]
fn a_run_by_button_and_led() {
    let mut bench = Bench::new(31);
    assert_eq!(bench.led_patterns.last(), Some(&BlinkPattern::Ready));
    bench.press(LONG_MS);
    assert_eq!(bench.state(), StateName::Collecting);
    let mut holds = 0;
    while bench.state() != StateName::Review {
        bench.next_pose();
        holds += 1;
        assert!(holds < 80);
    }
    bench.pass(1_500);
    assert_eq!(bench.led_patterns.last(), Some(&BlinkPattern::Review));
    bench.press(LONG_MS);
    bench.pass(1_500);
    assert_eq!((bench.state(), bench.led_patterns.last()), (StateName::Idle, Some(&BlinkPattern::InUse)));
    assert!(bench.procedure().live().is_some());
    let seen = |pattern| bench.led_patterns.contains(&pattern);
    use BlinkPattern::*;
    for pattern in [Collecting, Captured, Working, Verifying, LongPress] {
        assert!(seen(pattern), "{pattern:?} in {:?}", bench.led_patterns);
    }
}

#[test]
fn a_short_press_captures_and_a_long_one_ends_the_set() {
    let mut bench = Bench::new(32);
    bench.lead_to(StateName::Collecting);
    for _ in 0..6 {
        bench.next_pose();
        bench.press(SHORT_MS);
    }
    assert!(bench.heartbeat().poses >= 5);
    bench.press(LONG_MS);
    bench.pass(300);
    assert_eq!(bench.state(), StateName::Verifying);
    bench.next_pose();
    bench.press(SHORT_MS);
    bench.press(LONG_MS);
    assert_eq!(bench.state(), StateName::Review);
}

#[test]
fn a_very_long_press_aborts_every_state() {
    for state in &StateName::ALL[1..] {
        let mut bench = Bench::new(33);
        bench.lead_to(*state);
        bench.press(VERY_LONG_MS);
        // the solver may have finished while the button was held; the abort ends that as well
        assert_eq!(bench.state(), StateName::Idle, "{state:?}");
        assert_eq!(bench.procedure().ending().unwrap().detail.reason, Reason::Aborted);
        assert!(bench.procedure().live().is_none());
    }
}

#[test]
fn a_touch_does_not_start_a_run() {
    let mut bench = Bench::new(34);
    bench.press(SHORT_MS);
    bench.press(1_000);
    assert_eq!(bench.state(), StateName::Idle);
}

#[test]
fn a_run_cannot_be_started_while_the_arm_moves() {
    let mut bench = Bench::new(35);
    let pose = bench.wearer.next_pose();
    bench.press_while_moving(pose, LONG_MS);
    // until the next heartbeat
    bench.pass(100);
    assert_eq!(bench.state(), StateName::Idle);
    assert!(bench.led_patterns.contains(&BlinkPattern::Refused));
    assert!(bench.messages.iter().any(|m| matches!(m, Message::Heartbeat(h) if h.reason == Reason::ArmMoving)));
}

#[test]
fn a_stuck_button_is_a_fault_and_does_nothing_else() {
    let mut bench = Bench::new(36);
    bench.press(20_000);
    assert_eq!(bench.state(), StateName::Idle);
    let faults: Vec<_> =
        bench.messages.iter().filter_map(|m| if let Message::Fault(f) = m { Some(*f) } else { None }).collect();
    assert!(faults.iter().all(|f| f.code == Reason::ButtonStuck), "{faults:?}");
    assert!(faults.first().unwrap().active && !faults.last().unwrap().active);
    // told about once a second, not all the time
    assert!((7..=10).contains(&faults.len()), "{}", faults.len());
}
