//! Lines out of a byte stream, in bounded memory.

use heapless::Vec;

/// A line had more bytes than its buffer; all of it was dropped, up to and including its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LineTooLong;

/// Collects bytes until `END` (carriage return or line feed) and hands the line out without it.
///
/// The other one of the two is skipped wherever it stands, so a sender that ends its lines with both is understood
/// too. A line longer than `N` bytes is dropped whole and reported once at its end: the next line is read cleanly.
#[derive(Debug, Clone)]
pub struct LineBuffer<const N: usize, const END: u8> {
    bytes: Vec<u8, N>,
    overlong: bool,
    complete: bool,
}

impl<const N: usize, const END: u8> LineBuffer<N, END> {
    /// An empty buffer.
    pub const fn new() -> Self {
        Self { bytes: Vec::new(), overlong: false, complete: false }
    }

    /// Takes one byte. Some at the end of a line, which stays readable until the next byte.
    ///
    /// # Errors
    /// [`LineTooLong`] at the end of a line of more than `N` bytes.
    pub fn push(&mut self, byte: u8) -> Option<Result<&[u8], LineTooLong>> {
        if self.complete {
            self.bytes.clear();
            self.overlong = false;
            self.complete = false;
        }
        match byte {
            end if end == END => {
                self.complete = true;
                Some(if self.overlong { Err(LineTooLong) } else { Ok(&self.bytes) })
            }
            b'\r' | b'\n' => None,
            other => {
                self.overlong |= self.bytes.push(other).is_err();
                None
            }
        }
    }
}

impl<const N: usize, const END: u8> Default for LineBuffer<N, END> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::string::{String, ToString};
    use std::vec::Vec;

    fn lines(input: &[u8]) -> Vec<Option<String>> {
        let mut buffer = LineBuffer::<4, b'\n'>::new();
        let mut seen = Vec::new();
        for &byte in input {
            if let Some(line) = buffer.push(byte) {
                seen.push(line.ok().map(|l| String::from_utf8_lossy(l).to_string()));
            }
        }
        seen
    }

    #[test]
    fn both_line_ends_make_one_line() {
        assert_eq!(lines(b"ab\r\n\ncd\n"), [Some("ab".into()), Some("".into()), Some("cd".into())]);
    }

    #[test]
    fn a_full_line_fits_and_one_byte_more_is_dropped_whole() {
        assert_eq!(lines(b"abcd\nabcde\nf\n"), [Some("abcd".into()), None, Some("f".into())]);
    }

    #[test]
    fn an_unfinished_line_is_not_handed_out() {
        assert!(lines(b"abc").is_empty());
    }
}
