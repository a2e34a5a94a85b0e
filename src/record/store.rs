//! The two pages together: which record counts, and how it is replaced.

use super::content::Record;
use super::flash::PageFlash;
use super::image::{self, Header, IMAGE_LEN, VERSION};
use super::page::{Content, LONGEST_COMMIT, Page, PageError, Reading, commit_len};
use super::replacement::Replacement;

/// Why there is no record to start with. The device then starts without a centre.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum LoadError {
    /// No record was ever completed. Not a fault: so it is on a new board.
    Nothing = 1,
    /// The flash could not be read.
    Unreadable = 2,
    /// A record was completed, and its CRC is wrong now.
    Damaged = 3,
    /// It was written by older firmware, in a layout that this firmware does not read.
    OlderVersion = 4,
    /// It was written by newer firmware.
    FromTheFuture = 5,
    /// It was found on another rig.
    OtherRig = 6,
    /// Its CRC is right, and its numbers cannot be those of a calibration.
    Unfit = 7,
    /// The flash is divided otherwise than the board's firmware expects. Said by the board, which then never asks.
    FlashLayout = 8,
}

impl LoadError {
    /// The number that stands for this error. Never renumbered.
    pub const fn code(self) -> u8 {
        self as u8
    }
}

impl core::fmt::Display for LoadError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Nothing => "no record was ever completed",
            Self::Unreadable => "the flash cannot be read",
            Self::Damaged => "the record's CRC is wrong",
            Self::OlderVersion => "the record is of an older version",
            Self::FromTheFuture => "the record was written by newer firmware",
            Self::OtherRig => "the record is of another rig",
            Self::Unfit => "the record's numbers cannot be those of a calibration",
            Self::FlashLayout => "the flash is divided otherwise than expected",
        })
    }
}

impl core::error::Error for LoadError {}

/// Why a record was not stored. The one that was there before still is, unless said otherwise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum StoreError {
    /// The numbers cannot be those of a calibration.
    Unfit = 16,
    /// The flash refused to erase: it is write-protected, or not set up as this board expects.
    EraseRefused = 17,
    /// The flash says that it has erased, and the page is not blank: it is worn.
    EraseIncomplete = 18,
    /// The flash refused to write: it is write-protected, or not set up as this board expects.
    WriteRefused = 19,
    /// What was read back is not what was written: the page is worn. The next power-up may find either record.
    ReadBackDiffers = 20,
    /// The flash is divided otherwise than the board's firmware expects. Said by the board, which then never tries.
    FlashLayout = 21,
}

impl StoreError {
    /// The number that stands for this error. Never renumbered; distinct from those of [`LoadError`].
    pub const fn code(self) -> u8 {
        self as u8
    }
}

impl core::fmt::Display for StoreError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Unfit => "the numbers cannot be those of a calibration",
            Self::EraseRefused => "the flash refuses to erase",
            Self::EraseIncomplete => "the flash is worn: an erased page is not blank",
            Self::WriteRefused => "the flash refuses to write",
            Self::ReadBackDiffers => "the flash is worn: it reads back other data than were written",
            Self::FlashLayout => "the flash is divided otherwise than expected",
        })
    }
}

impl core::error::Error for StoreError {}

impl From<PageError> for StoreError {
    fn from(error: PageError) -> Self {
        match error {
            PageError::EraseRefused => Self::EraseRefused,
            PageError::EraseIncomplete => Self::EraseIncomplete,
            PageError::WriteRefused => Self::WriteRefused,
            PageError::ReadBackDiffers => Self::ReadBackDiffers,
        }
    }
}

/// The record in two pages of a flash whose erased bytes read 0xFF.
#[derive(Debug)]
pub struct RecordStore<F> {
    flash: F,
    pages: [Page; 2],
    work: Work,
}

/// What is under way.
#[derive(Debug)]
enum Work {
    /// Nothing.
    Rest,
    /// A record is to be stored; where, the pages have not been asked yet.
    Given(Record),
    /// It is being stored.
    Going(Replacement),
}

impl<F: PageFlash> RecordStore<F> {
    /// Bytes of flash that the store takes: two pages.
    pub const LEN: usize = 2 * F::ERASE_SIZE;

    /// A store in the two pages from the byte `from` of the flash on, which must be a multiple of the page size.
    pub const fn new(flash: F, from: u32) -> Self {
        const {
            assert!(F::ERASE_SIZE >= IMAGE_LEN + LONGEST_COMMIT, "a page has no room for image and commit word");
            assert!(IMAGE_LEN.is_multiple_of(F::WRITE_SIZE), "the image is no whole number of words");
            assert!(commit_len::<F>().is_multiple_of(F::WRITE_SIZE), "the commit word is no whole number of words");
            assert!(commit_len::<F>() <= LONGEST_COMMIT, "the flash's words are too long");
            assert!(commit_len::<F>().is_multiple_of(F::READ_SIZE), "the commit word cannot be read alone");
        }
        Self { flash, pages: [Page { from }, Page { from: from + F::ERASE_SIZE as u32 }], work: Work::Rest }
    }

