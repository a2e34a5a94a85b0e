//! SLCAN (Lawicel) codec: CAN frames as lines of text over a serial line.
//!
//! Source: Lawicel AB, "CAN232 manual", version 3, and what python-can's `slcan` interface really sends: `C`, `S6`,
//! an empty line, `O`, and `O` once more. Every line ends with a carriage return. The same codec serves both ends:
//! a frame looks the same on its way to the bus and on its way from it.
//!
//! [`Adapter`] is the state machine of the serial-to-CAN adapter on top of it.

mod adapter;

pub use adapter::{Adapter, Counters, Response};

use heapless::Vec;

use crate::can::Frame;
use crate::can::frame::{FrameError, MAX_DATA_LEN};
use crate::line::LineBuffer;

/// Longest line that means something: `T`, 8 digits of identifier, length, 16 digits of data.
const LONGEST_COMMAND: usize = 1 + 8 + 1 + 2 * MAX_DATA_LEN;

/// A frame as a line: `t`, 3 digits of identifier, length, 16 digits of data, 4 of time, carriage return.
pub type FrameLine = Vec<u8, { 1 + 3 + 1 + 2 * MAX_DATA_LEN + 4 + 1 }>;

/// Why a line is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum SlcanError {
    /// More characters than any command has.
    LineTooLong = 1,
    /// The first character is no command of this dialect (CAN FD's `d`, `D`, `b`, `B` among them).
    UnknownCommand = 2,
    /// The line is shorter or longer than its command and its length digit ask for.
    WrongLength = 3,
    /// A character that should be a hexadecimal digit is none.
    NotHexadecimal = 4,
    /// Standard identifier above 0x7FF or extended identifier above 0x1FFF_FFFF.
    IdTooLarge = 5,
    /// A length digit above 8.
    DataTooLong = 6,
    /// A bit rate other than `S0` to `S9`.
    UnknownBitRate = 7,
    /// A time-stamp setting other than `Z0` and `Z1`.
    UnknownSetting = 8,
    /// A frame to transmit while the channel is closed.
    ChannelClosed = 9,
    /// A frame to transmit while the channel is open for listening only.
    ListenOnly = 10,
    /// A setting that may only change while the channel is closed.
    ChannelOpen = 11,
}

impl SlcanError {
    /// The number that stands for this error in logs. Never renumbered.
    pub const fn code(self) -> u8 {
        self as u8
    }
}

impl core::fmt::Display for SlcanError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::LineTooLong => "line longer than any command",
            Self::UnknownCommand => "unknown command",
            Self::WrongLength => "line length does not fit the command",
            Self::NotHexadecimal => "not a hexadecimal digit",
            Self::IdTooLarge => "identifier too large",
            Self::DataTooLong => "more than 8 data bytes",
            Self::UnknownBitRate => "unknown bit rate",
            Self::UnknownSetting => "unknown time-stamp setting",
            Self::ChannelClosed => "the channel is closed",
            Self::ListenOnly => "the channel is open for listening only",
            Self::ChannelOpen => "not while the channel is open",
        })
    }
}

impl core::error::Error for SlcanError {}

impl From<FrameError> for SlcanError {
    fn from(error: FrameError) -> Self {
        match error {
            FrameError::IdTooLarge => Self::IdTooLarge,
            FrameError::DataTooLong => Self::DataTooLong,
        }
    }
}

/// One line from the host, understood.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Command {
    /// An empty line. python-can sends one where the CAN FD data rate would stand.
    Nothing,
    /// `S0` to `S9`: a standard bit rate by its number (6 is 500 kbit/s).
    BitRate(u8),
    /// `sxxyy`: the bit timing registers BTR0 and BTR1 of an SJA1000.
    BitTiming([u8; 2]),
    /// `O`: open the channel.
    Open,
    /// `L`: open it for listening only.
    Listen,
    /// `C`: close it.
    Close,
    /// `V`: hardware and software version.
    Version,
    /// `N`: serial number.
    SerialNumber,
    /// `F`: status flags.
    Status,
    /// `Z0`, `Z1`: time stamps on received frames off, on.
    TimeStamps(bool),
    /// `t`: transmit a data frame with an 11-bit identifier.
    Transmit(Frame),
    /// `T`: transmit a data frame with a 29-bit identifier. Its data is checked and dropped.
    TransmitExtended {
        /// 29-bit identifier.
        raw_id: u32,
    },
    /// `r` or `R`: transmit a remote frame.
    TransmitRemote {
        /// 11-bit or 29-bit identifier.
        raw_id: u32,
        /// The identifier has 29 bits.
        extended: bool,
    },
}

