//! The watch over the centre in use, on the device: what it tells, when, and until when.

use super::bench::{Bench, SAMPLE_MS};
use glenoid::can::status::Fault;
use glenoid::can::watch::WatchReport;
use glenoid::can::{Message, Opcode, Standing};
use glenoid::device::{BlinkPattern, LogEntry};
use glenoid::kinematics::inverse;
use glenoid::procedure::{Reason, Settings, StateName};
use glenoid::restart::Restart;
use glenoid::rig::Rig;
use host_tests::wearer::WearerSettings;
use nalgebra::{Rotation3, Vector3};

/// What is wrong with the machine: the centre is elsewhere, a cable (from 0) reads too much, mm.
#[derive(Clone, Copy, Default)]
struct Wrong {
    strap_mm: Vector3<f64>,
    cable: Option<(usize, f64)>,
}

impl Wrong {
    fn strap(x: f64, y: f64, z: f64) -> Self {
        Self { strap_mm: Vector3::new(x, y, z), cable: None }
    }

    fn cable(cable: usize, by_mm: f64) -> Self {
        Self { cable: Some((cable, by_mm)), ..Self::default() }
    }
}

/// A bench after an accepted run.
fn accepted(zero_error_mm: f64) -> Bench {
    let wearer = WearerSettings { seed: 7, noise_mm: 0.1, zero_error_mm, ..WearerSettings::default() };
    let mut bench = Bench::with(Settings::default(), wearer);
    bench.request(Opcode::SetZeroPrior as u8, 0, (zero_error_mm * 1024.0) as u16);
    bench.request(Opcode::Start as u8, 0, 1);
    bench.capture(30);
    bench.command(Opcode::Identify);
    bench.pass(500);
    bench.capture(5);
    bench.command(Opcode::Verify);
    bench.pass(100);
    assert_eq!(bench.decide(Opcode::Accept).code, Reason::Fine);
    bench.decide(Opcode::Acknowledge);
    swing_home(&mut bench);
    bench.take_messages();
    bench
}

/// The arm on its way, 15 degrees a second; at home at time 0.
fn arm(ms: u32) -> Rotation3<f64> {
    let t = f64::from(ms) / 1000.0;
    Rotation3::new(Vector3::new(0.4 * (0.9 * t).sin(), 0.4 * (0.7 * t).sin(), 0.0))
        * Rotation3::new(Vector3::z() * (0.3 * (0.6 * t).sin()))
}

fn swing_home(bench: &mut Bench) {
    let home = bench.wearer.home();
    bench.glide_to(home.counts);
    bench.at = home;
}

/// The arm swings from home for a while in a machine with something wrong.
fn swing(bench: &mut Bench, ms: u32, wrong: Wrong) {
    let rig = Rig::<f64>::shoulder(150.0).unwrap();
    let centre = *bench.wearer.arm().centre_mm();
    let ends = *bench.wearer.arm().end_points_mm();
    for at in (0..ms).step_by(SAMPLE_MS as usize) {
        let mut lengths = inverse::cable_lengths(&rig, &(centre + wrong.strap_mm), &ends, &arm(at));
        if let Some((cable, by_mm)) = wrong.cable {
            lengths[cable] += by_mm;
        }
        let counts = bench.wearer.encoder().counts(lengths);
        bench.set_counts(counts);
        bench.pass(SAMPLE_MS);
    }
}

fn reports(messages: &[Message]) -> Vec<WatchReport> {
    messages.iter().filter_map(|m| if let Message::Watch(report) = m { Some(*report) } else { None }).collect()
}

fn faults(messages: &[Message]) -> Vec<Fault> {
    let fault = |m: &Message| match m {
        Message::Fault(fault) if fault.code.code() >= 128 => Some(*fault),
        _ => None,
    };
    messages.iter().filter_map(fault).collect()
}

#[test]
fn a_strap_that_slips_is_told_within_two_seconds_and_the_centre_stays() {
    for zero_error_mm in [0.0, 10.0] {
        let mut bench = accepted(zero_error_mm);
        let live = bench.procedure().live().cloned();
        swing(&mut bench, 10_000, Wrong::default());
        assert_eq!(reports(&bench.take_messages()), []);
        swing_home(&mut bench);
        swing(&mut bench, 2_000, Wrong::strap(0.0, 2.4, -1.8));
        let messages = bench.take_messages();
        let [report, ..] = reports(&messages)[..] else { panic!("nothing") };
        assert_eq!((report.run_id, report.cause, report.cable), (1, Reason::StrapSlipped, 0));
        let moved = Vector3::from(report.moved_mm).map(f64::from);
        assert!((moved - Vector3::new(0.0, 2.4, -1.8)).norm() < 0.4, "{moved}");
        let [fault, ..] = faults(&messages)[..] else { panic!("no fault") };
        assert_eq!((fault.code, fault.active, fault.count), (Reason::StrapSlipped, true, 1));
        assert_eq!(bench.heartbeat().reason, Reason::StrapSlipped);
        assert_eq!(bench.led_patterns.last(), Some(&BlinkPattern::Slipped));
        assert!(bench.logs.iter().any(|entry| matches!(entry, LogEntry::Slipped(r) if r.cause == report.cause)));
        assert_eq!(bench.procedure().live().cloned(), live, "never a silent change of the centre");
    }
}