    /// The record that counts, if it is of the rig with this fingerprint. Finishes what a power cut left unfinished, so
    /// that afterwards one page holds the record with its commit word, and the other one is erased.
    ///
    /// # Errors
    /// [`LoadError`].
    pub fn load(&mut self, rig: u32) -> Result<Record, LoadError> {
        let readings = self.read();
        let Some((index, header)) = choose(&readings) else { return Err(why_nothing(&readings)) };
        let [first, second] = &readings;
        let (counts, other) = if index == 0 { (first, second) } else { (second, first) };
        // Failing to finish is no harm: the record counts as it stands, and the next store tries again.
        let _ = self.settle(index, counts, other);
        match header.version {
            0..VERSION => return Err(LoadError::OlderVersion),
            VERSION => {}
            _ => return Err(LoadError::FromTheFuture),
        }
        let record = image::decode(&counts.image);
        if record.rig != rig {
            Err(LoadError::OtherRig)
        } else if record.check().is_err() {
            Err(LoadError::Unfit)
        } else {
            Ok(record)
        }
    }

    /// Replaces the record, and returns when it is done. Two page erases and [`IMAGE_LEN`] bytes of writing: about 50 ms on
    /// the drive board, which therefore [`start`](Self::start)s it and [goes on](Self::go_on).
    ///
    /// # Errors
    /// [`StoreError`].
    pub fn store(&mut self, record: &Record) -> Result<(), StoreError> {
        self.start(record)?;
        loop {
            if let Some(result) = self.go_on() {
                return result;
            }
        }
    }

    /// Begins to replace the record. One that was on its way and not committed is given up.
    ///
    /// # Errors
    /// [`StoreError::Unfit`]; nothing is begun then.
    pub fn start(&mut self, record: &Record) -> Result<(), StoreError> {
        record.check().map_err(|_| StoreError::Unfit)?;
        self.work = Work::Given(*record);
        Ok(())
    }

    /// Does the next step of what was begun: starts an erase or the writing of one word, or looks how it went. The outcome
    /// when it is over; None while it goes on, and when there is nothing to do.
    ///
    /// # Errors
    /// [`StoreError`]: the record that was there before still is, unless said otherwise.
    pub fn go_on(&mut self) -> Option<Result<(), StoreError>> {
        let outcome = match &mut self.work {
            Work::Rest => return None,
            Work::Given(record) => {
                let record = *record;
                // what an earlier store has started is waited for
                if self.flash.is_busy().is_ok_and(|busy| busy) {
                    return None;
                }
                let (index, sequence) = choose(&self.read()).map_or((1, 0), |(index, header)| (index, header.sequence));
                let (target, old) = self.target_and_old(index);
                self.work = Work::Going(Replacement::of_record(&record, sequence.wrapping_add(1), target, old));
                return None;
            }
            Work::Going(replacement) => replacement.go_on(&mut self.flash),
        };
        match outcome {
            Ok(false) => return None,
            Ok(true) | Err(_) => self.work = Work::Rest,
        }
        Some(outcome.map(|_| ()).map_err(StoreError::from))
    }

    /// A record is on its way and not yet safe.
    pub const fn is_storing(&self) -> bool {
        !matches!(self.work, Work::Rest)
    }

    /// The flash, to look at.
    pub const fn flash(&self) -> &F {
        &self.flash
    }

    /// Gives the flash back.
    pub fn release(self) -> F {
        self.flash
    }

    fn read(&mut self) -> [Reading; 2] {
        self.pages.map(|page| page.read(&mut self.flash))
    }

    /// Brings the pages to rest: the record that counts, in the page `index`, committed, and the other page erased.
    fn settle(&mut self, index: usize, counts: &Reading, other: &Reading) -> Result<(), PageError> {
        let (target, old) = self.target_and_old(index);
        match (counts.committed, other.content) {
            (true, Content::Blank) => Ok(()),
            (true, _) => {
                target.start_erase(&mut self.flash)?;
                while self.flash.is_busy().map_err(|_| PageError::EraseRefused)? {}
                target.check_erased(&mut self.flash)
            }
            // Some word of it may be torn and have read rightly just this once.
            (false, _) => {
                let mut replacement = Replacement::of_image(counts.image, target, old);
                while !replacement.go_on(&mut self.flash)? {}
                Ok(())
            }
        }
    }

    /// The page that does not hold the record, and the page `index`, which does.
    fn target_and_old(&self, index: usize) -> (Page, Page) {
        let [first, second] = self.pages;
        if index == 0 { (second, first) } else { (first, second) }
    }
}

/// The page whose record counts: a sound one; of two, the committed one; of two of these, the newer.
fn choose([first, second]: &[Reading; 2]) -> Option<(usize, Header)> {
    match (first.content, second.content) {
        (Content::Sound(a), Content::Sound(b)) => {
            // serial number arithmetic (RFC 1982): right while they differ by less than half of the range
            let b_is_newer = b.sequence.wrapping_sub(a.sequence) as i32 > 0;
            let take_b = if first.committed == second.committed { b_is_newer } else { second.committed };
            Some(if take_b { (1, b) } else { (0, a) })
        }
        (Content::Sound(a), _) => Some((0, a)),
        (_, Content::Sound(b)) => Some((1, b)),
        _ => None,
    }
}

/// Why no page counts. A page without a commit word was never completed and says nothing.
fn why_nothing(readings: &[Reading; 2]) -> LoadError {
    if readings.iter().any(|reading| reading.content == Content::Unreadable) {
        LoadError::Unreadable
    } else if readings.iter().any(|reading| reading.content == Content::Broken && reading.committed) {
        LoadError::Damaged
    } else {
        LoadError::Nothing
    }
}
