//! Both pages on their way to being blank, a step at a time: the one that does not count first.

use super::flash::PageFlash;
use super::page::{Page, PageError};

/// The erasure of two pages.
#[derive(Debug)]
pub(super) struct Erasure<const LEN: usize> {
    /// The page under way, and what is left after it.
    pages: [Option<Page<LEN>>; 2],
    /// Bytes of its image's place that were found blank; None until its erase is started.
    blank: Option<usize>,
}

impl<const LEN: usize> Erasure<LEN> {
    /// Of both pages, in this order.
    pub const fn new(first: Page<LEN>, second: Page<LEN>) -> Self {
        Self { pages: [Some(first), Some(second)], blank: None }
    }

    /// Does the next step; true when both are blank.
    ///
    /// # Errors
    /// [`PageError::EraseRefused`] and [`PageError::EraseIncomplete`].
    pub fn go_on<F: PageFlash>(&mut self, flash: &mut F) -> Result<bool, PageError> {
        match flash.is_busy() {
            Ok(true) => return Ok(false),
            Ok(false) => {}
            Err(_) if self.blank.is_none() => {}
            Err(_) => return Err(PageError::EraseRefused),
        }
        let [Some(page), next] = self.pages else { return Ok(true) };
        self.blank = match self.blank {
            None => {
                page.start_erase(flash)?;
                Some(0)
            }
            Some(at) => {
                page.check_erased(flash, at)?;
                Page::<LEN>::next_piece(at)
            }
        };
        if self.blank.is_none() {
            self.pages = [next, None];
        }
        Ok(false)
    }
}
