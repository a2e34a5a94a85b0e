//! The centre in use across power-down, and what the device tells of a restart.

use super::bench::Bench;
use glenoid::can::health::{BusHealth, StopText};
use glenoid::can::status::Fault;
use glenoid::can::{Message, Opcode, Operation, ParameterRequest, Standing};
use glenoid::device::{BlinkPattern, Event, LogEntry, fingerprint};
use glenoid::procedure::{Reason, StateName};
use glenoid::record::{LoadError, RecordStore, StoreError};
use glenoid::restart::{CrashRecord, ResetCause, Restart};
use glenoid::rig::Rig;
use host_tests::flash::{MockFlash, TornWord};

fn power_on() -> Restart {
    Restart { cause: ResetCause::PowerOn, crash_record: None }
}

/// A bench after an accepted run.
fn accepted() -> Bench {
    let mut bench = Bench::new(7);
    bench.lead_to(StateName::Review);
    assert_eq!(bench.decide(Opcode::Accept).code, Reason::Fine);
    bench
}

fn faults(messages: &[Message]) -> Vec<Fault> {
    messages
        .iter()
        .filter_map(|message| if let Message::Fault(fault) = message { Some(*fault) } else { None })
        .collect()
}

/// All messages about a centre in use and its quality, without heartbeats and the like.
fn about_the_live_centre(messages: &[Message]) -> Vec<Message> {
    let about = |message: &&Message| {
        matches!(
            message,
            Message::LiveCentre(_)
                | Message::LiveRadius(_)
                | Message::Quality(_)
                | Message::Verification(_)
                | Message::WeakDirection(_)
                | Message::LeftOut(_)
        )
    };
    messages.iter().filter(about).copied().collect()
}

#[test]
fn only_an_accepted_centre_is_stored_and_only_once() {
    let mut bench = Bench::new(7);
    bench.lead_to(StateName::Review);
    assert_eq!(bench.decide(Opcode::Reject).code, Reason::Fine);
    bench.lead_to(StateName::Collecting);
    assert_eq!(bench.command(Opcode::Abort).code, Reason::Fine);
    assert!(bench.records.is_empty());
    bench.lead_to(StateName::Review);
    assert!(bench.records.is_empty());
    bench.decide(Opcode::Accept);
    bench.pass(5_000);
    let [record] = bench.records[..] else { panic!("{} records", bench.records.len()) };
    let live = bench.procedure().live().unwrap();
    assert_eq!((record.run_id, record.parameters), (live.run_id, live.identified.parameters));
    assert_eq!(record.rig, fingerprint(&Rig::shoulder(150.0).unwrap()));
}

/// Through the flash and back: the device tells the same of its centre as before, to the bit.
#[test]
fn a_restart_finds_the_centre() {
    let mut bench = accepted();
    let mut flash = RecordStore::new(MockFlash::new(2, TornWord::Zeros, 1), 0);
    flash.store(&bench.records[0]).unwrap();
    bench.event(Event::Stored(Ok(())));
    bench.pass(200);
    bench.take_messages();
    bench.command(Opcode::Query);
    bench.pass(200);
    let before = about_the_live_centre(&bench.take_messages());
    assert!(before.len() >= 9, "{before:?}");

    let loaded = flash.load(bench.records[0].rig);
    bench.restart(power_on(), loaded);
    assert!(bench.heartbeat().flags.live);
    // nothing has borne it out since
    assert_eq!(bench.heartbeat().standing, Standing::Unconfirmed);
    assert_eq!(bench.led_patterns.last(), Some(&BlinkPattern::Unconfirmed));
    let live =
        bench.take_messages().iter().filter(|m| matches!(m, Message::LiveCentre(_) | Message::LiveRadius(_))).count();
    assert_eq!(live, 6, "the centre is told without being asked for");
    bench.command(Opcode::Query);
    bench.pass(200);
    assert_eq!(about_the_live_centre(&bench.take_messages()), before);
}

/// A run id names one run only, also after a restart.
#[test]
fn run_ids_go_on_after_a_restart() {
    let mut bench = accepted();
    let record = bench.records[0];
    bench.restart(power_on(), Ok(record));
    assert_eq!(bench.heartbeat().run_id, record.run_id);
    let start = bench.request(Opcode::Start as u8, 0, 1);
    assert_eq!((start.code, start.run_id), (Reason::Fine, record.run_id + 1));
}

#[test]
fn a_new_board_has_no_centre_and_no_fault() {
    let mut bench = Bench::new(1);
    bench.restart(power_on(), Err(LoadError::Nothing));
    bench.pass(3_000);
    assert!(!bench.heartbeat().flags.live);
    assert_eq!(faults(&bench.messages), []);
}

#[test]
fn a_refused_record_is_named_and_leaves_no_centre() {
    for (error, reason) in [
        (LoadError::Unreadable, Reason::RecordUnreadable),
        (LoadError::Damaged, Reason::RecordDamaged),
        (LoadError::OlderVersion, Reason::RecordOlder),
        (LoadError::FromTheFuture, Reason::RecordNewer),
        (LoadError::OtherRig, Reason::RecordOfOtherRig),
        (LoadError::Unfit, Reason::RecordUnfit),
        (LoadError::FlashLayout, Reason::FlashLayout),
    ] {
        let mut bench = Bench::new(1);
        bench.restart(power_on(), Err(error));
        assert!(!bench.heartbeat().flags.live);
        assert!(bench.logs.contains(&LogEntry::Loaded { run_id: 0, reason }), "{:?}", bench.logs);
        bench.pass(2_500);
        let faults = faults(&bench.take_messages());
        assert!(faults.len() >= 2, "told again while it lasts: {faults:?}");
        assert!(faults.iter().all(|fault| fault.code == reason && fault.active && fault.count == 1), "{faults:?}");
    }
}

