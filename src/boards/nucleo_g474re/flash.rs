//! The record's flash: the second bank of the chip's own, while the program runs on in the first.

use core::ptr;
use core::sync::atomic::{AtomicBool, Ordering};

use cortex_m::asm;
use embassy_stm32::Peri;
use embassy_stm32::{pac, peripherals};
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};
use glenoid::drive_board::LayoutError;
use glenoid::drive_board::flash_layout::{BANK_2_FROM, FLASH_LEN, FLASH_ORIGIN, PAGE_LEN, WORD_LEN, record_offset};
use glenoid::record::PageFlash;

unsafe extern "C" {
    /// First address of the record (`memory.x`).
    static _record_start: u8;
    /// First address behind it.
    static _record_end: u8;
}

/// What unlocks the controller, in this order (RM0440: FLASH_KEYR).
const KEYS: [u32; 2] = [0x4567_0123, 0xCDEF_89AB];
/// FLASH_SR: whatever says that the work was not done (RM0440: OPERR, PROGERR, WRPERR, PGAERR, SIZERR, PGSERR).
const ERRORS: u32 = 0b1111_1010;

/// Where the chip says how large its flash is, KiB (RM0440, 47.2).
const SIZE_ADDRESS: usize = 0x1FFF_75E0;

/// A word that was just read could not be corrected.
static BAD_WORD: AtomicBool = AtomicBool::new(false);

/// Called by the non-maskable interrupt: a word of the second bank could not be corrected.
pub fn note_bad_word() {
    BAD_WORD.store(true, Ordering::Relaxed);
}

/// The chip's flash. Its controller is driven here: the driver's functions return when the work is done, and an erase takes
/// 22 ms.
pub struct ChipFlash {
    _controller: Peri<'static, peripherals::FLASH>,
}

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
        Ok((Self { _controller: flash }, offset))
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
        for page in (from..to).step_by(Self::ERASE_SIZE) {
            self.start_erase(page)?;
            while self.is_busy()? {}
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        check_write(&*self, offset, bytes.len()).map_err(FlashError::Arguments)?;
        for (at, word) in (offset..).step_by(WORD_LEN).zip(bytes.chunks(WORD_LEN)) {
            self.start_write(at, word)?;
            while self.is_busy()? {}
        }
        Ok(())
    }
}

/// The sequences of RM0440, "Page erase" and "Standard programming". The data cache is off while the flash changes, and
/// empty afterwards.
impl PageFlash for ChipFlash {
    fn start_erase(&mut self, from: u32) -> Result<(), FlashError> {
        check_erase(&*self, from, from + PAGE_LEN).map_err(FlashError::Arguments)?;
        let page = from.checked_sub(BANK_2_FROM).ok_or(FlashError::Refused)? / PAGE_LEN;
        begin();
        pac::FLASH.cr().modify(|w| {
            w.set_per(true);
            w.set_bker(true);
            // the second bank has 128 pages
            w.set_pnb(page as u8);
        });
        pac::FLASH.cr().modify(|w| w.set_strt(true));
        Ok(())
    }

    fn start_write(&mut self, at: u32, word: &[u8]) -> Result<(), FlashError> {
        check_write(&*self, at, word.len()).map_err(FlashError::Arguments)?;
        let Some((low, rest)) = word.split_first_chunk::<4>() else { return Err(FlashError::Refused) };
        let Some((high, [])) = rest.split_first_chunk::<4>() else { return Err(FlashError::Refused) };
        if at < BANK_2_FROM {
            return Err(FlashError::Refused);
        }
        begin();
        pac::FLASH.cr().modify(|w| w.set_pg(true));
        let address = (FLASH_ORIGIN + at) as usize;
        for (address, half) in [(address, low), (address + 4, high)] {
            // SAFETY: the word lies within the second bank, where nothing of the program does; the controller is set to
            // programming.
            unsafe { ptr::write_volatile(ptr::with_exposed_provenance_mut(address), u32::from_le_bytes(*half)) };
        }
        Ok(())
    }

    fn is_busy(&mut self) -> Result<bool, FlashError> {
        let status = pac::FLASH.sr().read();
        if status.bsy() {
            return Ok(true);
        }
        if !pac::FLASH.cr().read().lock() {
            end();
        }
        let failed = status.0 & ERRORS != 0;
        if failed { Err(FlashError::Refused) } else { Ok(false) }
    }
}

/// Makes the controller ready for one piece of work: the errors of the last one cleared, the cache off, unlocked.
fn begin() {
    // written back, the flags that are set are cleared
    pac::FLASH.sr().modify(|_| {});
    pac::FLASH.acr().modify(|w| w.set_dcen(false));
    if pac::FLASH.cr().read().lock() {
        for key in KEYS {
            pac::FLASH.keyr().write_value(key);
        }
    }
}

/// Locks the controller again, and lets the cache know nothing of what was there before.
fn end() {
    pac::FLASH.cr().modify(|w| {
        w.set_per(false);
        w.set_pg(false);
    });
    pac::FLASH.cr().modify(|w| w.set_lock(true));
    pac::FLASH.acr().modify(|w| w.set_dcrst(true));
    pac::FLASH.acr().modify(|w| w.set_dcrst(false));
    pac::FLASH.acr().modify(|w| w.set_dcen(true));
}
