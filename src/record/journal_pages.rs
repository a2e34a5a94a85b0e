//! The journal's two pages: where it ends, and how an entry gets there a step at a time.

use super::error::StoreError;
use super::flash::PageFlash;
use super::journal_entry::{ENTRY_LEN, JournalEntry, decode, encode};
use embedded_storage::nor_flash::NorFlash;

/// Places in the page in use that are tried for an entry: a torn word may read as erased and yet refuse to be written.
const MAX_TRIES: usize = 3;

/// The two pages of a journal, and where it ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct JournalPages {
    from: u32,
    /// None until somebody has looked.
    end: Option<End>,
}

/// Where a journal ends. Places count through both pages.
#[derive(Debug, Clone, Copy)]
struct End {
    /// The number and the page of the last entry that was completed, if there is one.
    last: Option<(u32, usize)>,
    /// The first place that nothing was ever written to; None: the page in use is full.
    free: Option<usize>,
}

/// An entry that was found, its number, and where it lies.
type Found = (u32, JournalEntry, usize);

/// An entry on its way into the flash.
#[derive(Debug, Clone, Copy)]
pub(super) struct Appending {
    entry: JournalEntry,
    number: u32,
    place: usize,
    image: [u8; ENTRY_LEN],
    step: Step,
    /// Places in the page in use that may still be tried; None: it goes into the other page, which is erased before.
    tries: Option<usize>,
}

/// What is done next, once the flash is not busy with what was started last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Step {
    /// The page is to be erased.
    Erase,
    /// The words from this byte of the entry on are to be written; of a page that has just been erased, when true.
    Write(usize, bool),
    /// The entry should be there.
    Check,
}

impl Appending {
    /// It waits for nothing that takes milliseconds.
    pub const fn is_quick(&self) -> bool {
        !matches!(self.step, Step::Write(0, true))
    }
}

impl JournalPages {
    /// The two pages from the byte `from` of the flash on.
    pub const fn new<F: NorFlash>(from: u32) -> Self {
        const {
            assert!(ENTRY_LEN.is_multiple_of(F::WRITE_SIZE), "an entry is no whole number of words");
            assert!(ENTRY_LEN.is_multiple_of(F::READ_SIZE), "an entry cannot be read alone");
        }
        Self { from, end: None }
    }

    /// The last entry, and the end is known from here on.
    pub fn last<F: NorFlash>(&mut self, flash: &mut F) -> Option<JournalEntry> {
        let found = self.find_last(flash);
        let page = found.map_or(0, |(_, _, place)| place / entries_a_page::<F>());
        let last = found.map(|(number, _, _)| (number, page));
        self.end = Some(End { last, free: self.first_free(flash, page) });
        found.map(|(_, entry, _)| entry)
    }

    /// Begins to append an entry. The flash must not be busy the first time.
    pub fn begin<F: NorFlash>(&mut self, flash: &mut F, entry: &JournalEntry) -> Appending {
        if self.end.is_none() {
            self.last(flash);
        }
        self.aim::<F>(entry, MAX_TRIES)
    }

    /// The next place for an entry: a free one of the page in use while there are tries left, else the first of the other
    /// page.
    fn aim<F: NorFlash>(&self, entry: &JournalEntry, tries: usize) -> Appending {
        let End { last, free } = self.end.unwrap_or(End { last: None, free: None });
        let next = last.map_or(0, |(number, _)| number.wrapping_add(1));
        let (number, place, step, tries) = match (free, tries.checked_sub(1)) {
            (Some(place), Some(left)) => (next, place, Step::Write(0, false), Some(left)),
            _ => {
                // The page of the last entry is never erased. On a new board the first page may be full of something else.
                let other = last.map_or(0, |(_, page)| 1 - page) * entries_a_page::<F>();
                // beyond every number that a torn entry of the full page may have, should it read rightly some day
                (next.wrapping_add(entries_a_page::<F>() as u32), other, Step::Erase, None)
            }
        };
        Appending { entry: *entry, number, place, image: encode(number, entry), step, tries }
    }