/// The board asks for the record of the rig; should it hand over another all the same, the device refuses it.
#[test]
fn a_record_of_another_rig_never_becomes_live() {
    let mut bench = accepted();
    let mut record = bench.records[0];
    record.rig ^= 1;
    bench.restart(power_on(), Ok(record));
    assert!(bench.procedure().live().is_none());
    assert_eq!(faults(&bench.messages)[0].code, Reason::RecordOfOtherRig);
}

#[test]
fn a_store_that_fails_is_told_until_one_works() {
    for (error, reason) in [
        (StoreError::Unfit, Reason::RecordUnfit),
        (StoreError::EraseRefused, Reason::StoreRefused),
        (StoreError::EraseIncomplete, Reason::FlashWorn),
        (StoreError::WriteRefused, Reason::StoreRefused),
        (StoreError::ReadBackDiffers, Reason::FlashWorn),
        (StoreError::FlashLayout, Reason::FlashLayout),
    ] {
        let mut bench = accepted();
        bench.take_messages();
        bench.event(Event::Stored(Err(error)));
        bench.pass(2_500);
        let told = faults(&bench.take_messages());
        assert!(told.len() >= 2 && told.iter().all(|fault| fault.code == reason && fault.active), "{told:?}");
        assert!(bench.heartbeat().flags.live, "the centre stays in use");
        bench.event(Event::Stored(Ok(())));
        bench.pass(2_500);
        let told = faults(&bench.take_messages());
        assert!(matches!(told[..], [Fault { code, active: false, .. }] if code == reason), "{told:?}");
    }
}

/// A save ends in a restart, from the record: the centre in use would be gone without a word.
#[test]
fn a_centre_that_could_not_be_stored_is_not_saved_away() {
    let mut bench = accepted();
    bench.event(Event::Stored(Err(StoreError::WriteRefused)));
    let save = ParameterRequest { operation: Operation::Save as u8, index: 0, nonce: 9, value: 0 };
    assert_eq!(bench.parameter(save).code, Reason::StoreRefused);
    bench.pass(200);
    assert_eq!((bench.stopped, bench.sets.len()), (None, 0));
    assert!(bench.heartbeat().flags.live);
    bench.event(Event::Stored(Ok(())));
    assert_eq!(bench.save_parameters(Ok(())).unwrap().code, Reason::Fine);
}

/// The cause, the place and the whole text reach the bus, and a fault says that there is something to read.
#[test]
fn the_last_words_are_told_after_a_restart() {
    for text in ["", "1234567", "src/device/mod.rs: attempt to be interesting", &"long ".repeat(40)] {
        let words = CrashRecord::new(ResetCause::Panic, 0x0800_4242, 321, format_args!("{text}"));
        let mut bench = Bench::new(1);
        bench.restart(Restart::new(ResetCause::Requested, &words.seal()), Err(LoadError::Nothing));
        let messages = bench.take_messages();
        let cause = messages.iter().find_map(|m| if let Message::Versions(v) = m { Some(v.reset_cause) } else { None });
        assert_eq!(cause, Some(ResetCause::Panic));
        let stop =
            messages.iter().find_map(|m| if let Message::LastStop(stop) = m { Some(*stop) } else { None }).unwrap();
        assert_eq!((stop.cause, stop.address, stop.line), (ResetCause::Panic, 0x0800_4242, 321));
        let parts: Vec<StopText> =
            messages.iter().filter_map(|m| if let Message::StopText(part) = m { Some(*part) } else { None }).collect();
        assert!(parts.iter().enumerate().all(|(index, part)| usize::from(part.index) == index));
        let bytes: Vec<u8> = parts.iter().flat_map(|part| part.text).take(stop.text_len.into()).collect();
        assert_eq!(String::from_utf8(bytes).unwrap(), text[..text.len().min(96)]);
        let told = faults(&messages);
        assert!(matches!(told[..], [Fault { code: Reason::Restarted, active: true, .. }]), "{told:?}");
        // told until somebody has asked, then no longer
        bench.pass(2_000);
        assert_eq!(faults(&bench.take_messages()).len(), 2);
        bench.command(Opcode::Query);
        bench.pass(2_000);
        let told = faults(&bench.take_messages());
        assert!(matches!(told[..], [Fault { code: Reason::Restarted, active: false, .. }]), "{told:?}");
    }
}

#[test]
fn an_ordinary_start_is_no_fault() {
    for cause in [ResetCause::Unknown, ResetCause::PowerOn, ResetCause::Pin, ResetCause::Requested] {
        let mut bench = Bench::new(1);
        bench.restart(Restart { cause, crash_record: None }, Err(LoadError::Nothing));
        bench.pass(2_000);
        let messages = bench.take_messages();
        assert_eq!(faults(&messages), []);
        assert!(!messages.iter().any(|m| matches!(m, Message::LastStop(_) | Message::StopText(_))));
    }
}

#[test]
fn a_bus_that_was_lost_and_regained_is_told() {
    let mut bench = Bench::new(1);
    bench.take_messages();
    let health = BusHealth { bus_off: 2, dropped: 3, transmit_errors: 4, receive_errors: 5, error_passive: false };
    bench.event(Event::Bus(health));
    bench.event(Event::Bus(health));
    bench.pass(3_000);
    let told = faults(&bench.take_messages());
    assert!(matches!(told[..], [Fault { code: Reason::BusOff, count: 2, .. }]), "{told:?}");
    bench.command(Opcode::Query);
    bench.pass(100);
    assert!(bench.messages.contains(&Message::BusHealth(health)));
}
