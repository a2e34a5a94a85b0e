//! Encoder zeros on the device: how well they are known is set over CAN, what they are comes with the centre.

use super::bench::Bench;
use glenoid::can::result::ZeroError;
use glenoid::can::{Message, Opcode};
use glenoid::procedure::{PoseSet, Reason, Settings, StateName};
use glenoid::record::RecordStore;
use glenoid::restart::Restart;
use host_tests::flash::{MockFlash, TornWord};
use host_tests::wearer::WearerSettings;

const SET: u8 = Opcode::SetZeroPrior as u8;
/// Ten millimetres in steps of 2^-10 mm.
const TEN_MM: u16 = 10 << 10;

/// A wearer in a machine that nobody homed: every encoder is off by up to 10 mm.
fn unhomed(seed: u64) -> Bench {
    let wearer = WearerSettings { seed, noise_mm: 0.1, zero_error_mm: 10.0, ..WearerSettings::default() };
    Bench::with(Settings::default(), wearer)
}

/// A run by commands over thirty poses; where it stands in the end.
fn run(bench: &mut Bench) -> StateName {
    assert_eq!(bench.request(Opcode::Start as u8, 0, 1).code, Reason::Fine);
    bench.capture(30);
    assert_eq!(bench.command(Opcode::Identify).code, Reason::Fine);
    bench.pass_while(StateName::Identifying);
    if bench.state() == StateName::Verifying {
        bench.capture(5);
        assert_eq!(bench.command(Opcode::Verify).code, Reason::Fine);
        bench.pass(1_000);
    }
    bench.state()
}

fn zeros(messages: &[Message], live: bool) -> Vec<ZeroError> {
    let zero = |message: &Message| match message {
        Message::LiveZero(zero) if live => Some(*zero),
        Message::CandidateZero(zero) if !live => Some(*zero),
        _ => None,
    };
    messages.iter().filter_map(zero).collect()
}

/// Each zero within five of its standard deviations of the truth: a cable that is longer than the firmware believes
/// reads too little.
fn assert_right(bench: &Bench, zeros: &[ZeroError]) {
    assert_eq!(zeros.iter().map(|zero| zero.cable).collect::<Vec<_>>(), [1, 2, 3, 4, 5, 6]);
    for (zero, truth) in zeros.iter().zip(bench.wearer.encoder().zero_errors_mm()) {
        let error = f64::from(zero.value_mm) + truth;
        assert!(error.abs() < 5.0 * f64::from(zero.sigma_mm), "{zero:?} {truth}");
        assert!(zero.sigma_mm > 0.0 && zero.sigma_mm < 1.0, "{zero:?}");
    }
}

#[test]
fn unknown_zeros_are_found_told_and_kept_across_a_restart() {
    let mut bench = unhomed(3);
    assert_eq!(bench.request(SET, 0, TEN_MM).code, Reason::Fine);
    assert_eq!(run(&mut bench), StateName::Review);
    bench.pass(300);
    let candidate = zeros(&bench.take_messages(), false);
    assert_right(&bench, &candidate[..6]);
    assert_eq!(bench.decide(Opcode::Accept).code, Reason::Fine);
    bench.pass(300);
    let live = zeros(&bench.take_messages(), true);
    assert_eq!(live[..6], candidate[..6]);

    let identified = &bench.procedure().live().unwrap().identified;
    let (sigma, truth) = (identified.sigma_mm(), bench.wearer.truth().centre_mm);
    for k in 0..3 {
        let error = (f64::from(identified.parameters.centre_mm[k]) - truth[k]).abs();
        assert!(error < 5.0 * f64::from(sigma[k]) + 0.01, "axis {k}: {error}");
    }

    let mut flash = RecordStore::new(MockFlash::new(2, TornWord::Zeros, 1), 0);
    flash.store(&bench.records[0]).unwrap();
    let loaded = flash.load(bench.records[0].rig);
    bench.restart(Restart::default(), loaded);
    assert_eq!(zeros(&bench.take_messages(), true), live[..6], "told without being asked for");
}

/// Without being told of the zeros the device takes them for known; what it then finds is no ball, or wrong by more
/// than the second set lets pass.
#[test]
fn the_same_machine_with_zeros_taken_as_known_is_refused() {
    for seed in 3..30 {
        assert_ne!(run(&mut unhomed(seed)), StateName::Review, "{seed}");
    }
}

