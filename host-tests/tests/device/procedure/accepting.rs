//! Ways in which a centre that nobody chose might come into use, each closed; and whose centre it is, over restarts.

use super::bench::Bench;
use glenoid::can::identity::Naming;
use glenoid::can::status::Fault;
use glenoid::can::{BaseId, Message, Opcode, Request, Standing};
use glenoid::device::fingerprint;
use glenoid::procedure::{Reason, StateName};
use glenoid::record::Record;
use glenoid::restart::Restart;
use glenoid::rig::{Parameters, Rig};
use host_tests::power_cut;

/// The checksum by which a value is named, formed bit by bit from the frames as anybody on the bus receives them.
fn checksum_of(bench: &Bench, boot: u16, wearer: u16) -> u16 {
    let frames = bench
        .messages
        .iter()
        .filter(|m| matches!(m, Message::CandidateCentre(_) | Message::CandidateRadius(_) | Message::CandidateZero(_)));
    let frames: Vec<_> = frames.map(|m| m.pack(BaseId::DEFAULT).unwrap()).collect();
    let last = &frames[frames.len() - 12..];
    let bytes = boot.to_le_bytes().into_iter().chain(wearer.to_le_bytes());
    bytes.chain(last.iter().flat_map(|frame| frame.data().to_vec())).fold(0xFFFF, |sum: u16, byte| {
        (0..8).fold(sum ^ u16::from(byte) << 8, |sum, _| if sum & 0x8000 != 0 { sum << 1 ^ 0x1021 } else { sum << 1 })
    })
}

fn accept(bench: &mut Bench, naming: &Naming) -> Reason {
    bench.raw(Request::naming(Opcode::Accept, 0, naming).pack(BaseId::DEFAULT.command())).code
}

fn in_review(seed: u64) -> Bench {
    let mut bench = Bench::new(seed);
    bench.lead_to(StateName::Review);
    bench
}

#[test]
fn a_value_is_named_by_the_frames_that_showed_it() {
    let mut bench = Bench::new(51);
    assert_eq!(bench.request(Opcode::SetWearer as u8, 0, 4_711).code, Reason::Fine);
    bench.lead_to(StateName::Review);
    let naming = bench.naming().unwrap();
    assert_eq!((naming.run_id, naming.wearer), (1, 4_711));
    assert_eq!(naming.checksum, checksum_of(&bench, naming.boot, 4_711));
    assert_eq!(accept(&mut bench, &naming), Reason::Fine);
    assert_eq!(bench.procedure().live().unwrap().wearer, 4_711);
}

#[test]
fn another_value_boot_or_run_is_not_accepted() {
    let mut bench = in_review(52);
    let right = bench.naming().unwrap();
    for (wrong, reason) in [
        (Naming { checksum: right.checksum ^ 1, ..right }, Reason::WrongValue),
        (Naming { boot: right.boot + 1, ..right }, Reason::WrongValue),
        (Naming { run_id: right.run_id + 1, ..right }, Reason::StaleRun),
        (Naming { run_id: 0, ..right }, Reason::BadArgument),
    ] {
        assert_eq!(accept(&mut bench, &wrong), reason, "{wrong:?}");
        assert!(bench.procedure().live().is_none());
    }
    assert_eq!(accept(&mut bench, &right), Reason::Fine);
}

/// After a restart another person is calibrated; the accept of a client that still means the first person comes late.
#[test]
fn a_late_accept_of_another_boot_does_not_put_the_next_centre_in_use() {
    let mut bench = in_review(53);
    let of_the_first = bench.naming().unwrap();
    bench.restart(Restart::default(), Err(glenoid::record::LoadError::Nothing));
    bench.lead_to(StateName::Review);
    assert!(bench.naming().unwrap().run_id != of_the_first.run_id, "run ids go on");
    assert_eq!(accept(&mut bench, &of_the_first), Reason::StaleRun);
    // even if the run had the same number
    let same_run = Naming { run_id: bench.naming().unwrap().run_id, ..of_the_first };
    assert_eq!(accept(&mut bench, &same_run), Reason::WrongValue);
    assert!(bench.procedure().live().is_none());
}

