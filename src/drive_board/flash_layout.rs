//! Where the record lies in the chip's flash, whether that flash is what this firmware expects, and what a word of it
//! that could not be corrected means.

use crate::record::STORAGE_PAGES;

/// Where the flash begins.
pub const FLASH_ORIGIN: u32 = 0x0800_0000;
/// Its size (RM0440, 3.3.1: category 3 device, 512 KiB).
pub const FLASH_LEN: u32 = 512 * 1024;
/// Where the second bank begins, from the start of the flash.
pub const BANK_2_FROM: u32 = FLASH_LEN / 2;
/// Bytes of a page while there are two banks; with a single one it would be 4 KiB.
pub const PAGE_LEN: u32 = 2 * 1024;
/// Bytes of the storage: record, journal, parameters.
const STORAGE_LEN: u32 = STORAGE_PAGES as u32 * PAGE_LEN;
/// Bytes that are programmed at once, with their error-correcting code.
pub const WORD_LEN: usize = 8;

/// FLASH_OPTR, bit 20: start from the second bank (RM0440, 3.7.8).
const BOOT_FROM_BANK_2: u32 = 1 << 20;
/// FLASH_OPTR, bit 22: there are two banks.
const DUAL_BANK: u32 = 1 << 22;

/// FLASH_ECCR, bit 21: the error lies in the second bank (RM0440, 3.7.6).
const ECC_IN_BANK_2: u32 = 1 << 21;
/// FLASH_ECCR, bit 22: the error lies in the system memory.
const ECC_IN_SYSTEM: u32 = 1 << 22;
/// FLASH_ECCR, bits 31 and 29: two bits of a word are wrong. (Bit 29 is of the upper half while there is a single bank.)
const ECC_DETECTED: u32 = 1 << 31 | 1 << 29;

/// Why the record cannot be kept in this flash.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum LayoutError {
    /// The option bytes make one bank of the flash (DBANK = 0): pages are twice as long, and an erase stops the program.
    SingleBank = 1,
    /// The option bytes swap the banks (BFB2 = 1): the program would erase its own.
    BanksSwapped = 2,
    /// The chip has another size of flash: it is another chip.
    OtherSize = 3,
    /// The linker placed the record outside of the second bank, or not at a page.
    RecordMisplaced = 4,
}

/// Checks the flash, and gives the place of the record as the distance from the start of the flash, bytes.
///
/// * `optr`: FLASH_OPTR;
/// * `size_kib`: the chip's own statement of its size (RM0440, 47.2);
/// * `record`: first and last-but-one address of the record, from the linker.
///
/// # Errors
/// [`LayoutError`].
pub const fn record_offset(optr: u32, size_kib: u16, record: (u32, u32)) -> Result<u32, LayoutError> {
    if size_kib as u32 * 1024 != FLASH_LEN {
        return Err(LayoutError::OtherSize);
    }
    if optr & DUAL_BANK == 0 {
        return Err(LayoutError::SingleBank);
    }
    if optr & BOOT_FROM_BANK_2 != 0 {
        return Err(LayoutError::BanksSwapped);
    }
    let (from, end) = record;
    let offset = from.wrapping_sub(FLASH_ORIGIN);
    let is_whole = offset.is_multiple_of(PAGE_LEN) && end.wrapping_sub(from) == STORAGE_LEN;
    if is_whole && offset >= BANK_2_FROM && offset <= FLASH_LEN - STORAGE_LEN {
        Ok(offset)
    } else {
        Err(LayoutError::RecordMisplaced)
    }
}

/// What a non-maskable interrupt means, as far as the flash has to do with it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EccVerdict {
    /// It was not the flash.
    NotFlash,
    /// A word of the second bank, where the record lies and nothing else: torn by a power cut, or worn. Whoever reads the
    /// record is reported, and the program goes on.
    RecordWord,
    /// A word of the program, or of the system memory: nothing that is read from there can be trusted.
    ProgramWord,
}

/// The verdict on FLASH_ECCR as the interrupt found it.
pub const fn ecc_verdict(eccr: u32) -> EccVerdict {
    if eccr & ECC_DETECTED == 0 {
        EccVerdict::NotFlash
    } else if eccr & ECC_IN_BANK_2 != 0 && eccr & ECC_IN_SYSTEM == 0 {
        EccVerdict::RecordWord
    } else {
        EccVerdict::ProgramWord
    }
}