/// Understands one line, given without its carriage return. Digits may be of either case.
///
/// # Errors
/// Every [`SlcanError`] but those of the channel's state, which [`Adapter`] knows.
pub fn parse(line: &[u8]) -> Result<Command, SlcanError> {
    if line.len() > LONGEST_COMMAND {
        return Err(SlcanError::LineTooLong);
    }
    Ok(match line {
        [] => Command::Nothing,
        [b'O'] => Command::Open,
        [b'L'] => Command::Listen,
        [b'C'] => Command::Close,
        [b'V'] => Command::Version,
        [b'N'] => Command::SerialNumber,
        [b'F'] => Command::Status,
        [b'O' | b'L' | b'C' | b'V' | b'N' | b'F', ..] => return Err(SlcanError::WrongLength),
        [b'S', digit @ b'0'..=b'9'] => Command::BitRate(digit - b'0'),
        [b'S', ..] => return Err(SlcanError::UnknownBitRate),
        [b's', registers @ ..] if registers.len() == 4 => {
            let [.., btr0, btr1] = hexadecimal(registers)?.to_be_bytes();
            Command::BitTiming([btr0, btr1])
        }
        [b's', ..] => return Err(SlcanError::WrongLength),
        [b'Z', b'0'] => Command::TimeStamps(false),
        [b'Z', b'1'] => Command::TimeStamps(true),
        [b'Z', ..] => return Err(SlcanError::UnknownSetting),
        [b't', rest @ ..] => {
            let (raw_id, data_len, rest) = head::<3>(rest, 0x7FF)?;
            Command::Transmit(Frame::new(raw_id as u16, &data(rest, data_len)?)?)
        }
        [b'T', rest @ ..] => {
            let (raw_id, data_len, rest) = head::<8>(rest, 0x1FFF_FFFF)?;
            data(rest, data_len)?;
            Command::TransmitExtended { raw_id }
        }
        [b'r', rest @ ..] => remote(head::<3>(rest, 0x7FF)?, false)?,
        [b'R', rest @ ..] => remote(head::<8>(rest, 0x1FFF_FFFF)?, true)?,
        _ => return Err(SlcanError::UnknownCommand),
    })
}

/// Writes a data frame as a line with its carriage return. With `stamp_ms` (0 to 59 999, Lawicel's minute), four
/// digits of time follow the data.
pub fn encode(frame: &Frame, stamp_ms: Option<u16>) -> FrameLine {
    let mut line = FrameLine::new();
    // No push can fail: the capacity is the length of the longest frame with a time stamp.
    let mut push = |byte: u8| {
        let _ = line.push(byte);
    };
    let digit = |value: u8| match value & 0xF {
        low @ 0..=9 => b'0' + low,
        high => b'A' + (high - 10),
    };
    let [id_high, id_low] = frame.raw_id().to_be_bytes();
    push(b't');
    push(digit(id_high));
    push(digit(id_low >> 4));
    push(digit(id_low));
    push(digit(frame.data().len() as u8));
    let stamp = stamp_ms.map(u16::to_be_bytes);
    for byte in frame.data().iter().chain(stamp.iter().flatten()) {
        push(digit(byte >> 4));
        push(digit(*byte));
    }
    push(b'\r');
    line
}

/// Commands out of a stream of bytes.
#[derive(Debug, Clone, Default)]
pub struct Decoder {
    line: LineBuffer<LONGEST_COMMAND, b'\r'>,
}

impl Decoder {
    /// A decoder at the start of a line.
    pub const fn new() -> Self {
        Self { line: LineBuffer::new() }
    }

    /// Takes one byte; a command or its refusal comes out at the end of each line. Line feeds are skipped.
    ///
    /// # Errors
    /// As [`parse`], once for each bad line. The line after it is read cleanly.
    pub fn push(&mut self, byte: u8) -> Option<Result<Command, SlcanError>> {
        let line = self.line.push(byte)?;
        Some(line.map_err(|_| SlcanError::LineTooLong).and_then(parse))
    }
}

/// Identifier of `DIGITS` digits and length digit in front of a frame's data, and what follows them.
fn head<const DIGITS: usize>(line: &[u8], largest_id: u32) -> Result<(u32, usize, &[u8]), SlcanError> {
    let (id, rest) = line.split_at_checked(DIGITS).ok_or(SlcanError::WrongLength)?;
    let raw_id = hexadecimal(id)?;
    if raw_id > largest_id {
        return Err(SlcanError::IdTooLarge);
    }
    let (len, rest) = rest.split_at_checked(1).ok_or(SlcanError::WrongLength)?;
    let data_len = hexadecimal(len)? as usize;
    if data_len > MAX_DATA_LEN {
        return Err(SlcanError::DataTooLong);
    }
    Ok((raw_id, data_len, rest))
}

/// The data bytes of a frame: exactly two digits each.
fn data(digits: &[u8], data_len: usize) -> Result<Vec<u8, MAX_DATA_LEN>, SlcanError> {
    if digits.len() != 2 * data_len {
        return Err(SlcanError::WrongLength);
    }
    let mut bytes = Vec::new();
    for pair in digits.chunks_exact(2) {
        // at most 8 bytes: `head` has refused a larger length digit
        let _ = bytes.push(hexadecimal(pair)? as u8);
    }
    Ok(bytes)
}

/// A remote frame has a length but no data.
fn remote((raw_id, _, rest): (u32, usize, &[u8]), extended: bool) -> Result<Command, SlcanError> {
    if rest.is_empty() { Ok(Command::TransmitRemote { raw_id, extended }) } else { Err(SlcanError::WrongLength) }
}

/// Up to 8 hexadecimal digits as a number.
fn hexadecimal(digits: &[u8]) -> Result<u32, SlcanError> {
    digits.iter().try_fold(0, |value, &byte| {
        let digit = char::from(byte).to_digit(16).ok_or(SlcanError::NotHexadecimal)?;
        Ok(value << 4 | digit)
    })
}

#[cfg(test)]
mod tests;
