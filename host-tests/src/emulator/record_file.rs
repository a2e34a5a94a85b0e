//! The file that stands for the board's flash.

use super::EmulatorError;
use crate::flash::PAGE_LEN;
use glenoid::record::STORAGE_PAGES;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// The file that stands for the flash.
#[derive(Debug)]
pub enum RecordFile {
    /// Somebody else's, which stays.
    Given(PathBuf),
    /// This board's, which goes with it.
    Own(PathBuf),
}

impl RecordFile {
    /// The given file, or one of this board's own.
    ///
    /// # Errors
    /// [`EmulatorError::NotARecord`].
    pub fn at(path: Option<&Path>) -> Result<Self, EmulatorError> {
        match path {
            Some(path) => {
                refuse_what_is_no_record(path)?;
                Ok(Self::Given(path.to_owned()))
            }
            None => Ok(Self::Own(own_record())),
        }
    }

    /// Where it lies.
    pub fn path(&self) -> &Path {
        let (Self::Given(path) | Self::Own(path)) = self;
        path
    }

    /// The emulator's option that tells the firmware the board's serial number and the path. A comma would end the path, so
    /// it is doubled.
    pub fn semihosting(&self, serial: u32) -> OsString {
        let path = self.path().to_string_lossy().replace(',', ",,");
        format!("enable=on,target=native,arg=firmware,arg=serial={serial},arg=record={path}").into()
    }
}

/// The board erases and writes this file: one that is there and is no record is somebody's.
fn refuse_what_is_no_record(path: &Path) -> Result<(), EmulatorError> {
    const LEN: u64 = (STORAGE_PAGES * PAGE_LEN) as u64;
    match std::fs::metadata(path) {
        Ok(file) if file.is_file() && [0, LEN].contains(&file.len()) => Ok(()),
        // The board can do nothing to a folder: a flash that refuses everything.
        Ok(file) if file.is_dir() => Ok(()),
        Ok(file) => Err(EmulatorError::NotARecord(format!(
            "{} is no record of the board: it has {} bytes, not {LEN}; it stays as it is",
            path.display(),
            file.len()
        ))),
        // it will be made
        Err(_) => Ok(()),
    }
}

/// A path that no other board of this machine has.
fn own_record() -> PathBuf {
    static NEXT: AtomicU32 = AtomicU32::new(0);
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    std::env::temp_dir().join(format!("glenoid-record-{}-{number}", std::process::id()))
}

impl Drop for RecordFile {
    fn drop(&mut self) {
        if let Self::Own(path) = self {
            let _ = std::fs::remove_file(path);
        }
    }
}
