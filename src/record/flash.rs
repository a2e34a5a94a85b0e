//! What the storage asks of a flash.

use embedded_storage::nor_flash::NorFlash;

/// A flash whose pages are erased and whose words are written while the program goes on, if it can do that. One that
/// cannot takes the defaults: its work is done when the call returns.
pub trait PageFlash: NorFlash {
    /// Starts to erase the page that begins at the byte `from`.
    ///
    /// # Errors
    /// The flash refuses.
    fn start_erase(&mut self, from: u32) -> Result<(), Self::Error> {
        self.erase(from, from + Self::ERASE_SIZE as u32)
    }

    /// Starts to write one word, [`WRITE_SIZE`](NorFlash::WRITE_SIZE) bytes, at the byte `at`.
    ///
    /// # Errors
    /// The flash refuses.
    fn start_write(&mut self, at: u32, word: &[u8]) -> Result<(), Self::Error> {
        self.write(at, word)
    }

    /// What was started is still going on. Until it is over nothing may be read or started.
    ///
    /// # Errors
    /// It went wrong.
    fn is_busy(&mut self) -> Result<bool, Self::Error> {
        Ok(false)
    }
}

impl<F: PageFlash> PageFlash for &mut F {
    fn start_erase(&mut self, from: u32) -> Result<(), Self::Error> {
        F::start_erase(self, from)
    }

    fn start_write(&mut self, at: u32, word: &[u8]) -> Result<(), Self::Error> {
        F::start_write(self, at, word)
    }

    fn is_busy(&mut self) -> Result<bool, Self::Error> {
        F::is_busy(self)
    }
}

/// Waits until what was started is over.
pub(super) fn wait<F: PageFlash>(flash: &mut F) -> Result<(), F::Error> {
    while flash.is_busy()? {}
    Ok(())
}
