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

use super::error::StoreError;
use super::flash::PageFlash;
use super::journal_entry::JournalEntry;
use super::journal_pages::JournalPages;

/// The journal in two pages of a flash. Everything is done when a call returns; a board, which must not wait, has a
/// [`Storage`](super::Storage).
#[derive(Debug)]
pub struct Journal<F> {
    flash: F,
    pages: JournalPages,
}

impl<F: PageFlash> Journal<F> {
    /// The journal in the two pages from the byte `from` of the flash on, a multiple of the page size.
    pub const fn new(flash: F, from: u32) -> Self {
        Self { flash, pages: JournalPages::new::<F>(from) }
    }

    /// The last entry; None when none was ever completed, or none can be read.
    pub fn last(&mut self) -> Option<JournalEntry> {
        self.pages.last(&mut self.flash)
    }

    /// Appends an entry.
    ///
    /// # Errors
    /// [`StoreError`]: the last entry is what it was before.
    pub fn append(&mut self, entry: &JournalEntry) -> Result<(), StoreError> {
        let mut appending = self.pages.begin(&mut self.flash, entry);
        while !self.pages.go_on(&mut self.flash, &mut appending)? {}
        Ok(())
    }
}
