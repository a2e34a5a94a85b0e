//! A new image on its way into one of two pages, a step at a time, so that nobody waits for an erase.

use super::flash::PageFlash;
use super::page::{PIECE, Page, PageError};
use super::sealed::{CRC_LEN, Seal};

/// What is written: the bytes of an image but for its CRC, which is formed on the way.
pub(super) trait Source {
    /// Puts the bytes from `at` on into `place`.
    fn put(&self, at: usize, place: &mut [u8]);
}

impl<const LEN: usize> Source for [u8; LEN] {
    fn put(&self, at: usize, place: &mut [u8]) {
        if let Some(bytes) = self.get(at..at + place.len()) {
            place.copy_from_slice(bytes);
        }
    }
}

/// What is done next, once the flash is not busy with what was started last. Where there is a number, it counts the bytes
/// of the image that are done with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Step {
    /// The page that does not hold the old image is to be erased.
    Erase,
    /// It should be blank.
    CheckErased(usize),
    /// The next word is to be written.
    Write(usize),
    /// The image should be there.
    CheckWritten(usize),
    /// It is to be committed.
    Commit,
    /// The commit word should be there; the page of the old image is to be erased.
    EraseOld,
    /// All is done.
    Done,
}

/// How far it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Progress {
    /// It goes on.
    Going,
    /// The new image counts from now on.
    Counts,
    /// All is done.
    Done,
}

/// The replacement of the image in one page by a new one in the other.
#[derive(Debug)]
pub(super) struct Replacement<S, const LEN: usize> {
    source: S,
    target: Page<LEN>,
    old: Page<LEN>,
    seal: Seal,
    step: Step,
}

impl<S: Source, const LEN: usize> Replacement<S, LEN> {
    /// The new image is to be written to `target`; `old` is erased afterwards.
    pub fn new(source: S, target: Page<LEN>, old: Page<LEN>) -> Self {
        Self { source, target, old, seal: Seal::new(), step: Step::Erase }
    }

    /// Does the next step, which takes no longer than writing a word. At every instant one page holds an image that nothing
    /// is being done to.
    ///
    /// # Errors
    /// [`PageError`] says which step failed.
    pub fn go_on<F: PageFlash>(&mut self, flash: &mut F) -> Result<Progress, PageError> {
        match (flash.is_busy(), self.step) {
            (Ok(true), _) => return Ok(Progress::Going),
            // An error before the first step is not of this replacement's making. In the end the new image counts, and the old
            // one must not outlive it: the next store will need its page, and tell.
            (Ok(false), _) | (Err(_), Step::Erase | Step::Done) => {}
            (Err(_), Step::CheckErased(_)) => return Err(PageError::EraseRefused),
            (Err(_), _) => return Err(PageError::WriteRefused),
        }
        self.step = match self.step {
            Step::Erase => {
                self.target.start_erase(flash)?;
                Step::CheckErased(0)
            }
            Step::CheckErased(at) => {
                self.target.check_erased(flash, at)?;
                Page::<LEN>::next_piece(at).map_or(Step::Write(0), Step::CheckErased)
            }
            Step::Write(at) => {
                self.start_word(flash, at)?;
                let next = at + F::WRITE_SIZE;
                if next < LEN { Step::Write(next) } else { Step::CheckWritten(0) }
            }
            Step::CheckWritten(at) => {
                self.check_written(flash, at)?;
                Page::<LEN>::next_piece(at).map_or(Step::Commit, Step::CheckWritten)
            }
            Step::Commit => {
                self.target.start_commit(flash)?;
                Step::EraseOld
            }
            Step::EraseOld => {
                self.target.check_committed(flash)?;
                let _ = self.old.start_erase(flash);
                self.step = Step::Done;
                return Ok(Progress::Counts);
            }
            Step::Done => return Ok(Progress::Done),
        };
        Ok(Progress::Going)
    }

    /// It waits for nothing that takes milliseconds.
    pub const fn is_quick(&self) -> bool {
        !matches!(self.step, Step::CheckErased(0) | Step::Done)
    }

    fn start_word<F: PageFlash>(&mut self, flash: &mut F, at: usize) -> Result<(), PageError> {
        let mut word = [0; PIECE];
        let word = word.get_mut(..F::WRITE_SIZE).unwrap_or_default();
        self.source.put(at, word);
        let sealed = if at + F::WRITE_SIZE < LEN { F::WRITE_SIZE } else { F::WRITE_SIZE.saturating_sub(CRC_LEN) };
        self.seal.add(word.get(..sealed).unwrap_or_default());
        self.put_sum(at, word);
        self.target.start_word(flash, at, word)
    }

    fn check_written<F: PageFlash>(&self, flash: &mut F, at: usize) -> Result<(), PageError> {
        let is_same = self.target.holds(flash, at, |at, read| {
            let mut piece = [0; PIECE];
            let piece = piece.get_mut(..read.len()).unwrap_or_default();
            self.source.put(at, piece);
            self.put_sum(at, piece);
            *read == *piece
        });
        if is_same { Ok(()) } else { Err(PageError::ReadBackDiffers) }
    }

    /// Puts the CRC where the image ends, if it ends in this place.
    fn put_sum(&self, at: usize, place: &mut [u8]) {
        if at + place.len() == LEN
            && let Some(sum) = place.last_chunk_mut()
        {
            *sum = self.seal.sum().to_le_bytes();
        }
    }
}
