//! A whole calibration with nothing but a button and a status LED.

use super::bench::Bench;
use glenoid::can::{Message, Opcode};
use glenoid::device::{BlinkPattern, Event};
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
    let blinks = blinks(*bench.led_patterns.last().unwrap());
    for _ in 0..blinks {
        bench.press(SHORT_MS);
    }
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

/// How often the LED blinks in review.
fn blinks(pattern: BlinkPattern) -> usize {
    // each blink is one dark beat
    assert!([BlinkPattern::Review2, BlinkPattern::Review3, BlinkPattern::Review4].contains(&pattern), "{pattern:?}");
    pattern.beats().count_zeros() as usize
}

/// Whoever has not looked at the LED does not accept: not by a long press, not by another number of short ones, not by
/// the right number too slowly.
#[test]
fn the_button_accepts_only_what_the_led_has_shown() {
    let mut bench = Bench::new(37);
    bench.lead_to(StateName::Review);
    bench.pass(1_500);
    let right = blinks(*bench.led_patterns.last().unwrap());
    for presses in 0..6 {
        let mut bench = bench.fork();
        (0..presses).for_each(|_| bench.press(SHORT_MS));
        bench.press(LONG_MS);
        let accepted = bench.procedure().live().is_some();
        assert_eq!(accepted, presses == right, "{presses} of {right}");
    }
    (0..right).for_each(|_| bench.press(SHORT_MS));
    bench.pass(3_000);
    bench.press(LONG_MS);
    assert!(bench.procedure().live().is_none());
}

/// A heartbeat looks whether the centre in use has changed in memory: an accept in the same tick is no such change. The bench
/// panics when the device asks for a restart.
#[test]
fn an_accept_by_button_and_a_heartbeat_may_fall_into_the_same_tick() {
    let mut bench = Bench::new(37);
    bench.lead_to(StateName::Review);
    bench.pass(1_500);
    let right = blinks(*bench.led_patterns.last().unwrap());
    for shift_ms in 0..100 {
        let mut bench = bench.fork();
        bench.pass(shift_ms);
        (0..right).for_each(|_| bench.press(SHORT_MS));
        bench.press(LONG_MS);
        assert!(bench.procedure().live().is_some(), "{shift_ms}");
        assert_eq!(bench.records.len(), 1, "{shift_ms}");
    }
}

/// A press belongs to the state in which it began.
#[test]
fn a_press_that_began_before_the_review_decides_nothing() {
    let mut bench = Bench::new(38);
    bench.lead_to(StateName::Verifying);
    bench.capture(3);
    bench.event(Event::Button { down: true });
    bench.pass(100);
    assert_eq!(bench.command(Opcode::Verify).code, Reason::Fine);
    bench.pass(1_900);
    assert_eq!(bench.state(), StateName::Review);
    bench.event(Event::Button { down: false });
    bench.pass(100);
    assert_eq!(bench.state(), StateName::Review);
    assert!(bench.procedure().live().is_none());
}

/// A contact that sticks does nothing in any state, however long it takes to be known as stuck.
#[test]
fn a_contact_that_sticks_does_nothing_in_any_state() {
    for state in StateName::ALL {
        let mut bench = Bench::new(39);
        bench.lead_to(state);
        // the solver may find a centre meanwhile
        bench.pass(400);
        let before = bench.state();
        bench.press(13_000);
        assert_eq!(bench.state(), before, "{state:?}");
        assert!(bench.procedure().live().is_none());
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
