//! One page of the two: what it holds, and the three ways in which it changes. Each change is started, goes on by itself
//! where the flash can do that, and is looked at when it is over, a piece of the page at a time.

use super::flash::PageFlash;
use super::sealed::{self, Header};
use embedded_storage::nor_flash::NorFlash;

/// Longest commit word: flash whose smallest write is longer is not served.
pub(super) const LONGEST_COMMIT: usize = 32;

/// Bytes that are looked at at once: so that no look takes longer than writing a word.
pub(super) const PIECE: usize = 160;

/// What erased flash reads as.
const ERASED: u8 = 0xFF;
/// What the commit word is written as.
const COMMITTED: u8 = 0x3C;

/// What a page holds, read once and judged by that reading: torn words may read differently the next time.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reading<const LEN: usize> {
    pub content: Content,
    /// The commit word is there, whole: the image was complete when it was written.
    pub committed: bool,
    pub image: [u8; LEN],
}

/// What the place of the image holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Content {
    /// Nothing, as far as one can read.
    Blank,
    /// Something that is no record.
    Broken,
    /// A record, of whatever version.
    Sound(Header),
    /// The flash could not be read.
    Unreadable,
}

/// What went wrong with a page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PageError {
    /// The flash would not begin to erase, or ended with an error.
    EraseRefused,
    /// It has erased, and the page does not read as erased.
    EraseIncomplete,
    /// The flash would not begin to write, or ended with an error.
    WriteRefused,
    /// It has written, and something else is read.
    ReadBackDiffers,
}

/// Where a page lies in the flash, and which kind of image of which length it holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Page<const LEN: usize> {
    pub from: u32,
    pub magic: [u8; 4],
}

impl<const LEN: usize> Page<LEN> {
    /// What the page holds now.
    pub fn read<F: NorFlash>(self, flash: &mut F) -> Reading<LEN> {
        let mut image = [ERASED; LEN];
        let mut commit = [ERASED; LONGEST_COMMIT];
        let commit = commit.get_mut(..commit_len::<F>()).unwrap_or_default();
        let readable = flash.read(self.from, &mut image).is_ok() && flash.read(self.commit_from::<F>(), commit).is_ok();
        let content = match sealed::header(&image, self.magic) {
            _ if !readable => Content::Unreadable,
            Ok(header) => Content::Sound(header),
            Err(_) if is_all(&image, ERASED) && is_all(commit, ERASED) => Content::Blank,
            Err(_) => Content::Broken,
        };
        let committed = readable && is_all(commit, COMMITTED);
        Reading { content, committed, image }
    }

    /// Starts to erase the page.
    ///
    /// # Errors
    /// [`PageError::EraseRefused`].
    pub fn start_erase<F: PageFlash>(self, flash: &mut F) -> Result<(), PageError> {
        flash.start_erase(self.from).map_err(|_| PageError::EraseRefused)
    }

    /// Checks that the piece of the image's place that begins `at` bytes from its start is erased. The first piece stands for
    /// the commit word too.
    ///
    /// # Errors
    /// [`PageError::EraseIncomplete`].
    pub fn check_erased<F: NorFlash>(self, flash: &mut F, at: usize) -> Result<(), PageError> {
        let is_piece_erased = self.holds(flash, at, |_, place| is_all(place, ERASED));
        let is_commit_erased = at != 0 || self.holds_as_commit(flash, ERASED);
        if is_piece_erased && is_commit_erased { Ok(()) } else { Err(PageError::EraseIncomplete) }
    }

    /// Starts to write a word of the image, `at` bytes from its start.
    ///
    /// # Errors
    /// [`PageError::WriteRefused`].
    pub fn start_word<F: PageFlash>(self, flash: &mut F, at: usize, word: &[u8]) -> Result<(), PageError> {
        flash.start_write(self.from + at as u32, word).map_err(|_| PageError::WriteRefused)
    }

    /// Is the piece that begins `at` bytes from the start of the image right? It is handed over as it reads, with where it
    /// begins.
    pub fn holds<F: NorFlash>(self, flash: &mut F, at: usize, is_right: impl FnOnce(usize, &[u8]) -> bool) -> bool {
        let mut piece = [0; PIECE];
        let piece = piece.get_mut(..PIECE.min(LEN.saturating_sub(at))).unwrap_or_default();
        flash.read(self.from + at as u32, piece).is_ok() && is_right(at, piece)
    }

    /// Where the piece behind the one at `at` begins; None when that was the last one.
    pub fn next_piece(at: usize) -> Option<usize> {
        Some(at + PIECE).filter(|next| *next < LEN)
    }

    /// Starts to write the commit word, from which on the image counts. It is one word of the flash on the drive board, and
    /// written in one call elsewhere.
    ///
    /// # Errors
    /// [`PageError::WriteRefused`].
    pub fn start_commit<F: PageFlash>(self, flash: &mut F) -> Result<(), PageError> {
        let word = [COMMITTED; LONGEST_COMMIT];
        let word = word.get(..commit_len::<F>()).unwrap_or_default();
        flash.start_write(self.commit_from::<F>(), word).map_err(|_| PageError::WriteRefused)
    }

    /// Checks that the commit word is there.
    ///
    /// # Errors
    /// [`PageError::ReadBackDiffers`].
    pub fn check_committed<F: NorFlash>(self, flash: &mut F) -> Result<(), PageError> {
        if self.holds_as_commit(flash, COMMITTED) { Ok(()) } else { Err(PageError::ReadBackDiffers) }
    }

    fn holds_as_commit<F: NorFlash>(self, flash: &mut F, value: u8) -> bool {
        let mut word = [0; LONGEST_COMMIT];
        let word = word.get_mut(..commit_len::<F>()).unwrap_or_default();
        flash.read(self.commit_from::<F>(), word).is_ok() && is_all(word, value)
    }

    /// The commit word is the last one of the page.
    fn commit_from<F: NorFlash>(self) -> u32 {
        self.from + (F::ERASE_SIZE - commit_len::<F>()) as u32
    }
}

/// One word of the flash, and no less than one of the drive board's.
pub(super) const fn commit_len<F: NorFlash>() -> usize {
    const DRIVE_BOARDS: usize = 8;
    if F::WRITE_SIZE > DRIVE_BOARDS { F::WRITE_SIZE } else { DRIVE_BOARDS }
}

fn is_all(bytes: &[u8], value: u8) -> bool {
    bytes.iter().all(|byte| *byte == value)
}