#[test]
fn what_has_not_been_shown_whole_cannot_be_accepted() {
    let mut bench = Bench::new(54);
    bench.lead_to(StateName::Verifying);
    bench.capture(3);
    assert_eq!(bench.command(Opcode::Verify).code, Reason::Fine);
    while bench.state() != StateName::Review {
        bench.pass(1);
    }
    // the frames have only begun to go out; a client that guesses right all the same is too early
    let live = {
        let mut shown = bench.fork();
        shown.pass(100);
        shown.naming().unwrap()
    };
    assert_eq!(accept(&mut bench, &live), Reason::ReportIncomplete);
    bench.pass(100);
    assert_eq!(accept(&mut bench, &live), Reason::Fine);
}

#[test]
fn nothing_is_accepted_while_an_encoder_is_at_fault() {
    let mut silent = in_review(55);
    let naming = silent.naming().unwrap();
    silent.silent = true;
    silent.pass(600);
    assert_eq!(accept(&mut silent, &naming), Reason::EncoderSilent);
    silent.silent = false;
    silent.pass(600);
    assert_eq!(accept(&mut silent, &naming), Reason::Fine);
}

#[test]
fn nothing_is_accepted_after_counts_were_lost_in_review() {
    let mut bench = in_review(56);
    let naming = bench.naming().unwrap();
    let mut leapt = bench.at.counts;
    leapt[2] += 5_000;
    bench.set_counts(leapt);
    bench.pass(2_000);
    assert_eq!(accept(&mut bench, &naming), Reason::EncoderJumped);
    assert!(bench.procedure().live().is_none());
}

/// Start, Abort, Start within a second, each once by its nonce, whatever came between.
#[test]
fn a_command_is_obeyed_once_whatever_comes_between() {
    let mut bench = Bench::new(57);
    let frame = |opcode: Opcode, nonce| {
        Request { opcode: opcode as u8, boot: 0, nonce, run_id: 0, argument: 0 }.pack(BaseId::DEFAULT.command())
    };
    let first = bench.raw(frame(Opcode::Start, 900));
    assert_eq!((first.code, first.run_id), (Reason::Fine, 1));
    assert_eq!(bench.raw(frame(Opcode::Abort, 901)).code, Reason::Fine);
    bench.pass(100);
    // another client sends too
    for nonce in 0..30 {
        bench.raw(frame(Opcode::Capture, 100 + nonce));
    }
    assert_eq!(bench.raw(frame(Opcode::Start, 900)), first);
    assert_eq!(bench.state(), StateName::Idle, "the repetition starts nothing");
    bench.pass(1_000);
    assert_eq!(bench.raw(frame(Opcode::Start, 900)).run_id, 2, "later it is a new wish");
}

#[test]
fn a_client_that_sends_too_much_is_told_so() {
    let mut bench = Bench::new(58);
    let codes: Vec<Reason> = (1..=80).map(|_| bench.command(Opcode::Capture).code).collect();
    assert!(codes[..40].iter().all(|code| *code == Reason::WrongState), "{codes:?}");
    assert!(codes[40..].iter().all(|code| *code == Reason::TooManyCommands), "{codes:?}");
    bench.pass(1_000);
    assert_eq!(bench.command(Opcode::Capture).code, Reason::WrongState);
}

/// A record as the shoulder could have it.
fn record(change: impl Fn(&mut Record)) -> Record {
    let rig = Rig::shoulder(150.0).unwrap();
    let mut record = Record {
        rig: fingerprint(&rig),
        parameters: *rig.nominal(),
        covariance_mm2: std::array::from_fn(|k| 0.01 + k as f32 * 1e-4),
        ..power_cut::record(7)
    };
    change(&mut record);
    record
}

#[test]
fn a_record_with_a_sound_checksum_and_an_impossible_centre_is_named_and_not_used() {
    type Change = fn(&mut Record);
    let cases: [(Change, Reason); 5] = [
        (|r| r.parameters.centre_mm.x = 1e30, Reason::CentreImplausible),
        (|r| r.parameters.centre_mm.z = -148.0, Reason::CentreImplausible),
        (|r| r.parameters = Parameters::from_array([0.0, 0.0, 148.0, 1.0, 140.0, 140.0]), Reason::RadiusImplausible),
        (|r| r.covariance_mm2[0] = 0.0, Reason::SigmaImplausible),
        (|r| r.zeros_mm[4] = 100.0, Reason::OffsetImplausible),
    ];
    for (change, reason) in cases {
        let mut bench = Bench::new(59);
        bench.restart(Restart::default(), Ok(record(change)));
        assert!(bench.procedure().live().is_none(), "{reason:?}");
        bench.pass(1_500);
        let told = bench
            .messages
            .iter()
            .any(|m| matches!(m, Message::Fault(Fault { code, active: true, .. }) if *code == reason));
        assert!(told, "{reason:?}");
    }
    let mut bench = Bench::new(59);
    bench.restart(Restart::default(), Ok(record(|_| ())));
    assert!(bench.procedure().live().is_some());
}

