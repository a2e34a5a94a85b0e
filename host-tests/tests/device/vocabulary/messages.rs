//! Every message, field by field, against the DBC.

use super::dbc::Database;
use glenoid::can::command::Request;
use glenoid::can::{BaseId, Frame, Message, Opcode, PackError, UnpackError};
use host_tests::vocabulary::{KINDS, fields, random_message};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

#[test]
fn every_message_is_in_the_dbc_and_no_other() {
    let database = Database::load();
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut names: Vec<String> =
        (0..KINDS).map(|kind| fields(&random_message(kind, &mut random)).0.to_owned()).collect();
    names.extend(["Command", "ParameterRequest", "Parameter", "LiveSet", "Telemetry"].map(str::to_owned));
    let mut defined: Vec<String> = database.messages.values().map(|definition| definition.name.clone()).collect();
    names.sort();
    defined.sort();
    assert_eq!(names, defined);
    for definition in database.messages.values() {
        assert_eq!(definition.length, 8);
        assert_eq!(definition.sender == "Client", ["Command", "ParameterRequest"].contains(&&*definition.name));
    }
}

#[test]
fn no_two_signals_overlap_and_every_step_is_a_power_of_two() {
    for definition in Database::load().messages.values() {
        let mut taken = [false; 64];
        // what is multiplexed may lie where other pieces have something else
        for signal in definition.signals.iter().filter(|signal| signal.multiplexed.is_none()) {
            for position in signal.positions() {
                assert!(!std::mem::replace(&mut taken[position as usize], true), "{} {}", definition.name, signal.name);
            }
            assert_eq!(signal.step().log2().fract(), 0.0, "{} {}", definition.name, signal.name);
        }
    }
}

/// What the library packs, the DBC decodes to the same values, rounded to the signal's step.
#[test]
fn packed_messages_decode_by_the_dbc() {
    let database = Database::load();
    let mut random = ChaCha8Rng::seed_from_u64(2);
    for number in 0..200_000u32 {
        let message = random_message((number % u32::from(KINDS)) as u8, &mut random);
        let frame = message.pack(BaseId::DEFAULT).unwrap();
        let definition = &database.messages[&frame.raw_id()];
        let (name, expected) = fields(&message);
        assert_eq!((name, expected.len()), (definition.name.as_str(), definition.signals.len()));
        for ((field, value), signal) in expected.iter().zip(&definition.signals) {
            assert_eq!(*field, signal.name, "{name}");
            let decoded = signal.decode(frame.data());
            assert!((decoded - value).abs() <= signal.step() / 2.0, "{name}.{field}: {value} became {decoded}");
        }
    }
}

/// What the DBC says is in random bytes, the library unpacks from them; and it packs the same bytes again.
#[test]
fn random_bytes_unpack_by_the_dbc() {
    let database = Database::load();
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let mut unpacked = 0;
    for _ in 0..400_000 {
        let definition_id = match random.random_range(0..u16::from(KINDS)) {
            kind @ 0..23 => 0x681 + kind,
            // past the multiplexed ones
            kind => 0x69C + kind - 23,
        };
        let definition = &database.messages[&definition_id];
        let mut data: [u8; 8] = random.random();
        clear_unused(definition, &mut data);
        let frame = Frame::new(definition_id, &data).unwrap();
        let message = match Message::unpack(&frame, BaseId::DEFAULT) {
            Ok(message) => message,
            // a code that is not assigned
            Err(error) => {
                assert_eq!(error, UnpackError::UnknownCode);
                continue;
            }
        };
        unpacked += 1;
        let missing = |known: &str| fields(&message).1.iter().any(|(field, value)| *field == known && *value == 0.0);
        for ((field, value), signal) in fields(&message).1.iter().zip(&definition.signals) {
            if !missing(&format!("{field}_known")) {
                // a single holds 24 bits of the wider fields
                let decoded = signal.decode(&data);
                assert!((decoded - value).abs() <= decoded.abs() * 2f64.powi(-24), "{}.{field}", definition.name);
            }
        }
        let again = Message::unpack(&message.pack(BaseId::DEFAULT).unwrap(), BaseId::DEFAULT).unwrap();
        assert_eq!(again, message);
    }
    assert!(unpacked > 100_000, "{unpacked}");
}

fn clear_unused(definition: &super::dbc::Definition, data: &mut [u8; 8]) {
    for position in 0..64 {
        if !definition.signals.iter().any(|signal| signal.positions().contains(&position)) {
            data[position as usize / 8] &= !(1 << (position % 8));
        }
    }
}

