//! The bytes, held against an image that Python's `struct` and `zlib.crc32` made by the table.

extern crate std;
use super::*;
use std::vec::Vec;

/// `b'GLNR' + pack('<HHIIH', 3, 0x102, 0x3040506, 0x708090A, 0xB0C) + bytes([3, 0, 1, 2, 3, 0x11, 2, 0x13, 0, 0])`,
/// then the 44 numbers of [`record`] as `<f`, 25 times `bytes([k + 1, 2 * k])`, `pack('<HHI', 0x1415, 0x1617, 0x18191A1B)`,
/// 50 zeros, the 30 numbers of the machine as `<f`, 204 zeros, and `zlib.crc32(b'\xa5gle' + all that)` as `<I`.
const BALL_BY_PYTHON: &str = "\
    474c4e5203000201060504030a0908070c0b030001020311021300000000c9420000cb420000cd420000cf420000d1\
    420000d3420000803e0000a03f0000104000005040000088400000a8400000c8400000e84000000441000014410000\
    244100003441000044410000544100006441000074410000824100008a410000924100009a410000a241000080bf00\
    0000c0000040c0000080c00000a0c00000c0c00000004000000840000010400000184000002040000028400000803d\
    0000003e0000403f0000c03e0000003f01000202030404060508060a070c080e09100a120b140c160d180e1a0f1c10\
    1e11201222132414261528162a172c182e1930151417161b1a19180000000000000000000000000000000000000000\
    000000000000000000000000000000000000000000000000000000000000000000bf0000c0bf000020c0000060c000\
    0090c00000b0c00000d0c00000f0c0000008c1000018c1000028c1000038c10000a2410000aa410000b2410000ba41\
    0000c2410000ca410000d2410000da410000e2410000ea410000f2410000fa410000803d0000003e0000403e000080\
    3e0000a03e0000c03e0000000000000000000000000000000000000000000000000000000000000000000000000000\
    0000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000\
    0000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000\
    0000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000\
    000000000000000000000000000000000000000000000000004fa2eff3";

/// The same with 1 at byte 262 and `pack('<24h', *[(k - 12) * 700 for k in range(24)])` from 264 on.
const BY_PYTHON: &str = "\
    474c4e5203000201060504030a0908070c0b030001020311021300000000c9420000cb420000cd420000cf420000d1\
    420000d3420000803e0000a03f0000104000005040000088400000a8400000c8400000e84000000441000014410000\
    244100003441000044410000544100006441000074410000824100008a410000924100009a410000a241000080bf00\
    0000c0000040c0000080c00000a0c00000c0c00000004000000840000010400000184000002040000028400000803d\
    0000003e0000403f0000c03e0000003f01000202030404060508060a070c080e09100a120b140c160d180e1a0f1c10\
    1e11201222132414261528162a172c182e1930151417161b1a1918010030dfece1a8e464e720eadcec98ef54f210f5\
    ccf788fa44fd0000bc0278053408f00aac0d68102413e0159c18581b141e000000bf0000c0bf000020c0000060c000\
    0090c00000b0c00000d0c00000f0c0000008c1000018c1000028c1000038c10000a2410000aa410000b2410000ba41\
    0000c2410000ca410000d2410000da410000e2410000ea410000f2410000fa410000803d0000003e0000403e000080\
    3e0000a03e0000c03e0000000000000000000000000000000000000000000000000000000000000000000000000000\
    0000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000\
    0000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000\
    0000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000\
    00000000000000000000000000000000000000000000000000652534eb";

/// What [`BALL_BY_PYTHON`] holds.
fn ball() -> Record {
    Record { motion: None, ..record() }
}

fn record() -> Record {
    Record {
        run_id: 0x0102,
        boot: 0x1415,
        wearer: 0x1617,
        serial: 0x1819_1A1B,
        rig: 0x0708_090A,
        firmware: [1, 2, 3],
        parameters: Parameters::from_array([100.5, 101.5, 102.5, 103.5, 104.5, 105.5]),
        covariance_mm2: core::array::from_fn(|k| 0.25 + k as f32),
        zeros_mm: [-1.0, -2.0, -3.0, -4.0, -5.0, -6.0],
        zero_sigmas_mm: [2.0, 2.125, 2.25, 2.375, 2.5, 2.625],
        noise_mm: 0.0625,
        deviation_mm: 0.125,
        excitation_rad: 0.75,
        poses: 0x0B0C,
        left_out: 3,
        rejected: core::array::from_fn(|k| Rejected { pose: k as u32 + 1, cables: k as u8 * 2 }),
        iterations: 0x11,
        termination: 2,
        verification_poses: 0x13,
        verification_deviation_mm: 0.375,
        verification_limit_mm: 0.5,
        motion: Some(motion()),
        machine: MachineDeviation {
            base_mm: core::array::from_fn(|k| -0.5 - k as f32),
            ends_mm: core::array::from_fn(|k| 20.25 + k as f32),
            scale: core::array::from_fn(|k| 0.0625 * (k as f32 + 1.0)),
        },
    }
}

