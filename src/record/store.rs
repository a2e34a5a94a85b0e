//! The record in its two pages.

use super::content::Record;
use super::error::{LoadError, StoreError};
use super::flash::PageFlash;
use super::hinge_content::JointRecord;
use super::hinge_image::{self, HINGE_VERSION};
use super::image::{self, IMAGE_LEN, Image, VERSION};
use super::page::PageError;
use super::two_pages::TwoPages;

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

/// The pages of the record.
pub(super) type RecordPages = TwoPages<IMAGE_LEN>;

/// The record that counts, if it is of the rig with this fingerprint.
pub(super) fn load<F: PageFlash>(pages: &mut RecordPages, flash: &mut F, rig: u32) -> Result<JointRecord, LoadError> {
    let (header, image) = pages.load(flash)?;
    let record = match header.version {
        0..VERSION => return Err(LoadError::OlderVersion),
        VERSION => JointRecord::Ball(image::decode(&image)),
        HINGE_VERSION => JointRecord::Hinge(hinge_image::decode(&image)),
        _ => return Err(LoadError::FromTheFuture),
    };
    if record.rig() != rig {
        Err(LoadError::OtherRig)
    } else if record.check().is_err() {
        Err(LoadError::Unfit)
    } else {
        Ok(record)
    }
}

/// The image of a record.
pub(super) fn image_of(record: &JointRecord, sequence: u32) -> Image {
    match record {
        JointRecord::Ball(record) => image::encode(record, sequence),
        JointRecord::Hinge(record) => hinge_image::encode(record, sequence),
    }
}

/// The record of a ball in two pages of a flash whose erased bytes read 0xFF. Everything is done when a call returns; a board, which
/// must not wait, has a [`Storage`](super::Storage).
#[derive(Debug)]
pub struct RecordStore<F> {
    flash: F,
    pages: RecordPages,
}

impl<F: PageFlash> RecordStore<F> {
    /// Bytes of flash that the store takes: two pages.
    pub const LEN: usize = 2 * F::ERASE_SIZE;

    /// A store in the two pages from the byte `from` of the flash on, which must be a multiple of the page size.
    pub const fn new(flash: F, from: u32) -> Self {
        Self { flash, pages: TwoPages::new::<F>(from, image::MAGIC) }
    }

    /// The record that counts, if it is a ball's of the rig with this fingerprint. Finishes what a power cut left unfinished, so
    /// that afterwards one page holds the record with its commit word, and the other one is erased.
    ///
    /// # Errors
    /// [`LoadError`].
    pub fn load(&mut self, rig: u32) -> Result<Record, LoadError> {
        match load(&mut self.pages, &mut self.flash, rig)? {
            JointRecord::Ball(record) => Ok(record),
            JointRecord::Hinge(_) => Err(LoadError::OtherRig),
        }
    }

    /// Replaces the record. Two page erases and [`IMAGE_LEN`] bytes of writing.
    ///
    /// # Errors
    /// [`StoreError`].
    pub fn store(&mut self, record: &Record) -> Result<(), StoreError> {
        record.check().map_err(|_| StoreError::Unfit)?;
        self.pages.store(&mut self.flash, |sequence| image::encode(record, sequence))
    }

    /// Erases the record.
    ///
    /// # Errors
    /// [`StoreError`].
    pub fn erase(&mut self) -> Result<(), StoreError> {
        self.pages.erase(&mut self.flash)
    }

    /// The flash, to look at.
    pub const fn flash(&self) -> &F {
        &self.flash
    }

    /// Gives the flash back.
    pub fn release(self) -> F {
        self.flash
    }
}
