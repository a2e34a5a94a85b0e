//! A joint centre that moves: two phases, what is shown, kept and in use of it, and the slip monitor over it.

use super::bench::{Bench, SAMPLE_MS};
use glenoid::can::set::{Received, Receiver};
use glenoid::can::telemetry::{TELEMETRY_ID, TELEMETRY_LEN};
use glenoid::can::{Message, Opcode, Telemetry};
use glenoid::procedure::{Guidance, Reason, StateName};
use glenoid::restart::Restart;
use host_tests::anatomy::Shoulder;
use nalgebra::{Rotation3, Vector3};

const START_TWO_PHASES: u16 = 2;
const BY_COMMAND: u16 = 1;
const VERY_LONG_MS: u32 = 4_500;

/// A device with a person in the machine, the base on the thorax.
fn bench_of(person: u64) -> Bench {
    let mut bench = Bench::new(40 + person);
    bench.wearer.wear(Shoulder::new(person, 0.0));
    bench
}

/// Moves from pose to pose, each held, until the state is another one.
fn pose_until_not(bench: &mut Bench, state: StateName, most: u32) {
    let mut poses = 0;
    while bench.state() == state {
        bench.next_pose();
        poses += 1;
        assert!(poses < most, "{:?}", bench.heartbeat());
    }
}

/// A bench in the review of a moving centre, after two phases that the device has led itself.
fn in_review(person: u64) -> Bench {
    let mut bench = bench_of(person);
    bench.wearer.hold_blade(true);
    bench.press(VERY_LONG_MS);
    bench.pass(200);
    let heartbeat = bench.heartbeat();
    assert!(heartbeat.flags.held_phase, "{heartbeat:?}");
    assert_eq!((heartbeat.state, heartbeat.guidance), (StateName::Collecting, Guidance::HoldBlade));
    let mut poses = 0;
    while bench.heartbeat().flags.held_phase {
        bench.next_pose();
        // the solver, and the next heartbeat
        bench.pass(1_000);
        poses += 1;
        assert!(poses < 40, "{:?}", bench.heartbeat());
    }
    let heartbeat = bench.heartbeat();
    assert_eq!((heartbeat.guidance, heartbeat.poses), (Guidance::ReleaseBlade, 0));
    bench.wearer.hold_blade(false);
    pose_until_not(&mut bench, StateName::Collecting, 60);
    bench.pass(3_000);
    assert_eq!(bench.state(), StateName::Verifying, "{:?}", bench.heartbeat());
    pose_until_not(&mut bench, StateName::Verifying, 20);
    bench.pass(500);
    assert_eq!(bench.state(), StateName::Review, "{:?}", bench.heartbeat());
    bench
}

/// The same with the new centre in use, the arm at home.
fn in_use(person: u64) -> Bench {
    let mut bench = in_review(person);
    assert_eq!(bench.accept().code, Reason::Fine);
    bench.decide(Opcode::Acknowledge);
    let home = bench.wearer.home();
    bench.silent = true;
    bench.move_to(home);
    bench.silent = false;
    bench.pass(1_000);
    bench.take_messages();
    bench
}

fn arm(ms: u32) -> Rotation3<f64> {
    let t = f64::from(ms) / 1000.0;
    Rotation3::new(Vector3::new(0.4 * (0.9 * t).sin(), 0.4 * (0.7 * t).sin(), 0.0))
        * Rotation3::new(Vector3::z() * (0.3 * (0.6 * t).sin()))
}

/// Moves the arm from one time of its exercise to another, ms, with the strap elsewhere, and returns the warnings.
fn exercise(bench: &mut Bench, ms: std::ops::Range<u32>, strap_mm: Vector3<f64>) -> Vec<Reason> {
    bench.take_messages();
    for step in ms.start / SAMPLE_MS..ms.end / SAMPLE_MS {
        let counts = bench.wearer.sample(&arm(step * SAMPLE_MS), strap_mm, None);
        bench.set_counts(counts);
        bench.pass(SAMPLE_MS);
    }
    let watch = |message: &Message| if let Message::Watch(report) = message { Some(report.cause) } else { None };
    bench.messages.iter().filter_map(watch).collect()
}

