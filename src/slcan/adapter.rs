//! The serial-to-CAN adapter that stands between an SLCAN client and the bus.

use super::{Command, Decoder, FrameLine, SlcanError, encode};
use crate::can::Frame;

/// Acknowledgement of a setting.
const DONE: &[u8] = b"\r";
/// Acknowledgement of a frame with an 11-bit identifier.
const SENT: &[u8] = b"z\r";
/// Acknowledgement of a frame with a 29-bit identifier.
const SENT_EXTENDED: &[u8] = b"Z\r";
/// Refusal: a bell, without a carriage return.
const REFUSED: &[u8] = b"\x07";
/// Hardware 01, adapter dialect 01.
const VERSION: &[u8] = b"V0101\r";
/// Every emulated adapter bears the same number.
const SERIAL_NUMBER: &[u8] = b"N0001\r";
/// No status flag set.
const STATUS_CLEAR: &[u8] = b"F00\r";
/// Bit 3, data overrun: bytes from the client were lost since the last query.
const STATUS_OVERRUN: &[u8] = b"F08\r";

/// Time stamps count the milliseconds of a minute (Lawicel, command `Z`).
const STAMP_PERIOD_MS: u32 = 60_000;

/// Whether frames pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Channel {
    Closed,
    Open,
    Listening,
}

/// What the adapter did since power-up. Every counter wraps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Counters {
    /// Frames from the client handed to the board.
    pub accepted: u32,
    /// Extended and remote frames: acknowledged, then dropped, since nothing on the board listens to them.
    pub foreign: u32,
    /// Lines answered with a bell.
    pub refused: u32,
    /// Times that bytes from the client were lost before the adapter saw them.
    pub overruns: u32,
}

/// What follows from one line of the client.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Response {
    /// Bytes to send back to the client.
    pub reply: &'static [u8],
    /// The frame that the client puts on the bus.
    pub frame: Option<Frame>,
    /// Why the line was refused; the reply is then a bell.
    pub refusal: Option<SlcanError>,
}

/// The adapter: closed at power-up, and then nothing passes in either direction.
///
/// Opening an open channel and closing a closed one are accepted: python-can does both on every connection.
#[derive(Debug, Clone)]
pub struct Adapter {
    decoder: Decoder,
    channel: Channel,
    stamps: bool,
    overrun: bool,
    counters: Counters,
}

impl Adapter {
    /// A closed adapter, time stamps off.
    pub const fn new() -> Self {
        Self {
            decoder: Decoder::new(),
            channel: Channel::Closed,
            stamps: false,
            overrun: false,
            counters: Counters { accepted: 0, foreign: 0, refused: 0, overruns: 0 },
        }
    }

    /// Takes one byte from the client. Some at the end of each line.
    pub fn receive(&mut self, byte: u8) -> Option<Response> {
        let answer = self.decoder.push(byte)?.and_then(|command| self.obey(command));
        Some(answer.unwrap_or_else(|error| {
            self.counters.refused = self.counters.refused.wrapping_add(1);
            Response { reply: REFUSED, frame: None, refusal: Some(error) }
        }))
    }

    /// The line that carries a frame from the bus to the client; None unless the channel is open.
    ///
    /// `now_ms` is the board's wrapping clock; it is sent only when the client asked for time stamps.
    pub fn forward(&self, frame: &Frame, now_ms: u32) -> Option<FrameLine> {
        // below 60 000, so 16 bits hold it
        let stamp_ms = (now_ms % STAMP_PERIOD_MS) as u16;
        match self.channel {
            Channel::Closed => None,
            Channel::Open | Channel::Listening => Some(encode(frame, self.stamps.then_some(stamp_ms))),
        }
    }

    /// Notes that bytes from the client were lost; the next status query says so.
    pub fn note_overrun(&mut self) {
        self.overrun = true;
        self.counters.overruns = self.counters.overruns.wrapping_add(1);
    }

    /// Frames pass to the client.
    pub fn is_open(&self) -> bool {
        self.channel != Channel::Closed
    }

    /// The counters since power-up.
    pub fn counters(&self) -> Counters {
        self.counters
    }

    fn obey(&mut self, command: Command) -> Result<Response, SlcanError> {
        let mut frame = None;
        let reply = match command {
            Command::Nothing => DONE,
            // The serial line has no bit timing; only the order of commands is held to the manual.
            Command::BitRate(_) | Command::BitTiming(_) => {
                self.while_closed()?;
                DONE
            }
            Command::TimeStamps(on) => {
                self.while_closed()?;
                self.stamps = on;
                DONE
            }
            Command::Open => {
                self.channel = Channel::Open;
                DONE
            }
            Command::Listen => {
                self.channel = Channel::Listening;
                DONE
            }
            Command::Close => {
                self.channel = Channel::Closed;
                DONE
            }
            Command::Version => VERSION,
            Command::SerialNumber => SERIAL_NUMBER,
            Command::Status if core::mem::take(&mut self.overrun) => STATUS_OVERRUN,
            Command::Status => STATUS_CLEAR,
            Command::Transmit(accepted) => {
                self.while_open()?;
                self.counters.accepted = self.counters.accepted.wrapping_add(1);
                frame = Some(accepted);
                SENT
            }
            Command::TransmitExtended { .. } => self.foreign(true)?,
            Command::TransmitRemote { extended, .. } => self.foreign(extended)?,
        };
        Ok(Response { reply, frame, refusal: None })
    }

    fn while_closed(&self) -> Result<(), SlcanError> {
        match self.channel {
            Channel::Closed => Ok(()),
            Channel::Open | Channel::Listening => Err(SlcanError::ChannelOpen),
        }
    }

    fn while_open(&self) -> Result<(), SlcanError> {
        match self.channel {
            Channel::Open => Ok(()),
            Channel::Closed => Err(SlcanError::ChannelClosed),
            Channel::Listening => Err(SlcanError::ListenOnly),
        }
    }

    fn foreign(&mut self, extended: bool) -> Result<&'static [u8], SlcanError> {
        self.while_open()?;
        self.counters.foreign = self.counters.foreign.wrapping_add(1);
        Ok(if extended { SENT_EXTENDED } else { SENT })
    }
}

impl Default for Adapter {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests;
