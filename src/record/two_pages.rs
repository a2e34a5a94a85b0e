//! Two pages together: which image counts, and how it is replaced.

use super::error::{LoadError, StoreError};
use super::page::{Content, LONGEST_COMMIT, Page, PageError, Reading, commit_len};
use super::sealed::Header;
use embedded_storage::nor_flash::NorFlash;

/// Two pages of a flash that hold images of one kind and of `LEN` bytes.
#[derive(Debug, Clone, Copy)]
pub(super) struct TwoPages<const LEN: usize> {
    pages: [Page<LEN>; 2],
}

impl<const LEN: usize> TwoPages<LEN> {
    /// The two pages from the byte `from` of the flash on.
    pub const fn new<F: NorFlash>(from: u32, magic: [u8; 4]) -> Self {
        const {
            assert!(F::ERASE_SIZE >= LEN + LONGEST_COMMIT, "a page has no room for image and commit word");
            assert!(LEN.is_multiple_of(F::WRITE_SIZE), "the image is no whole number of words");
            assert!(commit_len::<F>().is_multiple_of(F::WRITE_SIZE), "the commit word is no whole number of words");
            assert!(commit_len::<F>() <= LONGEST_COMMIT, "the flash's words are too long");
            assert!(commit_len::<F>().is_multiple_of(F::READ_SIZE), "the commit word cannot be read alone");
        }
        Self { pages: [Page { from, magic }, Page { from: from + F::ERASE_SIZE as u32, magic }] }
    }

    /// The image that counts. Finishes what a power cut left unfinished.
    ///
    /// # Errors
    /// [`LoadError::Nothing`], [`LoadError::Damaged`], [`LoadError::Unreadable`].
    pub fn load<F: NorFlash>(&self, flash: &mut F) -> Result<(Header, [u8; LEN]), LoadError> {
        let readings = self.read(flash);
        let Some((index, header)) = choose(&readings) else { return Err(why_nothing(&readings)) };
        let [first, second] = &readings;
        let (counts, other) = if index == 0 { (first, second) } else { (second, first) };
        // Failing to finish is no harm: the image counts as it stands, and the next store tries again.
        let _ = self.settle(flash, index, counts, other);
        Ok((header, counts.image))
    }

    /// Replaces the image by one that is made for the next sequence number.
    ///
    /// # Errors
    /// [`StoreError`].
    pub fn store<F: NorFlash>(&self, flash: &mut F, image: impl FnOnce(u32) -> [u8; LEN]) -> Result<(), StoreError> {
        let (index, sequence) = self.chosen(flash).map_or((1, 0), |(index, header)| (index, header.sequence));
        self.replace(flash, index, &image(sequence.wrapping_add(1)))?;
        Ok(())
    }

    /// Erases both pages, the one that does not count first.
    ///
    /// # Errors
    /// [`StoreError`].
    pub fn erase<F: NorFlash>(&self, flash: &mut F) -> Result<(), StoreError> {
        let index = self.chosen(flash).map_or(1, |(index, _)| index);
        self.other_page(index).erase(flash)?;
        if let Some(page) = self.pages.get(index) {
            page.erase(flash)?;
        }
        Ok(())
    }

    /// The page that counts.
    // Its frame holds both images, 3 KB, which are done with before a page is written.
    #[inline(never)]
    fn chosen<F: NorFlash>(&self, flash: &mut F) -> Option<(usize, Header)> {
        choose(&self.read(flash))
    }

    fn read<F: NorFlash>(&self, flash: &mut F) -> [Reading<LEN>; 2] {
        // `map` would keep each reading three times on the stack: 9 KB (`cargo stack --ways`).
        let [first, second] = &self.pages;
        [first.read(flash), second.read(flash)]
    }

    /// Brings the pages to rest: the image that counts, in the page `index`, committed, and the other page erased.
    fn settle<F: NorFlash>(
        &self,
        flash: &mut F,
        index: usize,
        counts: &Reading<LEN>,
        other: &Reading<LEN>,
    ) -> Result<(), PageError> {
        match (counts.committed, other.content) {
            (true, Content::Blank) => Ok(()),
            (true, _) => self.other_page(index).erase(flash),
            // Some word of it may be torn and have read rightly just this once.
            (false, _) => self.replace(flash, index, &counts.image),
        }
    }

    /// Writes an image to the page that is not `index`, commits it, erases the page `index`.
    fn replace<F: NorFlash>(&self, flash: &mut F, index: usize, image: &[u8; LEN]) -> Result<(), PageError> {
        let target = self.other_page(index);
        target.erase(flash)?;
        target.write(flash, image)?;
        target.commit(flash)?;
        // The new record counts from here on. The old one must not outlive it; failing to erase it is reported by the next
        // store, which will need that page.
        if let Some(old) = self.pages.get(index) {
            let _ = old.erase(flash);
        }
        Ok(())
    }

    fn other_page(&self, index: usize) -> Page<LEN> {
        let [first, second] = self.pages;
        if index == 0 { second } else { first }
    }
}

/// The page whose image counts: a sound one; of two, the committed one; of two of these, the newer.
fn choose<const LEN: usize>([first, second]: &[Reading<LEN>; 2]) -> Option<(usize, Header)> {
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

/// Why no page counts. What is neither erased nor a record was one, or is no record of ours.
fn why_nothing<const LEN: usize>(readings: &[Reading<LEN>; 2]) -> LoadError {
    if readings.iter().any(|reading| reading.content == Content::Unreadable) {
        LoadError::Unreadable
    } else if readings.iter().any(|reading| reading.content == Content::Broken) {
        LoadError::Damaged
    } else {
        LoadError::Nothing
    }
}
