//! The bytes of a hinge's record: its head is that of every record, and its version says that it is one.
//!
//! | from | bytes | content |
//! |---|---|---|
//! | 0 | 28 | as in [`image`](super::image), without iterations and termination |
//! | 28 | 56 | the hinge: axis and foot point in the base, attitude at angle zero (x, y, z, w), foot point in the platform, offset along the axis |
//! | 84 | 180 | covariance of its nine unknowns, rad and mm, lower triangle row by row |
//! | 264 | 4 · 5 | noise, residual, flexion (rad), deviation of the second set, its limit, mm |
//! | 284 | 80 | by how much the machine's constants differ from what is stated |
//! | 364 | 2 + 2 + 4 | boot, wearer, serial number of the board |
//! | 372 | 264 | zero; for later versions |
//! | 636 | 4 | CRC-32 |

use super::bytes::{Reader, Writer};
use super::hinge_content::HingeRecord;
use super::image::{Image, MAGIC};
use super::sealed;
use crate::identification::hinge::Hinge;

/// Version of the table above. The next of a ball's is another number.
pub const HINGE_VERSION: u16 = 4;

/// Packs a record.
pub(super) fn encode(record: &HingeRecord, sequence: u32) -> Image {
    let mut writer = Writer::new();
    writer.put(MAGIC);
    writer.put(HINGE_VERSION.to_le_bytes());
    writer.put(record.run_id.to_le_bytes());
    writer.put(sequence.to_le_bytes());
    writer.put(record.rig.to_le_bytes());
    writer.put(u16::from(record.poses).to_le_bytes());
    writer.put([record.left_out, 0]);
    writer.put(record.firmware);
    writer.put([0, 0, record.verification_poses]);
    writer.put([0; 2]);
    writer.put_numbers(&record.hinge.to_array());
    writer.put_numbers(&record.covariance);
    writer.put_numbers(&[record.noise_mm, record.rms_residual_mm, record.flexion_rad]);
    writer.put_numbers(&[record.verification_deviation_mm, record.verification_limit_mm]);
    writer.put_numbers(&record.constants);
    writer.put(record.boot.to_le_bytes());
    writer.put(record.wearer.to_le_bytes());
    writer.put(record.serial.to_le_bytes());
    sealed::seal(&mut writer.image);
    writer.image
}

/// Unpacks an image of this version. Nothing is checked here.
pub(super) fn decode(image: &Image) -> HingeRecord {
    let mut reader = Reader::new(image);
    reader.take::<6>();
    let run_id = u16::from_le_bytes(reader.take());
    reader.take::<4>();
    let rig = u32::from_le_bytes(reader.take());
    let [poses, _] = reader.take();
    let [left_out, _] = reader.take();
    let firmware = reader.take();
    let [_, _, verification_poses] = reader.take();
    reader.take::<2>();
    let hinge = Hinge::from_array(reader.take_numbers());
    let covariance = reader.take_numbers();
    let [noise_mm, rms_residual_mm, flexion_rad, verification_deviation_mm, verification_limit_mm] =
        reader.take_numbers();
    let constants = reader.take_numbers();
    HingeRecord {
        run_id,
        boot: u16::from_le_bytes(reader.take()),
        wearer: u16::from_le_bytes(reader.take()),
        serial: u32::from_le_bytes(reader.take()),
        rig,
        firmware,
        hinge,
        covariance,
        constants,
        noise_mm,
        rms_residual_mm,
        flexion_rad,
        poses,
        left_out,
        verification_poses,
        verification_deviation_mm,
        verification_limit_mm,
    }
}