    /// Goes on with what [`begin`](Self::begin) has begun; true when all is done.
    ///
    /// # Errors
    /// [`StoreError`]: the last entry is what it was before.
    pub fn go_on<F: PageFlash>(&mut self, flash: &mut F, appending: &mut Appending) -> Result<bool, StoreError> {
        let Appending { number, place, image, step, .. } = appending;
        let result = match (flash.is_busy(), *step) {
            (Ok(true), _) => return Ok(false),
            (Err(_), Step::Write(0, true)) => Err(StoreError::EraseRefused),
            (Err(_), Step::Check | Step::Write(1.., _)) => Err(StoreError::WriteRefused),
            // what went wrong before was somebody else's
            (_, Step::Erase) => {
                let page = self.address(*place);
                *step = Step::Write(0, true);
                flash.start_erase(page).map_err(|_| StoreError::EraseRefused)
            }
            (_, Step::Write(at, is_new)) => {
                let next = at + F::WRITE_SIZE;
                *step = if next < ENTRY_LEN { Step::Write(next, is_new) } else { Step::Check };
                let word = image.get(at..next).unwrap_or_default();
                flash.start_write(self.address(*place) + at as u32, word).map_err(|_| StoreError::WriteRefused)
            }
            (Ok(false), Step::Check) if self.read(flash, *place).as_ref() == Some(image) => {
                self.written::<F>(*place, Some(*number));
                return Ok(true);
            }
            (Ok(false), Step::Check) => Err(StoreError::ReadBackDiffers),
        };
        match result {
            Ok(()) => Ok(false),
            // a page that cannot be erased is tried again
            Err(StoreError::EraseRefused) => Err(StoreError::EraseRefused),
            Err(error) => {
                self.written::<F>(*place, None);
                let tries = appending.tries.ok_or(error)?;
                *appending = self.aim::<F>(&appending.entry, tries);
                Ok(false)
            }
        }
    }

    /// A place was used: by the entry with this number, or in vain.
    fn written<F: NorFlash>(&mut self, place: usize, number: Option<u32>) {
        let (page, next) = (place / entries_a_page::<F>(), place + 1);
        if let Some(end) = &mut self.end {
            end.last = number.map(|number| (number, page)).or(end.last);
            end.free = Some(next).filter(|next| !next.is_multiple_of(entries_a_page::<F>()));
        }
    }

    fn find_last<F: NorFlash>(&self, flash: &mut F) -> Option<Found> {
        let mut last: Option<Found> = None;
        for place in 0..2 * entries_a_page::<F>() {
            let Some((number, entry)) = self.read(flash, place).and_then(|bytes| decode(&bytes)) else { continue };
            // Within a page the later place counts: a torn entry may read as one or as none. Between the pages the numbers
            // decide, by serial number arithmetic (RFC 1982).
            let counts = last.is_none_or(|(newest, _, at)| {
                at / entries_a_page::<F>() == place / entries_a_page::<F>() || number.wrapping_sub(newest) as i32 > 0
            });
            if counts {
                last = Some((number, entry, place));
            }
        }
        last
    }

    /// The place behind everything that stands in the page; None when it is full.
    fn first_free<F: NorFlash>(&self, flash: &mut F, page: usize) -> Option<usize> {
        let places = page * entries_a_page::<F>()..(page + 1) * entries_a_page::<F>();
        let is_erased = |bytes: [u8; ENTRY_LEN]| bytes == [0xFF; ENTRY_LEN];
        let used = places.clone().rev().find(|place| !self.read(flash, *place).is_some_and(is_erased));
        let free = used.map_or(places.start, |place| place + 1);
        (free < places.end).then_some(free)
    }

    fn read<F: NorFlash>(&self, flash: &mut F, place: usize) -> Option<[u8; ENTRY_LEN]> {
        let mut bytes = [0; ENTRY_LEN];
        flash.read(self.address(place), &mut bytes).ok()?;
        Some(bytes)
    }

    fn address(&self, place: usize) -> u32 {
        self.from + (place * ENTRY_LEN) as u32
    }
}

const fn entries_a_page<F: NorFlash>() -> usize {
    F::ERASE_SIZE / ENTRY_LEN
}
