//! Parameters over CAN: read, prepared, checked, stored and switched whole.

use super::bench::Bench;
use glenoid::can::{Operation, ParameterAnswer, ParameterRequest};
use glenoid::parameters::{ParameterSet, TABLE};
use glenoid::procedure::{Limits, Reason, StateName};
use glenoid::record::StoreError;
use glenoid::restart::{ResetCause, Restart};
use glenoid::rig::Rig;
use host_tests::wearer::WearerSettings;
use siphasher::sip::SipHasher24;
use std::hash::Hasher;

fn ask(bench: &mut Bench, operation: Operation, index: u16, value: u32) -> ParameterAnswer {
    bench.parameter(ParameterRequest { operation: operation as u8, index, nonce: 0, value })
}

/// A device as it leaves the image.
fn bench_of_defaults() -> Bench {
    Bench::of(ParameterSet::new().config(Restart::default(), 0).unwrap(), WearerSettings::default())
}

/// Writes a whole set over the bus, and saves it; returns what the board was asked to store.
fn write_and_save(bench: &mut Bench, set: &ParameterSet) -> ParameterSet {
    for entry in TABLE {
        let bits = set.bits(entry.index).unwrap();
        assert_eq!(ask(bench, Operation::Write, entry.index, bits).code, Reason::Fine, "{}", entry.description().name);
    }
    bench.save_parameters(Ok(())).expect("an answer to Save");
    *bench.sets.last().unwrap()
}

#[test]
fn every_parameter_is_listed_and_read() {
    let mut bench = bench_of_defaults();
    let mut index = 0;
    for entry in TABLE {
        let listed = ask(&mut bench, Operation::List, index + 1, 0);
        assert_eq!((listed.code, listed.value), (Reason::Fine, u32::from(entry.index)));
        index = entry.index;
        let is_key = entry.description().name.starts_with("LockKey");
        for (operation, expected) in [
            (Operation::ReadDefault, entry.default),
            (Operation::ReadMinimum, entry.minimum),
            (Operation::ReadMaximum, entry.maximum),
            (Operation::Read, entry.default),
        ] {
            let answer = ask(&mut bench, operation, entry.index, 0);
            if is_key && operation == Operation::Read {
                assert_eq!((answer.code, answer.value), (Reason::WriteOnly, 0));
            } else if !is_key {
                assert_eq!(
                    (answer.code, answer.value),
                    (Reason::Fine, expected),
                    "{} {operation:?}",
                    entry.description().name
                );
            }
        }
    }
    assert_eq!(ask(&mut bench, Operation::List, index + 1, 0).code, Reason::UnknownParameter);
}

/// The same image becomes another machine by parameters alone, and calibrates right.
#[test]
fn one_image_becomes_shoulder_wrist_and_a_large_rig() {
    for rig in [Rig::<f32>::wrist().unwrap(), Rig::shoulder(350.0).unwrap(), Rig::shoulder(150.0).unwrap()] {
        let mut writer = Bench::new(81);
        let set = write_and_save(&mut writer, &ParameterSet::of(&rig, &Limits::for_rig(&rig)));
        writer.pass(100);
        assert_eq!(writer.stopped, Some(ResetCause::Requested), "it starts anew with the whole set");
        let config = set.config(Restart::default(), 0).unwrap();
        assert_eq!(config.rig.ball(), Some(&rig));
        let offsets = rig.nominal().radii_mm[0] as f64 / 10.0;
        let wearer = WearerSettings {
            seed: 81,
            noise_mm: 0.1,
            centre_offset_mm: offsets,
            cuff_offset_mm: offsets / 2.0,
            ..Default::default()
        };
        let mut bench = Bench::of(config, wearer);
        bench.lead_to(StateName::Review);
        let identified = &bench.procedure().candidate().unwrap().identified;
        let truth = bench.wearer.truth().centre_mm;
        for axis in 0..3 {
            let error = f64::from(identified.parameters.centre_mm[axis]) - truth[axis];
            let sigma = f64::from(identified.sigma_mm()[axis]);
            assert!(error.abs() < 5.0 * sigma, "{error} mm, sigma {sigma}");
        }
    }
}

#[test]
fn bad_requests_are_refused_by_code_and_change_nothing() {
    let mut bench = bench_of_defaults();
    let nan = f32::NAN.to_bits();
    for (operation, index, value, code) in [
        (Operation::Read, 9, 0, Reason::UnknownParameter),
        (Operation::Write, 9, 0, Reason::UnknownParameter),
        (Operation::Write, 10, nan, Reason::ParameterOutOfRange),
        (Operation::Write, 10, 3_000f32.to_bits(), Reason::ParameterOutOfRange),
        (Operation::Write, 161, 0, Reason::ParameterOutOfRange),
        (Operation::Unlock, 0, 1, Reason::WrongKey),
    ] {
        assert_eq!(ask(&mut bench, operation, index, value).code, code, "{operation:?} {index}");
    }
    let unknown = bench.parameter(ParameterRequest { operation: 0, index: 10, nonce: 0, value: 0 });
    assert_eq!(unknown.code, Reason::UnknownOperation);
    for entry in TABLE.iter().filter(|entry| !entry.description().name.starts_with("LockKey")) {
        assert_eq!(ask(&mut bench, Operation::ReadPrepared, entry.index, 0).value, entry.default);
    }
}

