//! Why the board does not run.

use super::{PACKAGE, PROGRAM};
use crate::packages::PackageError;
use std::fmt;
use std::io;
use std::process::ExitStatus;

/// Why the board does not run.
#[derive(Debug)]
pub enum EmulatorError {
    /// The emulator is not installed.
    Missing(PackageError),
    /// It could not be started.
    Start(io::Error),
    /// The file that is to stand for the flash is something else.
    NotARecord(String),
    /// It ended by itself; the texts are its error output and the end of the board's log.
    Ended {
        /// How it ended.
        status: ExitStatus,
        /// What it complained about.
        complaint: String,
    },
    /// The log did not show this text in time.
    Silent(String),
    /// It should have ended, and runs on.
    StillRunning,
    /// A serial line could not be reached.
    Connect(io::Error),
}

impl fmt::Display for EmulatorError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing(error) => write!(f, "`{PROGRAM}` is not on PATH (Debian's package {PACKAGE}): {error}"),
            Self::NotARecord(what) => f.write_str(what),
            Self::Start(error) => write!(f, "`{PROGRAM}` could not be started: {error}"),
            Self::Ended { status, complaint } => write!(f, "the emulator ended ({status}): {complaint}"),
            Self::Silent(text) => write!(f, "the board did not log \"{text}\" in time"),
            Self::StillRunning => write!(f, "the emulator did not end in time"),
            Self::Connect(error) => write!(f, "a serial line of the board could not be reached: {error}"),
        }
    }
}

impl std::error::Error for EmulatorError {}
