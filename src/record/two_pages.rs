//! Two pages together: which image counts, and how it is replaced.

use super::erasure::Erasure;
use super::error::{LoadError, StoreError};
use super::flash::{PageFlash, wait};
use super::page::{Content, LONGEST_COMMIT, PIECE, Page, PageError, Reading, commit_len};
use super::replacement::{Progress, Replacement, Source};
use super::sealed::Header;
use embedded_storage::nor_flash::NorFlash;

/// Two pages of a flash that hold images of one kind and of `LEN` bytes.
#[derive(Debug, Clone, Copy)]
pub(super) struct TwoPages<const LEN: usize> {
    pages: [Page<LEN>; 2],
    /// Which one counts, once somebody has looked.
    counting: Option<Counting>,
}

/// The page that counts, and its sequence number.
#[derive(Debug, Clone, Copy)]
struct Counting {
    index: usize,
    sequence: u32,
}

impl Counting {
    /// No page counts: the first image goes into the first page.
    const NONE: Self = Self { index: 1, sequence: 0 };
}

impl<const LEN: usize> TwoPages<LEN> {
    /// The two pages from the byte `from` of the flash on.
    pub const fn new<F: NorFlash>(from: u32, magic: [u8; 4]) -> Self {
        const {
            assert!(F::ERASE_SIZE >= LEN + LONGEST_COMMIT, "a page has no room for image and commit word");
            assert!(LEN.is_multiple_of(F::WRITE_SIZE), "the image is no whole number of words");
            assert!(PIECE.is_multiple_of(F::READ_SIZE), "a piece of the image cannot be read alone");
            assert!(commit_len::<F>().is_multiple_of(F::WRITE_SIZE), "the commit word is no whole number of words");
            assert!(commit_len::<F>() <= LONGEST_COMMIT, "the flash's words are too long");
            assert!(commit_len::<F>().is_multiple_of(F::READ_SIZE), "the commit word cannot be read alone");
        }
        let pages = [Page { from, magic }, Page { from: from + F::ERASE_SIZE as u32, magic }];
        Self { pages, counting: None }
    }

    /// The image that counts. Finishes what a power cut left unfinished, and waits for it.
    ///
    /// # Errors
    /// [`LoadError::Nothing`], [`LoadError::Damaged`], [`LoadError::Unreadable`].
    pub fn load<F: PageFlash>(&mut self, flash: &mut F) -> Result<(Header, [u8; LEN]), LoadError> {
        let readings = self.read(flash);
        let chosen = choose(&readings);
        self.note(chosen);
        let Some((index, header)) = chosen else { return Err(why_nothing(&readings)) };
        let [first, second] = &readings;
        let (counts, other) = if index == 0 { (first, second) } else { (second, first) };
        // Failing to finish is no harm: the image counts as it stands, and the next store tries again.
        let _ = self.settle(flash, counts, other);
        Ok((header, counts.image))
    }

    /// Begins to replace the image by one that is made for the next sequence number. The flash must not be busy the first
    /// time.
    pub fn begin<F: NorFlash, S: Source>(
        &mut self,
        flash: &mut F,
        source: impl FnOnce(u32) -> S,
    ) -> Replacement<S, LEN> {
        let Counting { index, sequence } = self.counting(flash);
        let (target, old) = self.target_and_old(index);
        Replacement::new(source(sequence.wrapping_add(1)), target, old)
    }

    /// Goes on with what [`begin`](Self::begin) has begun; true when all is done.
    ///
    /// # Errors
    /// As of [`Replacement::go_on`].
    pub fn go_on<F: PageFlash, S: Source>(
        &mut self,
        flash: &mut F,
        replacement: &mut Replacement<S, LEN>,
    ) -> Result<bool, PageError> {
        let progress = replacement.go_on(flash)?;
        if let (Progress::Counts, Some(counting)) = (progress, &mut self.counting) {
            *counting = Counting { index: 1 - counting.index, sequence: counting.sequence.wrapping_add(1) };
        }
        Ok(progress == Progress::Done)
    }

    /// Begins to erase both pages. The flash must not be busy the first time.
    pub fn begin_erasure<F: NorFlash>(&mut self, flash: &mut F) -> Erasure<LEN> {
        let index = self.counting(flash).index;
        let (other, counts) = self.target_and_old(index);
        Erasure::new(other, counts)
    }

    /// Goes on with what [`begin_erasure`](Self::begin_erasure) has begun; true when all is done.
    ///
    /// # Errors
    /// As of [`Erasure::go_on`].
    pub fn go_on_erasing<F: PageFlash>(
        &mut self,
        flash: &mut F,
        erasure: &mut Erasure<LEN>,
    ) -> Result<bool, PageError> {
        let is_done = erasure.go_on(flash)?;
        if is_done {
            self.counting = Some(Counting::NONE);
        }
        Ok(is_done)
    }

    /// Replaces the image and waits until it is done.
    ///
    /// # Errors
    /// [`StoreError`].
    pub fn store<F: PageFlash, S: Source>(
        &mut self,
        flash: &mut F,
        source: impl FnOnce(u32) -> S,
    ) -> Result<(), StoreError> {
        let mut replacement = self.begin(flash, source);
        while !self.go_on(flash, &mut replacement)? {}
        Ok(())
    }

    /// Erases both pages and waits until it is done.
    ///
    /// # Errors
    /// [`StoreError`].
    pub fn erase<F: PageFlash>(&mut self, flash: &mut F) -> Result<(), StoreError> {
        let mut erasure = self.begin_erasure(flash);
        while !self.go_on_erasing(flash, &mut erasure)? {}
        Ok(())
    }

    /// The page that counts. It is looked for only once: reading two pages takes longer than a step may.
    fn counting<F: NorFlash>(&mut self, flash: &mut F) -> Counting {
        if self.counting.is_none() {
            self.look(flash);
        }
        self.counting.unwrap_or(Counting::NONE)
    }

    fn look<F: NorFlash>(&mut self, flash: &mut F) {
        let chosen = choose(&self.read(flash));
        self.note(chosen);
    }

    fn note(&mut self, chosen: Option<(usize, Header)>) {
        let counting = chosen.map(|(index, header)| Counting { index, sequence: header.sequence });
        self.counting = Some(counting.unwrap_or(Counting::NONE));
    }

    fn read<F: NorFlash>(&self, flash: &mut F) -> [Reading<LEN>; 2] {
        // `map` would keep each reading three times on the stack: 9 KB (`cargo stack --ways`).
        let [first, second] = &self.pages;
        [first.read(flash), second.read(flash)]
    }

    /// Brings the pages to rest: the image that counts committed, and the other page erased.
    fn settle<F: PageFlash>(
        &mut self,
        flash: &mut F,
        counts: &Reading<LEN>,
        other: &Reading<LEN>,
    ) -> Result<(), StoreError> {
        match (counts.committed, other.content) {
            (true, Content::Blank) => Ok(()),
            (true, _) => {
                let index = self.counting(flash).index;
                let (page, _) = self.target_and_old(index);
                page.start_erase(flash)?;
                Ok(wait(flash).map_err(|_| PageError::EraseRefused)?)
            }
            // Some word of it may be torn and have read rightly just this once.
            (false, _) => {
                let image = counts.image;
                self.store(flash, |_| image)
            }
        }
    }

    /// The page that is written next, and the page `index`, which counts.
    fn target_and_old(&self, index: usize) -> (Page<LEN>, Page<LEN>) {
        let [first, second] = self.pages;
        if index == 0 { (second, first) } else { (first, second) }
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