#[test]
fn the_prior_holds_until_power_down_and_is_not_changed_during_a_run() {
    let mut bench = unhomed(4);
    bench.request(SET, 0, TEN_MM);
    assert_eq!(bench.request(SET, 1, 0).code, Reason::BadArgument, "it belongs to no run");
    bench.lead_to(StateName::Collecting);
    assert_eq!(bench.request(SET, 0, 0).code, Reason::AlreadyRunning);
    bench.command(Opcode::Abort);
    assert_eq!(run(&mut bench), StateName::Review, "still unknown zeros");
    bench.decide(Opcode::Accept);
    let record = bench.records[0];
    bench.restart(Restart::default(), Ok(record));
    let is_ball = run(&mut bench) == StateName::Review && bench.procedure().motion().is_none();
    assert!(!is_ball, "known zeros again");
}

/// A run begins from raw lengths, so that an error in the zeros in use cannot get into the next centre: the same arm
/// gives the same zeros again, not the difference to those in use.
#[test]
fn a_new_calibration_begins_from_raw_lengths() {
    let mut bench = unhomed(5);
    bench.request(SET, 0, TEN_MM);
    for _ in 0..2 {
        assert_eq!(run(&mut bench), StateName::Review);
        let lengths = *bench.procedure().poses(PoseSet::HeldOut).last().unwrap().lengths().as_mm();
        let counts = bench.at.counts;
        let drum = *bench.procedure().rig().drum();
        for k in 0..6 {
            let raw_mm = drum.home_length_mm[k] + counts[k] as f32 * drum.mm_per_count();
            assert!((lengths[k] - raw_mm).abs() < 0.2, "cable {}", k + 1);
        }
        assert_eq!(bench.decide(Opcode::Accept).code, Reason::Fine);
        bench.take_messages();
        bench.pass(300);
        let live = zeros(&bench.take_messages(), true);
        assert_right(&bench, &live[..6]);
    }
}

#[test]
fn known_zeros_are_sent_as_zero() {
    let mut bench = Bench::new(7);
    bench.lead_to(StateName::Review);
    bench.decide(Opcode::Accept);
    bench.command(Opcode::Query);
    bench.pass(500);
    for live in [false, true] {
        let sent = zeros(&bench.messages, live);
        assert!(sent.len() >= 6 && sent.iter().all(|zero| (zero.value_mm, zero.sigma_mm) == (0.0, 0.0)), "{sent:?}");
    }
}

/// By itself the device collects more poses when it must find the zeros too, and ends right.
#[test]
fn a_run_by_itself_collects_enough_for_the_zeros() {
    let mut bench = unhomed(6);
    bench.request(SET, 0, TEN_MM);
    assert_eq!(bench.command(Opcode::Start).code, Reason::Fine);
    let mut holds = 0;
    while bench.state() != StateName::Review {
        bench.next_pose();
        holds += 1;
        assert!(holds < 150, "{:?}", bench.heartbeat());
    }
    let candidate = bench.procedure().candidate().unwrap();
    assert!(candidate.identified.poses >= u32::from(Settings::default().enough_poses_with_zeros));
}

/// Small motions do not tell the zeros: named as such, with the cable and how badly its zero is known.
#[test]
fn zeros_that_the_poses_do_not_determine_are_refused_by_name() {
    let wearer = WearerSettings {
        seed: 2,
        noise_mm: 0.1,
        zero_error_mm: 10.0,
        tilt_rad: 0.35,
        torsion_rad: 0.2,
        ..WearerSettings::default()
    };
    let mut bench = Bench::with(Settings { nearest_pose_rad: 0.03, ..Settings::default() }, wearer);
    bench.request(SET, 0, TEN_MM);
    bench.request(Opcode::Start as u8, 0, 1);
    bench.capture(12);
    bench.command(Opcode::Identify);
    bench.pass(500);
    assert_eq!(bench.state(), StateName::Collecting, "more poses may cure it");
    let refusal = bench.procedure().refusal().unwrap();
    assert_eq!(refusal.reason, Reason::ZeroNotDetermined);
    assert!((1..=6).contains(&refusal.cable) && refusal.size_mm.is_some_and(|sigma| sigma > 0.5), "{refusal:?}");
}