#[test]
fn two_phases_by_the_button_lead_to_a_centre_that_moves() {
    let bench = in_review(1);
    let candidate = bench.procedure().candidate().unwrap();
    let model = candidate.motion.expect("the joint moves").model();
    // the distance between the centres in two far poses, in truth and by the model; {P} lies as at home
    let platform = *model.frame.mean();
    let off = |turn: Vector3<f64>| {
        let arm = Rotation3::new(turn);
        let found = model.displacement_mm(&(arm.matrix().map(|x| x as f32) * platform)).map(f64::from);
        (found, bench.wearer.centre_at(&arm))
    };
    let ((found_a, true_a), (found_b, true_b)) = (off(Vector3::new(0.5, 0.0, 0.0)), off(Vector3::new(-0.5, 0.0, 0.0)));
    let (found, truth) = (found_a - found_b, true_a - true_b);
    assert!(truth.norm() > 8.0, "{truth}");
    assert!((found - truth).norm() < 0.25 * truth.norm(), "{found} {truth}");
}

/// The checksum covers the motion: the same centre with another motion has another name.
#[test]
fn an_accept_names_the_motion_too() {
    let mut bench = in_review(2);
    let parts = bench.messages.iter().filter(|message| matches!(message, Message::CandidateMotion(_))).count();
    assert!(parts >= 8, "{parts}");
    let naming = bench.naming().unwrap();
    let frames = bench.messages.iter().filter_map(|message| {
        let value =
            matches!(message, Message::CandidateCentre(_) | Message::CandidateRadius(_) | Message::CandidateZero(_));
        value.then(|| message.pack(glenoid::can::BaseId::DEFAULT).unwrap().data().try_into().unwrap())
    });
    let of_ball = frames.take(12).collect::<Vec<[u8; 8]>>();
    let without = glenoid::can::identity::checksum(naming.boot, naming.wearer, of_ball.into_iter());
    assert_ne!(naming.checksum, without);
    assert_eq!(bench.accept().code, Reason::Fine);
}

#[test]
fn the_motion_outlives_a_restart() {
    let mut bench = in_use(4);
    let before = bench.procedure().live().unwrap().clone();
    assert!(before.motion.is_some());
    let record = *bench.records.last().unwrap();
    bench.restart(Restart::default(), Ok(record));
    let after = bench.procedure().live().unwrap();
    assert_eq!((after.motion, &after.identified.parameters), (before.motion, &before.identified.parameters));
    bench.take_messages();
    bench.command(Opcode::Query);
    bench.pass(200);
    assert_eq!(bench.messages.iter().filter(|message| matches!(message, Message::LiveMotion(_))).count(), 8);
}

/// The centre that control gets follows the arm: its error is that of the pose's lengths and of the centre in the platform.
#[test]
fn telemetry_shows_where_the_centre_is_now() {
    let mut bench = in_use(1);
    let (mut squares, mut travel, mut sets, mut sigmas) = (0.0, 0.0, 0, 0.0);
    let home_mm = bench.wearer.centre_at(&Rotation3::identity());
    for _ in 0..12 {
        let pose = bench.wearer.next_pose();
        bench.move_to(pose);
        bench.take_messages();
        bench.pass(60);
        let mut receiver = Receiver::<TELEMETRY_LEN>::new(TELEMETRY_ID);
        let last = bench.messages.iter().filter_map(|message| match message {
            Message::Telemetry(piece) => match receiver.take(*piece) {
                Received::Set { data, .. } => Telemetry::unpack(&data),
                _ => None,
            },
            _ => None,
        });
        let (centre_mm, sigma_mm) = last.last().unwrap().centre.unwrap();
        let truth = pose.centre_mm + pose.slide_mm;
        squares += (Vector3::from(centre_mm).map(f64::from) - truth).norm_squared();
        travel += (truth - home_mm).norm_squared();
        sigmas += f64::from(sigma_mm).powi(2);
        sets += 1;
    }
    let [rms, travel, sigma] = [squares, travel, sigmas].map(|sum| (sum / f64::from(sets)).sqrt());
    assert!(travel > 5.0, "{travel}");
    assert!(rms < 1.4 && rms < 3.0 * sigma + 0.05, "off by {rms} mm, said {sigma} mm");
}

