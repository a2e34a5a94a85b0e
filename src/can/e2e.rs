//! End-to-end protection after AUTOSAR E2E Profile 4 (AUTOSAR FO-R22, "E2E Protocol Specification", 6.5).
//!
//! A protected unit of data begins with a header of twelve bytes, all big-endian: length of the unit (16 bits), counter
//! (16), identifier of the data (32), CRC (32). The CRC is that of the profile, CRC-32/AUTOSAR (polynomial 0xF4ACFB13),
//! over all bytes but its own. The receiver finds corruption by the CRC, another sender's data by the identifier,
//! cut data by the length, and repetition, loss and reordering by the counter, which grows by one with every unit.

use crc::{CRC_32_AUTOSAR, Crc, Table};

/// Length of the header, bytes.
pub const HEADER_LEN: usize = 12;

/// Where the CRC stands in the header.
const CRC_AT: usize = 8;

/// Why a unit of data is not to be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum E2eError {
    /// Shorter than a header, or the length in the header is another one.
    WrongLength,
    /// Data of another kind, or of another sender.
    WrongId,
    /// A byte has changed on the way, or parts of different units were mixed.
    WrongCrc,
}

/// Writes the header of a unit; what stands behind its first [`HEADER_LEN`] bytes is protected with it.
pub fn protect(data: &mut [u8], id: u32, counter: u16) {
    // no unit of this vocabulary is longer than the length field counts
    let [l1, l0] = (data.len() as u16).to_be_bytes();
    let [c1, c0] = counter.to_be_bytes();
    let [i3, i2, i1, i0] = id.to_be_bytes();
    if let Some((header, _)) = data.split_first_chunk_mut::<HEADER_LEN>() {
        *header = [l1, l0, c1, c0, i3, i2, i1, i0, 0, 0, 0, 0];
    }
    let sum = checksum(data).to_be_bytes();
    if let Some(place) = data.get_mut(CRC_AT..HEADER_LEN) {
        place.copy_from_slice(&sum);
    }
}

/// Checks a unit and returns its counter. The caller holds the counter against that of the unit before.
///
/// # Errors
/// [`E2eError`].
pub fn check(data: &[u8], id: u32) -> Result<u16, E2eError> {
    let Some((header, _)) = data.split_first_chunk::<HEADER_LEN>() else { return Err(E2eError::WrongLength) };
    let [l1, l0, c1, c0, i3, i2, i1, i0, s3, s2, s1, s0] = *header;
    if usize::from(u16::from_be_bytes([l1, l0])) != data.len() {
        Err(E2eError::WrongLength)
    } else if u32::from_be_bytes([i3, i2, i1, i0]) != id {
        Err(E2eError::WrongId)
    } else if u32::from_be_bytes([s3, s2, s1, s0]) != checksum(data) {
        Err(E2eError::WrongCrc)
    } else {
        Ok(u16::from_be_bytes([c1, c0]))
    }
}

/// The profile's CRC over everything but the CRC.
fn checksum(data: &[u8]) -> u32 {
    // A kilobyte of table, in a place of its own: without it a set of telemetry takes some 2 000 instructions more.
    static CRC: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_AUTOSAR);
    let mut digest = CRC.digest();
    digest.update(data.get(..CRC_AT).unwrap_or_default());
    digest.update(data.get(HEADER_LEN..).unwrap_or_default());
    digest.finalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The example of the specification (16 bytes of zeros, identifier 0x0A0B0C0D, counter 0); the Python package
    /// `autosar-e2e` 1.0.0 gives the same bytes.
    const PUBLISHED: [u8; 16] =
        [0x00, 0x10, 0x00, 0x00, 0x0A, 0x0B, 0x0C, 0x0D, 0x86, 0x2B, 0x05, 0x56, 0x00, 0x00, 0x00, 0x00];

    #[test]
    fn the_published_example() {
        let mut data = [0; 16];
        protect(&mut data, 0x0A0B_0C0D, 0);
        assert_eq!(data, PUBLISHED);
        assert_eq!(check(&data, 0x0A0B_0C0D), Ok(0));
    }

    #[test]
    fn what_is_wrong_is_named() {
        let mut data = [7; 40];
        protect(&mut data, 1, 0xABCD);
        assert_eq!(check(&data, 1), Ok(0xABCD));
        assert_eq!(check(&data, 2), Err(E2eError::WrongId));
        assert_eq!(check(data.get(..39).unwrap_or_default(), 1), Err(E2eError::WrongLength));
        assert_eq!(check(&[], 1), Err(E2eError::WrongLength));
        for bit in 0..40 * 8 {
            let mut wrong = data;
            wrong[bit / 8] ^= 1 << (bit % 8);
            assert!(check(&wrong, 1).is_err(), "bit {bit}");
        }
    }
}
