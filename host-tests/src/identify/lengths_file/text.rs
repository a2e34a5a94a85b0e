//! Bytes to text, and text to lines.

use super::InputError;

/// How the characters of a file are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Utf8,
    Utf16,
    /// What an old spreadsheet writes: one byte a character. Digits and signs are the same in all of these.
    Latin1,
}

impl Encoding {
    pub(super) fn note(self) -> Option<String> {
        match self {
            Self::Utf8 => None,
            Self::Utf16 => Some("read as UTF-16".to_owned()),
            Self::Latin1 => Some("the file is not UTF-8; read as Latin-1".to_owned()),
        }
    }
}

/// The text of a file.
pub(super) struct Text {
    pub(super) content: String,
    pub(super) encoding: Encoding,
}

/// The text without its byte order mark.
///
/// # Errors
/// [`InputError`] for half a character of UTF-16.
pub(super) fn decode(file: &str, bytes: &[u8]) -> Result<Text, InputError> {
    match *bytes {
        [0xff, 0xfe, ref rest @ ..] => utf_16(file, rest, u16::from_le_bytes),
        [0xfe, 0xff, ref rest @ ..] => utf_16(file, rest, u16::from_be_bytes),
        // Without a mark, a first character from ASCII gives UTF-16 away.
        [first, 0, ..] if first != 0 => utf_16(file, bytes, u16::from_le_bytes),
        [0, second, ..] if second != 0 => utf_16(file, bytes, u16::from_be_bytes),
        _ => {
            let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
            Ok(match std::str::from_utf8(bytes) {
                Ok(text) => Text { content: text.to_owned(), encoding: Encoding::Utf8 },
                Err(_) => {
                    // The first 256 characters of Unicode are those of Latin-1.
                    Text { content: bytes.iter().copied().map(char::from).collect(), encoding: Encoding::Latin1 }
                }
            })
        }
    }
}

fn utf_16(file: &str, bytes: &[u8], unit: fn([u8; 2]) -> u16) -> Result<Text, InputError> {
    let (pairs, rest) = bytes.as_chunks::<2>();
    let mut content = String::with_capacity(pairs.len());
    for character in char::decode_utf16(pairs.iter().copied().map(unit)) {
        match character {
            Ok(character) => content.push(character),
            Err(_) => return Err(cut(file, &content, "half a character of UTF-16")),
        }
    }
    if rest.is_empty() {
        Ok(Text { content, encoding: Encoding::Utf16 })
    } else {
        Err(cut(file, &content, "UTF-16 with an odd number of bytes: the file was cut"))
    }
}

fn cut(file: &str, before: &str, message: &str) -> InputError {
    let (line, text) = lines(before).last().unwrap_or((1, ""));
    InputError::at(file, line, text.chars().count() + 1, message)
}

/// The lines of a text with their numbers from 1, whether they end in LF, CRLF or (an old spreadsheet's) CR.
pub(super) fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    text.split('\n')
        .flat_map(|line| line.strip_suffix('\r').unwrap_or(line).split('\r'))
        .enumerate()
        .map(|(index, line)| (index + 1, line))
}
