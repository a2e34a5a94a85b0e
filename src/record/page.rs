//! One page of the two: what it holds, and the three ways in which it changes.

use super::sealed::{self, Header};
use embedded_storage::nor_flash::NorFlash;

/// Longest commit word: flash whose smallest write is longer is not served.
pub(super) const LONGEST_COMMIT: usize = 32;

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
    EraseRefused,
    EraseIncomplete,
    WriteRefused,
    ReadBackDiffers,
}

/// Where a page lies in the flash, and which kind of image of which length it holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Page<const LEN: usize> {
    pub from: u32,
    pub magic: [u8; 4],
}

impl<const LEN: usize> Page<LEN> {
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

    /// Erases the page and looks whether the places that will be written are erased.
    pub fn erase<F: NorFlash>(self, flash: &mut F) -> Result<(), PageError> {
        flash.erase(self.from, self.from + F::ERASE_SIZE as u32).map_err(|_| PageError::EraseRefused)?;
        match self.read(flash).content {
            Content::Blank => Ok(()),
            _ => Err(PageError::EraseIncomplete),
        }
    }

    /// Writes the image into the erased page and reads it back.
    pub fn write<F: NorFlash>(self, flash: &mut F, image: &[u8; LEN]) -> Result<(), PageError> {
        flash.write(self.from, image).map_err(|_| PageError::WriteRefused)?;
        let reading = self.read(flash);
        let same = reading.content != Content::Unreadable && reading.image == *image;
        if same { Ok(()) } else { Err(PageError::ReadBackDiffers) }
    }

    /// Writes the commit word: from here on the image counts.
    pub fn commit<F: NorFlash>(self, flash: &mut F) -> Result<(), PageError> {
        let word = [COMMITTED; LONGEST_COMMIT];
        let word = word.get(..commit_len::<F>()).unwrap_or_default();
        flash.write(self.commit_from::<F>(), word).map_err(|_| PageError::WriteRefused)?;
        if self.read(flash).committed { Ok(()) } else { Err(PageError::ReadBackDiffers) }
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