#[test]
fn a_value_that_is_no_number_is_never_sent_as_one() {
    let mut random = ChaCha8Rng::seed_from_u64(4);
    for wrong in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30] {
        for kind in 0..KINDS {
            let mut message = random_message(kind, &mut random);
            let floats = spoil(&mut message, wrong);
            let packed = message.pack(BaseId::DEFAULT);
            assert_eq!(packed.is_err(), floats, "{message:?}");
            if floats {
                assert_eq!(packed, Err(PackError::OutOfRange));
            }
        }
    }
}

/// Puts a value into one measured field of the message; false when it has none.
fn spoil(message: &mut Message, wrong: f32) -> bool {
    match message {
        Message::Pose(m) => m.sigma_mm = Some(wrong),
        Message::Outcome(m) => m.size_mm = Some(wrong),
        Message::CandidateCentre(m) | Message::LiveCentre(m) => m.value_mm = wrong,
        Message::CandidateRadius(m) | Message::LiveRadius(m) => m.sigma_mm = wrong,
        Message::Quality(m) => m.noise_mm = wrong,
        Message::Verification(m) => m.deviation_mm = wrong,
        Message::WeakDirection(m) => m.direction[5] = wrong,
        Message::Axis(m) => m.axis[2] = wrong,
        Message::RawLength(m) => m.length_mm = wrong,
        Message::CandidateZero(m) => m.value_mm = wrong,
        Message::LiveZero(m) => m.sigma_mm = wrong,
        Message::Watch(m) => m.moved_mm[1] = wrong,
        Message::CandidateHingeAxis(m) => m.value = wrong,
        Message::CandidateHingePlace(m) => m.sigma_mm = wrong,
        Message::LiveHingeAxis(m) => m.sigma = wrong,
        Message::LiveHingePlace(m) => m.value_mm = wrong,
        Message::HingeAngle(m) => m.angle_rad = wrong,
        _ => return false,
    }
    true
}

#[test]
fn commands_by_the_dbc() {
    let database = Database::load();
    let definition = &database.messages[&0x680];
    let mut random = ChaCha8Rng::seed_from_u64(5);
    for _ in 0..20_000 {
        let request = Request {
            // accept and confirm: the only ones that name a boot
            opcode: if random.random() { 5 } else { 13 },
            boot: random.random(),
            nonce: random.random(),
            run_id: random.random(),
            argument: random.random(),
        };
        let frame = request.pack(BaseId::DEFAULT.command());
        let decoded: Vec<f64> = definition.signals.iter().map(|signal| signal.decode(frame.data())).collect();
        let expected = [request.opcode.into(), request.boot.into(), request.nonce, request.run_id, request.argument]
            .map(f64::from);
        assert_eq!(decoded, expected);
        assert_eq!(Request::unpack(frame.data()), Ok(request));
    }
    let names = &database.values[&(0x680, "opcode".to_owned())];
    assert_eq!(names.len(), Opcode::ALL.len());
    for opcode in Opcode::ALL {
        assert_eq!(names[&(opcode as u8)], format!("{opcode:?}"));
    }
    assert_eq!(names, &database.values[&(0x681, "opcode".to_owned())]);
}

#[test]
fn frames_of_others_are_told_apart() {
    let frame = |id, data: &[u8]| Message::unpack(&Frame::new(id, data).unwrap(), BaseId::DEFAULT);
    assert_eq!(frame(0x67F, &[0; 8]), Err(UnpackError::Foreign));
    assert_eq!(frame(0x6C0, &[0; 8]), Err(UnpackError::Foreign));
    // within the block: the command, and identifiers that nothing uses yet
    assert_eq!(frame(0x680, &[0; 8]), Err(UnpackError::Foreign));
    assert_eq!(frame(0x6BF, &[0; 8]), Err(UnpackError::Foreign));
    assert_eq!(frame(0x682, &[0; 7]), Err(UnpackError::WrongLength));
    assert_eq!(frame(0x682, &[0, 0, 0x0F, 0, 0, 0, 0, 0]), Err(UnpackError::UnknownCode));
}

#[test]
fn another_base_moves_every_identifier() {
    assert_eq!(BaseId::new(0x6A0), None);
    assert_eq!(BaseId::new(0x800), None);
    let base = BaseId::new(0x7C0).unwrap();
    let message = random_message(1, &mut ChaCha8Rng::seed_from_u64(6));
    let frame = message.pack(base).unwrap();
    assert_eq!((frame.raw_id(), base.command().as_raw()), (0x7C2, 0x7C0));
    assert_eq!(Message::unpack(&frame, base), Ok(message));
    assert_eq!(Message::unpack(&frame, BaseId::DEFAULT), Err(UnpackError::Foreign));
}