#[test]
fn a_cable_that_slips_is_named() {
    for cable in 0..6 {
        let mut bench = accepted(0.0);
        swing(&mut bench, 2_500, Wrong::cable(cable, -2.0));
        let [report, ..] = reports(&bench.messages)[..] else { panic!("cable {}: nothing", cable + 1) };
        assert_eq!((report.cause, usize::from(report.cable)), (Reason::CableSlipped, cable + 1));
        assert!((report.moved_mm[0] + 2.0).abs() < 0.3, "{report:?}");
    }
}

#[test]
fn a_warning_is_repeated_until_it_is_acknowledged_and_comes_back_while_the_cause_lasts() {
    let mut bench = accepted(0.0);
    let slipped = Wrong::strap(3.0, 0.0, 0.0);
    swing(&mut bench, 2_000, slipped);
    bench.take_messages();
    bench.pass(5_000);
    assert_eq!(reports(&bench.take_messages()).len(), 5, "once a second");
    assert_eq!(bench.decide(Opcode::Acknowledge).code, Reason::Fine);
    bench.pass(5_000);
    let messages = bench.take_messages();
    assert_eq!(reports(&messages), []);
    assert_eq!(faults(&messages).iter().map(|fault| fault.active).collect::<Vec<_>>(), [false]);
    // the warning has been seen; the centre is not to be used all the same, until somebody decides
    assert_eq!(bench.heartbeat().standing, Standing::NotToBeUsed);
    assert_eq!(bench.led_patterns.last(), Some(&BlinkPattern::Slipped));
    swing_home(&mut bench);
    swing(&mut bench, 3_000, slipped);
    assert!(!reports(&bench.take_messages()).is_empty(), "it has still slipped");
    // a short press is as good as the command
    bench.press(100);
    bench.pass(1_500);
    bench.take_messages();
    bench.pass(3_000);
    assert_eq!(reports(&bench.take_messages()), []);
    assert_eq!(bench.heartbeat().standing, Standing::NotToBeUsed);
}

#[test]
fn nothing_is_watched_without_a_centre_and_while_calibrating() {
    let slipped = Wrong::strap(0.0, 5.0, 0.0);
    let mut bench = Bench::new(7);
    swing(&mut bench, 5_000, slipped);
    assert_eq!(reports(&bench.messages), []);

    let mut bench = accepted(0.0);
    bench.pass(600);
    assert_eq!(bench.request(Opcode::Start as u8, 0, 1).code, Reason::Fine);
    swing(&mut bench, 5_000, slipped);
    assert_eq!(reports(&bench.messages), []);
    // The old centre stays in use after the run, and the strap has slipped.
    bench.command(Opcode::Abort);
    swing_home(&mut bench);
    swing(&mut bench, 3_000, slipped);
    assert!(!reports(&bench.messages).is_empty());
}

#[test]
fn a_centre_from_the_record_is_watched_with_its_zeros() {
    let mut bench = accepted(10.0);
    let record = bench.records[0];
    bench.restart(Restart::default(), Ok(record));
    swing(&mut bench, 20_000, Wrong::default());
    assert_eq!(reports(&bench.messages), []);
    swing_home(&mut bench);
    swing(&mut bench, 2_500, Wrong::cable(3, 2.0));
    let [report, ..] = reports(&bench.messages)[..] else { panic!("nothing") };
    assert_eq!((report.cause, report.cable), (Reason::CableSlipped, 4));
}

#[test]
fn a_new_centre_ends_the_warning() {
    let mut bench = accepted(0.0);
    swing(&mut bench, 2_000, Wrong::strap(3.0, 0.0, 0.0));
    assert_eq!(bench.heartbeat().reason, Reason::StrapSlipped);
    swing_home(&mut bench);
    bench.pass(600);
    bench.lead_to(StateName::Review);
    bench.decide(Opcode::Accept);
    bench.pass(200);
    assert_eq!(bench.heartbeat().reason, Reason::Accepted);
    assert_eq!(bench.led_patterns.last(), Some(&BlinkPattern::InUse));
}
