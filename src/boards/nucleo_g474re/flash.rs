//! The record's flash: the second bank of the chip's own, while the program runs on in the first.

use core::ptr;
use core::sync::atomic::{AtomicBool, Ordering};

use cortex_m::asm;
use embassy_stm32::Peri;
use embassy_stm32::flash::{Blocking, Flash};
use embassy_stm32::{pac, peripherals};
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};
use glenoid::drive_board::LayoutError;
use glenoid::drive_board::flash_layout::{FLASH_LEN, FLASH_ORIGIN, PAGE_LEN, WORD_LEN, record_offset};

unsafe extern "C" {
    /// First address of the record (`memory.x`).
    static _record_start: u8;
    /// First address behind it.
    static _record_end: u8;
}

/// Where the chip says how large its flash is, KiB (RM0440, 47.2).
const SIZE_ADDRESS: usize = 0x1FFF_75E0;

/// A word that was just read could not be corrected.
static BAD_WORD: AtomicBool = AtomicBool::new(false);

/// Called by the non-maskable interrupt: a word of the second bank could not be corrected.
pub fn note_bad_word() {
    BAD_WORD.store(true, Ordering::Relaxed);
}

/// The chip's flash.
pub struct ChipFlash(Flash<'static, Blocking>);

impl ChipFlash {
    /// The flash, and the place of the record in it, if the flash is divided as this firmware expects.
    ///
    /// # Errors
    /// [`LayoutError`].
    pub fn open(flash: Peri<'static, peripherals::FLASH>) -> Result<(Self, u32), LayoutError> {
        // SAFETY: a constant of the chip, in its read-only memory.
        let size_kib = unsafe { ptr::read_volatile(ptr::with_exposed_provenance::<u16>(SIZE_ADDRESS)) };
        let record = ((&raw const _record_start).addr() as u32, (&raw const _record_end).addr() as u32);
        let offset = record_offset(pac::FLASH.optr().read().0, size_kib, record)?;
        Ok((Self(Flash::new_blocking(flash)), offset))
    }
}

/// Why the flash did not serve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FlashError {
    /// Bad arguments.
    Arguments(NorFlashErrorKind),
    /// The controller refused: the page is protected, or the word is not erased.
    Refused,
}

impl NorFlashError for FlashError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::Arguments(kind) => *kind,
            Self::Refused => NorFlashErrorKind::Other,
        }
    }
}

impl ErrorType for ChipFlash {
    type Error = FlashError;
}

impl ReadNorFlash for ChipFlash {
    const READ_SIZE: usize = WORD_LEN;

    /// A word that cannot be corrected reads as zeros, and never as an error: the record's checksum refuses it, and the
    /// other page is still looked at.
    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        check_read(&*self, offset, bytes.len()).map_err(FlashError::Arguments)?;
        let from = (FLASH_ORIGIN + offset) as usize;
        for (address, place) in (from..).step_by(WORD_LEN).zip(bytes.as_chunks_mut::<WORD_LEN>().0) {
            *place = read_word(address);
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        FLASH_LEN as usize
    }
}

/// Reads one word, the unit that the error-correcting code covers. The interrupt strikes between the load and the
/// barriers.
fn read_word(address: usize) -> [u8; WORD_LEN] {
    BAD_WORD.store(false, Ordering::Relaxed);
    // SAFETY: the caller has checked that the word lies within the flash.
    let word = unsafe { ptr::read_volatile(ptr::with_exposed_provenance::<u64>(address)) };
    asm::dsb();
    asm::isb();
    if BAD_WORD.load(Ordering::Relaxed) { [0; WORD_LEN] } else { word.to_le_bytes() }
}

impl NorFlash for ChipFlash {
    const WRITE_SIZE: usize = WORD_LEN;
    const ERASE_SIZE: usize = PAGE_LEN as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        check_erase(&*self, from, to).map_err(FlashError::Arguments)?;
        self.0.blocking_erase(from, to).map_err(|_| FlashError::Refused)
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        check_write(&*self, offset, bytes.len()).map_err(FlashError::Arguments)?;
        self.0.blocking_write(offset, bytes).map_err(|_| FlashError::Refused)
    }
}
