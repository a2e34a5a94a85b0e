//! A new record on its way into the flash, a step at a time, so that nobody waits for an erase.

use super::content::Record;
use super::flash::PageFlash;
use super::image::{self, Image};
use super::page::{Page, PageError};

/// What is done next, once the flash is not busy with what was done last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Step {
    /// The page that does not hold the record is to be erased.
    Erase,
    /// It should be blank now, and is written from the byte given on.
    Write(usize),
    /// The image should be there, and is committed.
    Commit,
    /// The commit word should be there; the page of the old record is to be erased.
    EraseOld,
    /// All is done.
    Done,
}

/// The replacement of the record in one page by a new one in the other.
#[derive(Debug)]
pub(super) struct Replacement {
    target: Page,
    old: Page,
    image: Image,
    step: Step,
}

impl Replacement {
    /// The new record is to be written to `target`; `old` is erased afterwards.
    pub fn of_record(record: &Record, sequence: u32, target: Page, old: Page) -> Self {
        Self::of_image(image::encode(record, sequence), target, old)
    }

    /// As above, for a record that is packed.
    pub fn of_image(image: Image, target: Page, old: Page) -> Self {
        Self { target, old, image, step: Step::Erase }
    }

    /// Does the next step; true when there is none. At every instant one page holds a record that nothing is being done to.
    pub fn go_on<F: PageFlash>(&mut self, flash: &mut F) -> Result<bool, PageError> {
        match flash.is_busy() {
            Ok(true) => return Ok(false),
            Ok(false) => {}
            // The new record counts by now. The old one must not outlive it; the next store will need its page and tell.
            Err(_) if self.step == Step::Done => return Ok(true),
            Err(_) if matches!(self.step, Step::Write(0)) => return Err(PageError::EraseRefused),
            Err(_) => return Err(PageError::WriteRefused),
        }
        self.step = match self.step {
            Step::Erase => {
                self.target.start_erase(flash)?;
                Step::Write(0)
            }
            Step::Write(at) => {
                if at == 0 {
                    self.target.check_erased(flash)?;
                }
                let is_written = !self.target.start_word(flash, &self.image, at)?;
                if is_written { Step::Commit } else { Step::Write(at + F::WRITE_SIZE) }
            }
            Step::Commit => {
                self.target.check_written(flash, &self.image)?;
                self.target.start_commit(flash)?;
                Step::EraseOld
            }
            Step::EraseOld => {
                self.target.check_committed(flash)?;
                let _ = self.old.start_erase(flash);
                Step::Done
            }
            Step::Done => return Ok(true),
        };
        Ok(false)
    }
}
