//! Lines against the Lawicel manual's examples and by hand; the property tests live on the host side.

extern crate std;

use super::*;
use std::vec::Vec;

fn frame(id: u16, data: &[u8]) -> Frame {
    Frame::new(id, data).unwrap()
}

#[test]
fn commands_of_the_manual() {
    let cases: [(&[u8], Command); 17] = [
        (b"", Command::Nothing),
        (b"S6", Command::BitRate(6)),
        (b"s031C", Command::BitTiming([0x03, 0x1C])),
        (b"O", Command::Open),
        (b"L", Command::Listen),
        (b"C", Command::Close),
        (b"V", Command::Version),
        (b"N", Command::SerialNumber),
        (b"F", Command::Status),
        (b"Z0", Command::TimeStamps(false)),
        (b"Z1", Command::TimeStamps(true)),
        (b"t10021133", Command::Transmit(frame(0x100, &[0x11, 0x33]))),
        (b"t7ff0", Command::Transmit(frame(0x7FF, &[]))),
        (b"t12380011223344aAbBcC", Command::Transmit(frame(0x123, &[0x00, 0x11, 0x22, 0x33, 0x44, 0xAA, 0xBB, 0xCC]))),
        (b"T0000010021133", Command::TransmitExtended { raw_id: 0x100 }),
        (b"r1002", Command::TransmitRemote { raw_id: 0x100, extended: false }),
        (b"R1FFFFFFF0", Command::TransmitRemote { raw_id: 0x1FFF_FFFF, extended: true }),
    ];
    for (line, command) in cases {
        assert_eq!(parse(line), Ok(command), "{:?}", core::str::from_utf8(line));
    }
}

#[test]
fn every_refusal_by_its_name() {
    use SlcanError::*;
    let cases: [(&[u8], SlcanError); 24] = [
        (b"t123811223344556677889900AA", LineTooLong),
        (b"q", UnknownCommand),
        (b"d1230", UnknownCommand),
        (b"\xFF", UnknownCommand),
        (b"OO", WrongLength),
        (b"C1", WrongLength),
        (b"t", WrongLength),
        (b"t12", WrongLength),
        (b"t123", WrongLength),
        (b"t1232AA", WrongLength),
        (b"t1232AABBCC", WrongLength),
        (b"t1231A", WrongLength),
        (b"s03", WrongLength),
        (b"r1230AA", WrongLength),
        (b"t12g0", NotHexadecimal),
        (b"t123x", NotHexadecimal),
        (b"t1231 A", NotHexadecimal),
        (b"s031x", NotHexadecimal),
        (b"t8000", IdTooLarge),
        (b"T200000000", IdTooLarge),
        (b"t1239112233445566778899", DataTooLong),
        (b"r123F", DataTooLong),
        (b"SA", UnknownBitRate),
        (b"Z2", UnknownSetting),
    ];
    for (line, error) in cases {
        assert_eq!(parse(line), Err(error), "{:?}", core::str::from_utf8(line));
    }
}

#[test]
fn a_received_frame_as_the_manual_writes_it() {
    assert_eq!(encode(&frame(0x100, &[0x11, 0x33]), None), b"t10021133\r");
    assert_eq!(encode(&frame(0x7FF, &[]), None), b"t7FF0\r");
    // the longest line there is: it must fit its buffer to the last character
    assert_eq!(encode(&frame(0x00A, &[0x0F, 0xF0, 1, 2, 3, 4, 5, 6]), Some(59_999)), b"t00A80FF0010203040506EA5F\r");
}

#[test]
fn the_decoder_takes_up_after_noise() {
    let mut decoder = Decoder::new();
    let mut noise = Vec::from([0xA5; 300]);
    noise.extend(b"\rO\r\nt12\rC\r");
    let seen: Vec<_> = noise.iter().filter_map(|&byte| decoder.push(byte)).collect();
    assert_eq!(
        seen,
        [Err(SlcanError::LineTooLong), Ok(Command::Open), Err(SlcanError::WrongLength), Ok(Command::Close),]
    );
}

#[test]
fn codes_never_change() {
    use SlcanError::*;
    let all = [
        LineTooLong,
        UnknownCommand,
        WrongLength,
        NotHexadecimal,
        IdTooLarge,
        DataTooLong,
        UnknownBitRate,
        UnknownSetting,
        ChannelClosed,
        ListenOnly,
        ChannelOpen,
    ];
    assert_eq!(all.map(SlcanError::code), [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11]);
}
