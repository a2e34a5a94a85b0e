//! Where the board stands, word by word: boots and runs are counted over power-downs, and a distrust outlives them.
//!
//! ```text
//! page: | entry | entry | entry | erased … |        two pages, one in use
//! ```
//!
//! An entry of sixteen bytes is appended for every boot, every run, and whenever the centre in use comes to be trusted or
//! not. When the page in use is full, the other one is erased and goes on, with numbers beyond all of the full one. The last
//! entry is the last one in the page with the larger numbers whose CRC is right; a torn entry has none and is passed over.
//! So at every instant the last entry that was completed is there: the page in use is never erased.
//!
//! | from | bytes | content |
//! |---|---|---|
//! | 0 | 4 | number of the entry |
//! | 4 | 4 | boot |
//! | 8 | 2 | run id |
//! | 10 | 1 | code of the distrust, 0 for none |
//! | 11 | 1 | version, 1 |
//! | 12 | 4 | CRC-32 of a constant and all bytes before |

use super::error::StoreError;
use crc::{CRC_32_ISO_HDLC, Crc, NoTable};
use embedded_storage::nor_flash::NorFlash;

/// Bytes of an entry.
const ENTRY_LEN: usize = 16;
const VERSION: u8 = 1;
/// Places that are tried for an entry.
const MAX_TRIES: usize = 3;
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

/// The journal in two pages of a flash.
#[derive(Debug)]
pub struct Journal<F> {
    flash: F,
    from: u32,
}

/// An entry that was found, its number, and where it lies.
type Found = (u32, JournalEntry, usize);

impl<F: NorFlash> Journal<F> {
    const ENTRIES_A_PAGE: usize = F::ERASE_SIZE / ENTRY_LEN;

    /// The journal in the two pages from the byte `from` of the flash on, a multiple of the page size.
    pub const fn new(flash: F, from: u32) -> Self {
        const {
            assert!(ENTRY_LEN.is_multiple_of(F::WRITE_SIZE), "an entry is no whole number of words");
            assert!(ENTRY_LEN.is_multiple_of(F::READ_SIZE), "an entry cannot be read alone");
        }
        Self { flash, from }
    }

    /// The last entry; None when none was ever completed, or none can be read.
    pub fn last(&mut self) -> Option<JournalEntry> {
        self.find_last().map(|(_, entry, _)| entry)
    }

    /// Appends an entry.
    ///
    /// # Errors
    /// [`StoreError`]: the last entry is what it was before.
    pub fn append(&mut self, entry: &JournalEntry) -> Result<(), StoreError> {
        let last = self.find_last();
        let number = last.map_or(0, |(number, _, _)| number.wrapping_add(1));
        let page = last.map_or(0, |(_, _, place)| place / Self::ENTRIES_A_PAGE);
        let image = encode(number, entry);
        let page_end = (page + 1) * Self::ENTRIES_A_PAGE;
        // A torn word may read as erased and yet refuse to be written: then the next place serves.
        let mut places = self.first_free(page).map_or(0..0, |free| free..page_end).take(MAX_TRIES);
        if places.any(|place| self.write(place, &image).is_ok()) {
            return Ok(());
        }
        // full, or the first page of a new board holds something else
        let other = if last.is_some() { 1 - page } else { page };
        let from = self.from + (other * F::ERASE_SIZE) as u32;
        self.flash.erase(from, from + F::ERASE_SIZE as u32).map_err(|_| StoreError::EraseRefused)?;
        // beyond every number that a torn entry of the full page may have, should it read rightly some day
        let number = number.wrapping_add(Self::ENTRIES_A_PAGE as u32);
        self.write(other * Self::ENTRIES_A_PAGE, &encode(number, entry))
    }

    fn find_last(&mut self) -> Option<Found> {
        let mut last: Option<Found> = None;
        for place in 0..2 * Self::ENTRIES_A_PAGE {
            let Some((number, entry)) = self.read(place).and_then(|bytes| decode(&bytes)) else { continue };
            // Within a page the later place counts: a torn entry may read as one or as none. Between the pages the numbers
            // decide, by serial number arithmetic (RFC 1982).
            let counts = last.is_none_or(|(newest, _, at)| {
                at / Self::ENTRIES_A_PAGE == place / Self::ENTRIES_A_PAGE || number.wrapping_sub(newest) as i32 > 0
            });
            if counts {
                last = Some((number, entry, place));
            }
        }
        last
    }

    /// The place behind everything that stands in the page; None when it is full.
    fn first_free(&mut self, page: usize) -> Option<usize> {
        let places = page * Self::ENTRIES_A_PAGE..(page + 1) * Self::ENTRIES_A_PAGE;
        let is_erased = |bytes: [u8; ENTRY_LEN]| bytes == [0xFF; ENTRY_LEN];
        let used = places.clone().rev().find(|place| !self.read(*place).is_some_and(is_erased));
        let free = used.map_or(places.start, |place| place + 1);
        (free < places.end).then_some(free)
    }

    fn read(&mut self, place: usize) -> Option<[u8; ENTRY_LEN]> {
        let mut bytes = [0; ENTRY_LEN];
        self.flash.read(self.address(place), &mut bytes).ok()?;
        Some(bytes)
    }

    fn write(&mut self, place: usize, image: &[u8; ENTRY_LEN]) -> Result<(), StoreError> {
        self.flash.write(self.address(place), image).map_err(|_| StoreError::WriteRefused)?;
        if self.read(place).as_ref() == Some(image) { Ok(()) } else { Err(StoreError::ReadBackDiffers) }
    }

    fn address(&self, place: usize) -> u32 {
        self.from + (place * ENTRY_LEN) as u32
    }
}

fn encode(number: u32, entry: &JournalEntry) -> [u8; ENTRY_LEN] {
    let ([n0, n1, n2, n3], [b0, b1, b2, b3]) = (number.to_le_bytes(), entry.boot.to_le_bytes());
    let [r0, r1] = entry.run_id.to_le_bytes();
    let mut image = [n0, n1, n2, n3, b0, b1, b2, b3, r0, r1, entry.distrust, VERSION, 0, 0, 0, 0];
    let sum = checksum(&image).to_le_bytes();
    if let Some(place) = image.last_chunk_mut() {
        *place = sum;
    }
    image
}

fn decode(image: &[u8; ENTRY_LEN]) -> Option<(u32, JournalEntry)> {
    let [n0, n1, n2, n3, b0, b1, b2, b3, r0, r1, distrust, version, sum @ ..] = *image;
    if version != VERSION || u32::from_le_bytes(sum) != checksum(image) {
        return None;
    }
    let entry =
        JournalEntry { boot: u32::from_le_bytes([b0, b1, b2, b3]), run_id: u16::from_le_bytes([r0, r1]), distrust };
    Some((u32::from_le_bytes([n0, n1, n2, n3]), entry))
}

fn checksum(image: &[u8; ENTRY_LEN]) -> u32 {
    const CRC: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);
    let mut digest = CRC.digest();
    digest.update(&SALT);
    digest.update(image.get(..ENTRY_LEN - 4).unwrap_or_default());
    digest.finalize()
}
