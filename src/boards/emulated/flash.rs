//! The record's flash: a file of the host, by semihosting, with the words and pages of the drive board's.
//!
//! The emulator gets the file's path on its command line (`-semihosting-config arg=record=PATH`). It has no flash that
//! keeps what is written to it, and no power to cut; what a power cut does is tested on the host.

use cortex_m_semihosting::{nr, syscall};
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};
use glenoid::record::{PageFlash, STORAGE_PAGES};

use super::command_line::CommandLine;

/// Bytes of a page, as on the drive board.
const PAGE_LEN: usize = 2048;
/// Bytes of a word, as on the drive board.
const WORD_LEN: usize = 8;
/// The pages of the storage.
const LEN: usize = STORAGE_PAGES * PAGE_LEN;

/// What stands before the path, which goes on to the end of the line.
const KEY: &[u8] = b"record=";

/// What erased flash reads as.
const ERASED: u8 = 0xFF;

/// Why the file did not serve as flash.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileError {
    /// The emulator's command line has no path.
    NoPath,
    /// The host refused.
    Host,
    /// A word that is not erased was to be written.
    NotErased,
    /// Bad arguments.
    Arguments(NorFlashErrorKind),
}

impl NorFlashError for FileError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::Arguments(kind) => *kind,
            _ => NorFlashErrorKind::Other,
        }
    }
}

/// The open file.
#[derive(Debug)]
pub struct FileFlash {
    file: Result<usize, FileError>,
}

impl FileFlash {
    /// Opens the file, and makes it, erased, where there is none. Without a file every access fails: such a board cannot
    /// keep anything, and says so.
    pub fn open() -> Self {
        let line = CommandLine::read();
        let mut flash = Self { file: line.as_ref().ok_or(FileError::NoPath).and_then(path).and_then(open) };
        match flash.len() {
            Some(0) => drop(flash.erase_all()),
            Some(LEN) | None => {}
            // somebody's file: it stays as it is
            Some(_) => flash.file = Err(FileError::Host),
        }
        flash
    }

    fn len(&self) -> Option<usize> {
        // SAFETY: takes a file handle, touches no memory of ours.
        self.file.ok().map(|file| unsafe { syscall!(FLEN, file) })
    }

    fn erase_all(&mut self) -> Result<(), FileError> {
        (0..STORAGE_PAGES).try_for_each(|page| self.put(page * PAGE_LEN, &[ERASED; PAGE_LEN]))
    }

    fn put(&mut self, from: usize, bytes: &[u8]) -> Result<(), FileError> {
        let file = self.seek(from)?;
        // SAFETY: the host reads within `bytes` only.
        let left_over = unsafe { syscall!(WRITE, file, bytes.as_ptr(), bytes.len()) };
        if left_over == 0 { Ok(()) } else { Err(FileError::Host) }
    }

    fn seek(&mut self, to: usize) -> Result<usize, FileError> {
        let file = self.file?;
        // SAFETY: takes a file handle, touches no memory of ours.
        let failed = unsafe { syscall!(SEEK, file, to) } != 0;
        if failed { Err(FileError::Host) } else { Ok(file) }
    }
}

/// The path in the emulator's command line, with a zero behind it.
fn path(line: &CommandLine) -> Result<&[u8], FileError> {
    match line.after(KEY) {
        Some(path @ [_, .., 0]) => Ok(path),
        _ => Err(FileError::NoPath),
    }
}

/// Opens the file for reading and writing; makes it where there is none.
fn open(path: &[u8]) -> Result<usize, FileError> {
    let try_to = |mode: usize| {
        // SAFETY: the host reads `path` up to its zero, which is not counted.
        let file = unsafe { syscall!(OPEN, path.as_ptr(), mode, path.len() - 1) };
        // the host says -1 when it could not
        if file == usize::MAX { Err(FileError::Host) } else { Ok(file) }
    };
    try_to(nr::open::RW_BINARY).or_else(|_| try_to(nr::open::RW_TRUNC_BINARY))
}

impl ErrorType for FileFlash {
    type Error = FileError;
}

impl ReadNorFlash for FileFlash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FileError> {
        check_read(self, offset, bytes.len()).map_err(FileError::Arguments)?;
        let file = self.seek(offset as usize)?;
        // SAFETY: the host writes within `bytes` only, which are borrowed mutably.
        let left_over = unsafe { syscall!(READ, file, bytes.as_mut_ptr(), bytes.len()) };
        if left_over == 0 { Ok(()) } else { Err(FileError::Host) }
    }

    fn capacity(&self) -> usize {
        LEN
    }
}

impl NorFlash for FileFlash {
    const WRITE_SIZE: usize = WORD_LEN;
    const ERASE_SIZE: usize = PAGE_LEN;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), FileError> {
        check_erase(self, from, to).map_err(FileError::Arguments)?;
        (from as usize..to as usize).step_by(PAGE_LEN).try_for_each(|page| self.put(page, &[ERASED; PAGE_LEN]))
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FileError> {
        check_write(self, offset, bytes.len()).map_err(FileError::Arguments)?;
        for (at, word) in (offset..).step_by(WORD_LEN).zip(bytes.as_chunks::<WORD_LEN>().0) {
            let mut before = [0; WORD_LEN];
            self.read(at, &mut before)?;
            if before != [ERASED; WORD_LEN] {
                return Err(FileError::NotErased);
            }
            self.put(at as usize, word)?;
        }
        Ok(())
    }
}

/// Its work is done when the call returns.
impl PageFlash for FileFlash {}