/// Yesterday's strap is not today's: a stored centre is unconfirmed until motion, or somebody, has confirmed it.
#[test]
fn a_stored_centre_is_unconfirmed_until_motion_bears_it_out() {
    let mut bench = in_review(60);
    bench.accept();
    assert_eq!(bench.device.live_set().standing, Standing::Confirmed);
    let record = bench.records[0];
    bench.restart(Restart::default(), Ok(record));
    assert_eq!(bench.device.live_set().standing, Standing::Unconfirmed);
    let mut named = bench.fork();
    for _ in 0..4 {
        bench.next_pose();
    }
    assert_eq!(bench.device.live_set().standing, Standing::Confirmed);

    let naming = named.messages.iter().rev().find_map(|m| if let Message::LiveNaming(n) = m { Some(*n) } else { None });
    let naming = naming.expect("the centre in use is named at power-up");
    let confirm = |naming: &Naming| Request::naming(Opcode::Confirm, 0, naming).pack(BaseId::DEFAULT.command());
    let wrong = Naming { checksum: !naming.checksum, ..naming };
    assert_eq!(named.raw(confirm(&wrong)).code, Reason::WrongValue);
    assert_eq!(named.device.live_set().standing, Standing::Unconfirmed);
    assert_eq!(named.raw(confirm(&naming)).code, Reason::Fine);
    assert_eq!(named.device.live_set().standing, Standing::Confirmed);
}

/// Counts that were lost while a centre is in use make it wrong; that outlives a restart, until somebody decides.
#[test]
fn a_doubt_outlives_a_restart() {
    let mut bench = in_review(61);
    bench.accept();
    bench.pass(200);
    let mut leapt = bench.at.counts;
    leapt[1] -= 9_000;
    bench.set_counts(leapt);
    bench.pass(500);
    let live = bench.device.live_set();
    assert_eq!((live.standing, live.reason()), (Standing::NotToBeUsed, Some(Reason::EncoderJumped)));
    let (record, boot) = (bench.records[0], bench.journal.last().unwrap().boot);
    bench.set_counts(bench.at.counts);
    bench.restart(Restart::default(), Ok(record));
    assert_eq!(bench.journal.last().unwrap().boot, boot + 1);
    let live = bench.device.live_set();
    assert_eq!((live.standing, live.reason()), (Standing::NotToBeUsed, Some(Reason::EncoderJumped)));
    // motion alone does not clear it
    for _ in 0..4 {
        bench.next_pose();
    }
    assert_eq!(bench.device.live_set().standing, Standing::NotToBeUsed);
    // a new centre does
    bench.lead_to(StateName::Review);
    bench.accept();
    assert_eq!(bench.device.live_set().standing, Standing::Confirmed);
    assert_eq!(bench.journal.last().unwrap().distrust, 0);
}

#[test]
fn the_record_says_whose_centre_it_is_and_of_which_boot() {
    let mut bench = Bench::new(62);
    bench.restart(Restart::default(), Err(glenoid::record::LoadError::Nothing));
    bench.request(Opcode::SetWearer as u8, 0, 99);
    bench.lead_to(StateName::Collecting);
    assert_eq!(bench.request(Opcode::SetWearer as u8, 0, 98).code, Reason::AlreadyRunning);
    bench.command(Opcode::Abort);
    bench.lead_to(StateName::Review);
    bench.accept();
    let record = bench.records[0];
    let identity =
        bench.messages.iter().rev().find_map(|m| if let Message::Identity(i) = m { Some(*i) } else { None }).unwrap();
    assert_eq!((record.wearer, record.boot, record.run_id), (99, identity.boot, 2));
    let live = bench.device.live_set();
    assert_eq!((live.wearer, live.boot, live.run_id), (99, identity.boot, 2));
}