#[test]
fn a_set_that_contradicts_itself_is_not_stored() {
    let mut bench = Bench::new(83);
    assert_eq!(ask(&mut bench, Operation::Write, 19, 900f32.to_bits()).code, Reason::Fine);
    for operation in [Operation::Check, Operation::Save] {
        let answer = ask(&mut bench, operation, 0, 0);
        assert_eq!((answer.code, answer.value), (Reason::ParametersContradict, 19));
    }
    assert!(bench.sets.is_empty());
    assert_eq!(ask(&mut bench, Operation::Discard, 0, 0).code, Reason::Fine);
    assert_eq!(ask(&mut bench, Operation::Check, 0, 0).code, Reason::Fine);
}

#[test]
fn nothing_is_saved_in_a_run_and_a_failed_store_leaves_all_as_it_was() {
    let mut bench = Bench::new(84);
    bench.lead_to(StateName::Collecting);
    assert_eq!(ask(&mut bench, Operation::Write, 161, 500).code, Reason::Fine);
    assert_eq!(ask(&mut bench, Operation::Save, 0, 0).code, Reason::AlreadyRunning);
    assert_eq!(ask(&mut bench, Operation::EraseRecord, 0, 0).code, Reason::AlreadyRunning);
    bench.command(glenoid::can::Opcode::Abort);
    let answer = bench.save_parameters(Err(StoreError::WriteRefused)).unwrap();
    assert_eq!(answer.code, Reason::StoreRefused);
    bench.pass(200);
    assert_eq!(bench.stopped, None);
    assert_eq!(ask(&mut bench, Operation::Read, 161, 0).value, 400, "in use is what was in use");
}

#[test]
fn a_repeated_write_is_not_obeyed_again() {
    let mut bench = Bench::new(85);
    let write = |nonce, value| ParameterRequest { operation: Operation::Write as u8, index: 161, nonce, value };
    let first = bench.parameter(write(5, 300));
    bench.parameter(write(6, 600));
    assert_eq!(bench.parameter(write(5, 300)), first);
    assert_eq!(ask(&mut bench, Operation::ReadPrepared, 161, 0).value, 600);
}

/// Who does not have the key writes no constant of the rig, erases no record, and narrows no prior.
#[test]
fn the_lock_guards_what_can_make_a_centre_wrong() {
    let key = [0x1122_3344u32, 0x5566_7788, 0x99AA_BBCC, 0xDDEE_FF00];
    let mut set = ParameterSet::new();
    (200..).zip(key).for_each(|(index, word)| set.set_bits(index, word).unwrap());
    set.set_bits(170, 2f32.to_bits()).unwrap();
    let mut bench = Bench::of(set.config(Restart::default(), 0).unwrap(), WearerSettings::default());
    for entry in TABLE {
        let code = ask(&mut bench, Operation::Write, entry.index, set.bits(entry.index).unwrap()).code;
        assert_eq!(code == Reason::Locked, entry.guarded, "{}", entry.description().name);
    }
    assert_eq!(ask(&mut bench, Operation::EraseRecord, 0, 0).code, Reason::Locked);
    assert_eq!(ask(&mut bench, Operation::Reset, 0, 0).code, Reason::Locked);
    let prior = glenoid::can::Opcode::SetZeroPrior as u8;
    assert_eq!(bench.request(prior, 0, 1_024).code, Reason::Locked);
    assert_eq!(bench.request(prior, 0, 4_096).code, Reason::Fine, "a wider one hides nothing");

    let challenge = ask(&mut bench, Operation::Challenge, 0, 0).value;
    // as docs/security.md says
    let [k0, k1, k2, k3] = key.map(u64::from);
    let mut hasher = SipHasher24::new_with_keys(k0 | k1 << 32, k2 | k3 << 32);
    hasher.write(&challenge.to_le_bytes());
    assert_eq!(ask(&mut bench, Operation::Unlock, 0, hasher.finish() as u32).code, Reason::Fine);
    assert_eq!(ask(&mut bench, Operation::Write, 100, 20f32.to_bits()).code, Reason::Fine);
    assert_eq!(bench.request(prior, 0, 1_024).code, Reason::Fine);
    assert_eq!(ask(&mut bench, Operation::Lock, 0, 0).code, Reason::Fine);
    assert_eq!(ask(&mut bench, Operation::Write, 100, 21f32.to_bits()).code, Reason::Locked);
}
