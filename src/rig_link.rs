//! The rig link of the emulated board: what the wires would bring, as lines of text.
//!
//! ASCII lines, each ended by a line feed: `e c1 c2 c3 c4 c5 c6` gives the six encoder counts (signed decimal),
//! `b 1` and `b 0` the button down and up. Anything else is refused with its reason and otherwise ignored. The link
//! carries nothing that wires would not.

use crate::line::LineBuffer;

/// Encoders on the rig, one a cable.
pub const ENCODERS: usize = 6;

/// Longest line: the letter, and for each encoder a space, a sign and ten digits.
const LONGEST_LINE: usize = 1 + ENCODERS * 12;

/// Why a line is ignored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum RigLinkError {
    /// More characters than six counts can have.
    LineTooLong = 1,
    /// Neither counts nor button.
    UnknownLine = 2,
    /// Fewer or more than six counts.
    WrongNumberOfCounts = 3,
    /// A count that is no decimal number of 32 bits.
    BadCount = 4,
    /// A button level other than 0 and 1.
    BadLevel = 5,
}

impl RigLinkError {
    /// The number that stands for this error in logs. Never renumbered.
    pub const fn code(self) -> u8 {
        self as u8
    }
}

impl core::fmt::Display for RigLinkError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::LineTooLong => "line longer than six counts",
            Self::UnknownLine => "neither counts nor button",
            Self::WrongNumberOfCounts => "not six counts",
            Self::BadCount => "a count is no 32-bit decimal number",
            Self::BadLevel => "a button level is 0 or 1",
        })
    }
}

impl core::error::Error for RigLinkError {}

/// A change on the wires of the rig.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Signal {
    /// The six encoder counters, L1 to L6.
    Counts([i32; ENCODERS]),
    /// The button's level.
    Button {
        /// Pressed.
        down: bool,
    },
}

/// Understands one line, given without its line feed.
///
/// # Errors
/// Every [`RigLinkError`].
pub fn parse(line: &[u8]) -> Result<Signal, RigLinkError> {
    if line.len() > LONGEST_LINE {
        return Err(RigLinkError::LineTooLong);
    }
    match line {
        [b'e', b' ', counts @ ..] => parse_counts(counts),
        [b'e'] => Err(RigLinkError::WrongNumberOfCounts),
        [b'b', b' ', b'0'] => Ok(Signal::Button { down: false }),
        [b'b', b' ', b'1'] => Ok(Signal::Button { down: true }),
        [b'b', b' ', ..] | [b'b'] => Err(RigLinkError::BadLevel),
        _ => Err(RigLinkError::UnknownLine),
    }
}

fn parse_counts(text: &[u8]) -> Result<Signal, RigLinkError> {
    let mut counts = [0; ENCODERS];
    let mut fields = text.split(|&byte| byte == b' ');
    for count in &mut counts {
        let field = fields.next().ok_or(RigLinkError::WrongNumberOfCounts)?;
        *count =
            core::str::from_utf8(field).ok().and_then(|digits| digits.parse().ok()).ok_or(RigLinkError::BadCount)?;
    }
    match fields.next() {
        None => Ok(Signal::Counts(counts)),
        Some(_) => Err(RigLinkError::WrongNumberOfCounts),
    }
}

/// Signals out of a stream of bytes.
#[derive(Debug, Clone, Default)]
pub struct RigLink {
    line: LineBuffer<LONGEST_LINE, b'\n'>,
    refused: u32,
}

impl RigLink {
    /// A link at the start of a line.
    pub const fn new() -> Self {
        Self { line: LineBuffer::new(), refused: 0 }
    }

    /// Takes one byte; a signal or a refusal comes out at the end of each line. Carriage returns are skipped.
    ///
    /// # Errors
    /// As [`parse`], once for each bad line. The line after it is read cleanly.
    pub fn push(&mut self, byte: u8) -> Option<Result<Signal, RigLinkError>> {
        let line = self.line.push(byte)?;
        let signal = line.map_err(|_| RigLinkError::LineTooLong).and_then(parse);
        if signal.is_err() {
            self.refused = self.refused.wrapping_add(1);
        }
        Some(signal)
    }

    /// Lines refused since power-up. Wraps.
    pub fn refused(&self) -> u32 {
        self.refused
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    #[test]
    fn counts_of_either_sign_and_at_the_limits() {
        assert_eq!(
            parse(b"e 0 -1 2147483647 -2147483648 42 007"),
            Ok(Signal::Counts([0, -1, i32::MAX, i32::MIN, 42, 7]))
        );
    }

    #[test]
    fn the_longest_line_passes_the_buffer() {
        let mut link = RigLink::new();
        let line = b"e -2147483648 -2147483648 -2147483648 -2147483648 -2147483648 -2147483648\r\n";
        let seen: Vec<_> = line.iter().filter_map(|&byte| link.push(byte)).collect();
        assert_eq!(seen, [Ok(Signal::Counts([i32::MIN; 6]))]);
    }

    #[test]
    fn every_refusal_by_its_name() {
        use RigLinkError::*;
        let long = [b'e'; LONGEST_LINE + 1];
        let cases: [(&[u8], RigLinkError); 14] = [
            (&long, LineTooLong),
            (b"", UnknownLine),
            (b"q 1", UnknownLine),
            (b"e1 2 3 4 5 6", UnknownLine),
            (b"e", WrongNumberOfCounts),
            (b"e 1 2 3 4 5", WrongNumberOfCounts),
            (b"e 1 2 3 4 5 6 7", WrongNumberOfCounts),
            (b"e 1 2 3 4 5 2147483648", BadCount),
            (b"e 1 2 3 4 5 1.5", BadCount),
            (b"e 1  2 3 4 5 6", BadCount),
            (b"e \xFF 2 3 4 5 6", BadCount),
            (b"b", BadLevel),
            (b"b 2", BadLevel),
            (b"b 10", BadLevel),
        ];
        for (line, error) in cases {
            assert_eq!(parse(line), Err(error), "{:?}", core::str::from_utf8(line));
        }
    }

    #[test]
    fn bad_lines_are_counted_and_do_not_spoil_the_next() {
        let mut link = RigLink::new();
        let mut noise = Vec::from([b'x'; 500]);
        noise.extend(b"\nb 3\nb 1\nb 0\n");
        let seen: Vec<_> = noise.iter().filter_map(|&byte| link.push(byte)).collect();
        assert_eq!(
            seen,
            [
                Err(RigLinkError::LineTooLong),
                Err(RigLinkError::BadLevel),
                Ok(Signal::Button { down: true }),
                Ok(Signal::Button { down: false }),
            ]
        );
        assert_eq!(link.refused(), 2);
    }

    #[test]
    fn codes_never_change() {
        use RigLinkError::*;
        let codes = [LineTooLong, UnknownLine, WrongNumberOfCounts, BadCount, BadLevel].map(RigLinkError::code);
        assert_eq!(codes, [1, 2, 3, 4, 5]);
    }
}
