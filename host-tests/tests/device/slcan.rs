//! The SLCAN codec under arbitrary input. Lines are written here by `format!`, not by the codec under test.

use glenoid::can::Frame;
use glenoid::slcan::{self, Adapter, Command, Decoder, SlcanError};
use proptest::collection::vec;
use proptest::prelude::*;

fn frames() -> impl Strategy<Value = Frame> {
    (0..=0x7FF_u16, vec(any::<u8>(), 0..=8)).prop_map(|(id, data)| Frame::new(id, &data).unwrap())
}

/// The line of a data frame, without its end.
fn line(frame: &Frame) -> String {
    let data: String = frame.data().iter().map(|byte| format!("{byte:02X}")).collect();
    format!("t{:03X}{}{data}", frame.raw_id(), frame.data().len())
}

/// Noise that does not look like anything: no line ends in it.
fn noise() -> impl Strategy<Value = Vec<u8>> {
    vec(any::<u8>().prop_filter("a line end", |byte| *byte != b'\r'), 0..100)
}

fn decode(bytes: &[u8]) -> Vec<Result<Command, SlcanError>> {
    let mut decoder = Decoder::new();
    bytes.iter().filter_map(|&byte| decoder.push(byte)).collect()
}

proptest! {
    #[test]
    fn a_frame_is_written_as_the_manual_says(frame in frames()) {
        prop_assert_eq!(slcan::encode(&frame, None).to_vec(), format!("{}\r", line(&frame)).into_bytes());
    }

    #[test]
    fn a_time_stamp_is_four_more_digits(frame in frames(), stamp_ms in 0..60_000_u16) {
        let expected = format!("{}{stamp_ms:04X}\r", line(&frame));
        prop_assert_eq!(slcan::encode(&frame, Some(stamp_ms)).to_vec(), expected.into_bytes());
    }

    #[test]
    fn frames_come_back_in_either_case(frames in vec(frames(), 1..20), lower in any::<bool>()) {
        let mut bytes = Vec::new();
        for frame in &frames {
            let line = line(frame);
            bytes.extend(if lower { line.to_lowercase() } else { line }.into_bytes());
            bytes.push(b'\r');
        }
        let expected: Vec<_> = frames.into_iter().map(|frame| Ok(Command::Transmit(frame))).collect();
        prop_assert_eq!(decode(&bytes), expected);
    }

    #[test]
    fn extended_and_remote_frames_are_understood(
        raw_id in 0..=0x1FFF_FFFF_u32, data in vec(any::<u8>(), 0..=8), len in 0..=8_u8
    ) {
        let digits: String = data.iter().map(|byte| format!("{byte:02x}")).collect();
        let extended = format!("T{raw_id:08X}{}{digits}", data.len());
        prop_assert_eq!(slcan::parse(extended.as_bytes()), Ok(Command::TransmitExtended { raw_id }));
        let remote = format!("R{raw_id:08x}{len}");
        prop_assert_eq!(slcan::parse(remote.as_bytes()), Ok(Command::TransmitRemote { raw_id, extended: true }));
        let short = format!("r{:03x}{len}", raw_id & 0x7FF);
        let expected = Command::TransmitRemote { raw_id: raw_id & 0x7FF, extended: false };
        prop_assert_eq!(slcan::parse(short.as_bytes()), Ok(expected));
    }

    /// Whatever stood before it, the line after a line end is read cleanly, and each line gives one result.
    #[test]
    fn one_result_a_line_and_a_clean_start_after_it(noise in vec(noise(), 0..10), frame in frames()) {
        let mut bytes = noise.join(&b'\r');
        bytes.extend(format!("\r{}\r", line(&frame)).into_bytes());
        let results = decode(&bytes);
        prop_assert_eq!(results.len(), noise.len().max(1) + 1);
        prop_assert_eq!(results.last(), Some(&Ok(Command::Transmit(frame))));
    }

    /// A frame with one digit changed into something else is never taken for another kind of line.
    #[test]
    fn a_damaged_frame_is_a_frame_or_refused(frame in frames(), place in 1..21_usize, byte in any::<u8>()) {
        let mut line = line(&frame).into_bytes();
        let place = place % line.len();
        line[place.max(1)] = byte;
        match slcan::parse(&line) {
            Ok(Command::Transmit(_)) | Err(SlcanError::NotHexadecimal | SlcanError::WrongLength) => {}
            Err(SlcanError::IdTooLarge) => prop_assert_eq!(place.max(1), 1),
            Err(SlcanError::DataTooLong) => prop_assert_eq!(place, 4),
            other => prop_assert!(false, "{:?}", other),
        }
    }

    /// The adapter answers every line once, and with nothing else than the manual's answers; its counters add up.
    #[test]
    fn every_line_is_answered_once(bytes in vec(prop_oneof![
        any::<u8>(),
        proptest::sample::select(b"\r\r\r\rCOLVNFSstTrRZ0123456789abcdefABCDEF".to_vec()),
    ], 0..2_000)) {
        let mut adapter = Adapter::new();
        let mut answers = Vec::new();
        for &byte in &bytes {
            answers.extend(adapter.receive(byte));
        }
        let lines = bytes.iter().filter(|&&byte| byte == b'\r').count();
        prop_assert_eq!(answers.len(), lines);
        let known: [&[u8]; 8] =
            [b"\r", b"z\r", b"Z\r", b"\x07", b"V0101\r", b"N0001\r", b"F00\r", b"F08\r"];
        prop_assert!(answers.iter().all(|answer| known.contains(&answer.reply)));
        prop_assert!(answers.iter().all(|answer| answer.refusal.is_some() == (answer.reply == b"\x07")));
        prop_assert!(answers.iter().all(|answer| answer.frame.is_none() || answer.reply == b"z\r"));
        let counters = adapter.counters();
        prop_assert_eq!(counters.refused as usize, answers.iter().filter(|a| a.refusal.is_some()).count());
        prop_assert_eq!(counters.accepted as usize, answers.iter().filter(|a| a.frame.is_some()).count());
    }
}