/// Motion that the joint's model predicts is no alarm; a strap that slips is one.
#[test]
fn the_slip_monitor_judges_by_the_joints_model() {
    for person in [1, 4] {
        let mut bench = in_use(person);
        assert_eq!(exercise(&mut bench, 0..60_000, Vector3::zeros()), [], "{person}: nothing slipped");
        let warnings = exercise(&mut bench, 60_000..70_000, Vector3::new(3.0, -3.0, 2.0));
        assert!(!warnings.is_empty(), "{person}: the strap slipped by 4.7 mm");
    }
}

/// A ball's monitor over the same shoulder would sound for everyone: the test above proves something.
#[test]
fn a_shoulder_is_no_ball_to_the_slip_monitor() {
    let mut bench = in_use(1);
    let mut record = *bench.records.last().unwrap();
    record.motion = None;
    bench.restart(Restart::default(), Ok(record));
    assert_ne!(exercise(&mut bench, 0..20_000, Vector3::zeros()), []);
}

#[test]
fn a_blade_that_nobody_holds_is_named() {
    let mut bench = bench_of(1);
    assert_eq!(bench.request(Opcode::Start as u8, 0, START_TWO_PHASES | BY_COMMAND).code, Reason::Fine);
    bench.capture(7);
    assert_eq!(bench.command(Opcode::Identify).code, Reason::TooFewPoses, "8 at least");
    bench.capture(13);
    assert_eq!(bench.command(Opcode::Identify).code, Reason::Fine);
    bench.pass(1_000);
    assert_eq!((bench.state(), bench.heartbeat().reason), (StateName::Failed, Reason::BladeNotHeld));
}

/// Between the phases the cuff is taken off and put on again, 8 mm elsewhere.
#[test]
fn phases_of_two_wearings_are_named() {
    let mut bench = bench_of(1);
    bench.wearer.hold_blade(true);
    assert_eq!(bench.request(Opcode::Start as u8, 0, START_TWO_PHASES | BY_COMMAND).code, Reason::Fine);
    bench.capture(20);
    assert_eq!(bench.command(Opcode::Identify).code, Reason::Fine);
    bench.pass(1_000);
    assert_eq!((bench.state(), bench.heartbeat().flags.held_phase), (StateName::Collecting, false));
    bench.wearer = bench_of(5).wearer;
    bench.wearer.wear(Shoulder::new(1, 0.0));
    bench.capture(40);
    assert_eq!(bench.command(Opcode::Identify).code, Reason::Fine);
    bench.pass(4_000);
    assert_eq!((bench.state(), bench.heartbeat().reason), (StateName::Failed, Reason::HeldOfAnotherWearing));
}

/// Without a first phase the device finds out by itself, asks for more poses, and then tries a centre that moves.
#[test]
fn one_phase_goes_on_until_the_motion_is_known() {
    let mut bench = bench_of(2);
    assert_eq!(bench.request(Opcode::Start as u8, 0, 0).code, Reason::Fine);
    let mut poses = 0;
    while matches!(bench.state(), StateName::Collecting | StateName::Identifying) {
        bench.next_pose();
        bench.pass(1_000);
        poses += 1;
        assert!(poses < 80, "{:?}", bench.heartbeat());
    }
    assert_eq!(bench.state(), StateName::Verifying, "{:?}", bench.heartbeat());
    pose_until_not(&mut bench, StateName::Verifying, 20);
    bench.pass(500);
    assert!(bench.procedure().candidate().unwrap().motion.is_some());
    assert!((30..60).contains(&poses), "{poses}");
}
