//! Input that cannot be read, and where it stands.

use std::error::Error;
use std::fmt;
use std::path::Path;

/// A place in a text file. Lines count from 1.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file as the user called it.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column, from 1: of a log the column of the table, of a rig file the character in the line.
    pub column: usize,
}

/// Why a file cannot be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum InputError {
    /// The file itself cannot be read.
    File {
        /// The file as the user called it.
        file: String,
        /// What the operating system says.
        message: String,
    },
    /// What stands at a place in the file cannot be.
    At {
        /// Where.
        place: Place,
        /// What is wrong with it, in words.
        message: String,
    },
    /// What was asked for does not exist.
    Request(String),
}

impl InputError {
    /// An error at a place of a file.
    pub fn at(file: &str, line: usize, column: usize, message: impl Into<String>) -> Self {
        Self::At { place: Place { file: file.to_owned(), line, column }, message: message.into() }
    }
}

impl fmt::Display for InputError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File { file, message } => write!(out, "{file}: {message}"),
            Self::At { place: Place { file, line, column }, message } => {
                write!(out, "{file}, line {line}, column {column}: {message}")
            }
            Self::Request(message) => out.write_str(message),
        }
    }
}

impl Error for InputError {}

/// The bytes of a file, and its name for messages.
///
/// # Errors
/// [`InputError::File`] with the operating system's words.
pub fn read(path: &Path) -> Result<(String, Vec<u8>), InputError> {
    let file = path.display().to_string();
    match std::fs::read(path) {
        Ok(bytes) => Ok((file, bytes)),
        Err(error) => Err(InputError::File { file, message: error.to_string() }),
    }
}

/// Do two files hold the same bytes? Not where one of them cannot be read: that is said when it is wanted.
pub fn have_same_content(one: &Path, other: &Path) -> bool {
    let length = |path: &Path| std::fs::metadata(path).map(|file| file.len()).ok();
    let content = |path: &Path| std::fs::read(path).ok();
    length(one).is_some() && length(one) == length(other) && content(one).is_some() && content(one) == content(other)
}

/// What stands in a file, fit for a message: quoted, control characters made visible, cut when long.
pub fn quoted(text: &str) -> String {
    const LONGEST: usize = 24;
    if text.chars().count() <= LONGEST {
        format!("{text:?}")
    } else {
        format!("{:?}…", text.chars().take(LONGEST).collect::<String>())
    }
}
