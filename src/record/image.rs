//! The bytes of a record: little-endian, of one length in every version, with a CRC-32 at the end.
//!
//! | from | bytes | content |
//! |---|---|---|
//! | 0 | 4 | `GLNR` |
//! | 4 | 2 | version of this table |
//! | 6 | 2 | run id |
//! | 8 | 4 | sequence number: the larger one is the newer record, modulo 2³² |
//! | 12 | 4 | fingerprint of the rig |
//! | 16 | 2 + 1 + 1 | poses given, poses left out, zero |
//! | 20 | 3 | firmware major, minor, patch |
//! | 23 | 1 + 1 + 1 | iterations, termination, poses of the second set |
//! | 26 | 2 | zero |
//! | 28 | 24 | x, y, z, p1, p2, p3, mm |
//! | 52 | 84 | their covariance, mm², lower triangle row by row |
//! | 136 | 24 + 24 | encoder zeros and their 1σ, mm |
//! | 184 | 4 · 5 | noise, δE, excitation (rad), δE of the second set, its limit, mm |
//! | 204 | 25 · 2 | poses left out: pose, faulty cables |
//! | 254 | 2 + 2 | boot, wearer |
//! | 258 | 4 | serial number of the board |
//! | 262 | 1 + 1 | joint: 0 ball, 1 moving centre; zero |
//! | 264 | 8 · 3 · 2 | how the centre moves: the integers of [`ShownMotion`]; zero for a ball |
//! | 312 | 48 + 48 | how the base and the platform differ from what is stated: coefficients of their shape modes, mm |
//! | 408 | 24 | by how much each drum pays out more than stated, relative |
//! | 432 | 204 | zero; for later versions |
//! | 636 | 4 | CRC-32 of a constant and all bytes before |
//!
//! The record of a hinge has the same head, and a version and a table of its own (`hinge_image`). What every version and every
//! kind of image has is in `sealed`.

pub use super::bytes::{IMAGE_LEN, Image};
use super::bytes::{Reader, Writer};
use super::content::Record;
use super::sealed;
pub use super::sealed::{Broken, Header};
use crate::identification::Rejected;
use crate::identification::joint::{MOTION_PARTS, ShownMotion};
use crate::identification::machine::MachineDeviation;
use crate::rig::Parameters;

/// Version of the table above.
pub const VERSION: u16 = 3;

/// The kind of the image.
pub(super) const MAGIC: [u8; 4] = *b"GLNR";
const RESERVED_LEN: usize = 204;
/// Of the field that says which joint it is.
const MOVING: u8 = 1;

/// Packs a record.
pub fn encode(record: &Record, sequence: u32) -> Image {
    let mut writer = Writer::new();
    writer.put(MAGIC);
    writer.put(VERSION.to_le_bytes());
    writer.put(record.run_id.to_le_bytes());
    writer.put(sequence.to_le_bytes());
    writer.put(record.rig.to_le_bytes());
    writer.put(record.poses.to_le_bytes());
    writer.put([record.left_out, 0]);
    writer.put(record.firmware);
    writer.put([record.iterations, record.termination, record.verification_poses]);
    writer.put([0; 2]);
    writer.put_numbers(&record.parameters.to_array());
    writer.put_numbers(&record.covariance_mm2);
    writer.put_numbers(&record.zeros_mm);
    writer.put_numbers(&record.zero_sigmas_mm);
    writer.put_numbers(&[record.noise_mm, record.deviation_mm, record.excitation_rad]);
    writer.put_numbers(&[record.verification_deviation_mm, record.verification_limit_mm]);
    for rejected in &record.rejected {
        // no set has more poses than a byte counts
        writer.put([rejected.pose as u8, rejected.cables]);
    }
    writer.put(record.boot.to_le_bytes());
    writer.put(record.wearer.to_le_bytes());
    writer.put(record.serial.to_le_bytes());
    writer.put([if record.motion.is_some() { MOVING } else { 0 }, 0]);
    let parts = record.motion.map_or([[0; 3]; MOTION_PARTS], |motion| *motion.parts());
    for number in parts.as_flattened() {
        writer.put(number.to_le_bytes());
    }
    writer.put_numbers(&record.machine.base_mm);
    writer.put_numbers(&record.machine.ends_mm);
    writer.put_numbers(&record.machine.scale);
    writer.put([0; RESERVED_LEN]);
    sealed::seal(&mut writer.image);
    writer.image
}

/// Looks whether the image is whole, and what it says of itself.
///
/// # Errors
/// [`Broken`].
pub fn header(image: &Image) -> Result<Header, Broken> {
    sealed::header(image, MAGIC)
}

/// Unpacks an image of this version. Call [`header`] first: nothing is checked here.
pub fn decode(image: &Image) -> Record {
    let mut reader = Reader::new(image);
    reader.take::<6>();
    let run_id = u16::from_le_bytes(reader.take());
    reader.take::<4>();
    let rig = u32::from_le_bytes(reader.take());
    let poses = u16::from_le_bytes(reader.take());
    let [left_out, _] = reader.take();
    let firmware = reader.take();
    let [iterations, termination, verification_poses] = reader.take();
    reader.take::<2>();
    let parameters = Parameters::from_array(reader.take_numbers());
    let covariance_mm2 = reader.take_numbers();
    let zeros_mm = reader.take_numbers();
    let zero_sigmas_mm = reader.take_numbers();
    let [noise_mm, deviation_mm, excitation_rad, verification_deviation_mm, verification_limit_mm] =
        reader.take_numbers();
    let rejected = core::array::from_fn(|_| {
        let [pose, cables] = reader.take();
        Rejected { pose: u32::from(pose), cables }
    });
    let boot = u16::from_le_bytes(reader.take());
    let wearer = u16::from_le_bytes(reader.take());
    let serial = u32::from_le_bytes(reader.take());
    let [joint, _] = reader.take();
    let parts = core::array::from_fn(|_| core::array::from_fn(|_| i16::from_le_bytes(reader.take())));
    let machine = MachineDeviation {
        base_mm: reader.take_numbers(),
        ends_mm: reader.take_numbers(),
        scale: reader.take_numbers(),
    };
    Record {
        run_id,
        boot,
        wearer,
        serial,
        rig,
        firmware,
        parameters,
        covariance_mm2,
        zeros_mm,
        zero_sigmas_mm,
        noise_mm,
        deviation_mm,
        excitation_rad,
        poses,
        left_out,
        rejected,
        iterations,
        termination,
        verification_poses,
        verification_deviation_mm,
        verification_limit_mm,
        motion: (joint == MOVING).then(|| ShownMotion::from_parts(parts)),
        machine,
    }
}

/// The image's CRC-32.
pub fn checksum(image: &Image) -> u32 {
    sealed::checksum(image)
}

#[cfg(test)]
mod tests;
