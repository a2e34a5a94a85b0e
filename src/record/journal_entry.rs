//! An entry of the journal, and its bytes.
//!
//! | from | bytes | content |
//! |---|---|---|
//! | 0 | 4 | number of the entry |
//! | 4 | 4 | boot |
//! | 8 | 2 | run id |
//! | 10 | 1 | code of the distrust, 0 for none |
//! | 11 | 1 | version, 1 |
//! | 12 | 4 | CRC-32 of a constant and all bytes before |

use super::sealed::CRC;

/// Bytes of an entry.
pub(super) const ENTRY_LEN: usize = 16;
const VERSION: u8 = 1;
/// Goes into the CRC before the entry.
const SALT: [u8; 4] = *b"\xA5glj";

/// Where the board stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct JournalEntry {
    /// Starts of this board so far.
    pub boot: u32,
    /// The last run that began; 0 before the first.
    pub run_id: u16,
    /// Code of the reason why the centre in use is not to be used; 0 for none.
    pub distrust: u8,
}

/// The bytes of the entry with this number.
pub(super) fn encode(number: u32, entry: &JournalEntry) -> [u8; ENTRY_LEN] {
    let ([n0, n1, n2, n3], [b0, b1, b2, b3]) = (number.to_le_bytes(), entry.boot.to_le_bytes());
    let [r0, r1] = entry.run_id.to_le_bytes();
    let mut image = [n0, n1, n2, n3, b0, b1, b2, b3, r0, r1, entry.distrust, VERSION, 0, 0, 0, 0];
    let sum = checksum(&image).to_le_bytes();
    if let Some(place) = image.last_chunk_mut() {
        *place = sum;
    }
    image
}

/// The number and the entry, if it is whole.
pub(super) fn decode(image: &[u8; ENTRY_LEN]) -> Option<(u32, JournalEntry)> {
    let [n0, n1, n2, n3, b0, b1, b2, b3, r0, r1, distrust, version, sum @ ..] = *image;
    if version != VERSION || u32::from_le_bytes(sum) != checksum(image) {
        return None;
    }
    let entry =
        JournalEntry { boot: u32::from_le_bytes([b0, b1, b2, b3]), run_id: u16::from_le_bytes([r0, r1]), distrust };
    Some((u32::from_le_bytes([n0, n1, n2, n3]), entry))
}

fn checksum(image: &[u8; ENTRY_LEN]) -> u32 {
    let mut digest = CRC.digest();
    digest.update(&SALT);
    digest.update(image.get(..ENTRY_LEN - 4).unwrap_or_default());
    digest.finalize()
}