/// -8400, -7700, ... 7700.
fn motion() -> ShownMotion {
    ShownMotion::from_parts(core::array::from_fn(|part| {
        core::array::from_fn(|k| (part as i16 * 3 + k as i16 - 12) * 700)
    }))
}

fn by_python() -> Image {
    bytes_of(BY_PYTHON)
}

fn bytes_of(digits: &str) -> Image {
    let digits: Vec<u8> = digits.bytes().collect();
    let bytes: Vec<u8> =
        digits.chunks(2).map(|pair| u8::from_str_radix(core::str::from_utf8(pair).unwrap(), 16).unwrap()).collect();
    bytes.try_into().unwrap()
}

#[test]
fn the_bytes_never_change() {
    assert_eq!(encode(&record(), 0x0304_0506), by_python());
}

#[test]
fn what_was_written_is_read() {
    assert_eq!(header(&by_python()), Ok(Header { version: 3, sequence: 0x0304_0506 }));
    assert_eq!(decode(&by_python()), record());
}

#[test]
fn a_ball_is_written_and_read() {
    assert_eq!(encode(&ball(), 0x0304_0506), bytes_of(BALL_BY_PYTHON));
    assert_eq!(decode(&bytes_of(BALL_BY_PYTHON)), ball());
}

/// A CRC-32 finds every burst of up to 32 bits, so every wrong byte.
#[test]
fn every_wrong_byte_is_found() {
    for at in 0..IMAGE_LEN {
        for wrong in 1..=u8::MAX {
            let mut image = by_python();
            image[at] ^= wrong;
            assert_eq!(header(&image), Err(Broken), "byte {at} xor {wrong:#x}");
        }
    }
}

/// What flash reads as when it is erased, worn or torn. A CRC-32 of its own last bytes would accept some of these.
#[test]
fn equal_bytes_are_no_record() {
    for byte in 0..=u8::MAX {
        assert_eq!(header(&[byte; IMAGE_LEN]), Err(Broken));
        let mut image = [byte; IMAGE_LEN];
        image[..4].copy_from_slice(&MAGIC);
        assert_eq!(header(&image), Err(Broken));
    }
}

#[test]
fn a_record_without_sense_is_told() {
    let record = || Record { motion: Some(ShownMotion::from_parts([[1; 3]; MOTION_PARTS])), ..record() };
    assert_eq!(record().check(), Ok(()));
    assert_eq!(ball().check(), Ok(()));
    let spoilt: [fn(&mut Record); 13] = [
        |r| r.motion = Some(ShownMotion::from_parts(core::array::from_fn(|k| [if k == 6 { -1 } else { 1 }; 3]))),
        |r| r.motion = Some(ShownMotion::from_parts(core::array::from_fn(|k| [if k == 7 { 6_000 } else { 1 }; 3]))),
        |r| r.run_id = 0,
        |r| r.left_out = 26,
        |r| r.parameters.centre_mm.y = f32::NAN,
        |r| r.parameters.radii_mm[2] = 0.0,
        |r| r.covariance_mm2[20] = -0.1,
        |r| r.covariance_mm2[1] = f32::INFINITY,
        |r| r.zeros_mm[5] = f32::NEG_INFINITY,
        |r| r.zero_sigmas_mm[0] = -1.0,
        |r| r.verification_limit_mm = f32::NAN,
        |r| r.machine.ends_mm[11] = f32::NAN,
        |r| r.machine.scale[5] = f32::INFINITY,
    ];
    for (index, spoil) in spoilt.into_iter().enumerate() {
        let mut record = record();
        spoil(&mut record);
        assert!(record.check().is_err(), "{index}");
    }
}
