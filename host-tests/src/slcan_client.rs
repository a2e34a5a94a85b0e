//! A small SLCAN client over TCP: the host's end of the emulated board's CAN line.

use std::collections::VecDeque;
use std::fmt;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::{Duration, Instant};

use glenoid::can::Frame;
use glenoid::line::LineBuffer;
use glenoid::slcan::{self, Command};

/// Whether a read that failed found no bytes in time, and may be tried again: a signal may interrupt it at any moment.
pub fn nothing_came(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted)
}

/// What python-can sends to open a channel at 500 kbit/s.
pub const PYTHON_CAN_OPENING: &[u8] = b"C\rS6\r\rO\rO\r";

/// Longest wait for the adapter's answers while the channel is opened. They come at once, but for an emulator on a busy host.
const OPENING_LIMIT: Duration = Duration::from_secs(30);

/// Shortest wait for the socket: zero would mean for ever.
const SHORTEST_WAIT: Duration = Duration::from_millis(1);

/// Why the client cannot go on.
#[derive(Debug)]
pub enum ClientError {
    /// The line broke or was never there.
    Line(io::Error),
    /// The board closed the line.
    Closed,
    /// The adapter did not answer the opening.
    NoAnswer,
}

impl fmt::Display for ClientError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(error) => write!(f, "the CAN line failed: {error}"),
            Self::Closed => write!(f, "the board closed the CAN line"),
            Self::NoAnswer => write!(f, "the adapter did not answer"),
        }
    }
}

impl std::error::Error for ClientError {}

impl From<io::Error> for ClientError {
    fn from(error: io::Error) -> Self {
        Self::Line(error)
    }
}

/// An open channel. Dropping it closes the channel.
#[derive(Debug)]
pub struct SlcanClient {
    stream: TcpStream,
    line: LineBuffer<64, b'\r'>,
    frames: VecDeque<Frame>,
    /// Lines written that the adapter answers.
    written: u64,
    acknowledged: u64,
    refused: u64,
}

impl SlcanClient {
    /// Connects and opens the channel at 500 kbit/s.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn open(address: SocketAddr) -> Result<Self, ClientError> {
        let mut client = Self::connect(address)?;
        client.write(PYTHON_CAN_OPENING)?;
        let commands = PYTHON_CAN_OPENING.iter().filter(|&&byte| byte == b'\r').count() as u64;
        let deadline = Instant::now() + OPENING_LIMIT;
        while client.acknowledged + client.refused < commands {
            if Instant::now() >= deadline {
                return Err(ClientError::NoAnswer);
            }
            client.hear(SHORTEST_WAIT)?;
        }
        Ok(client)
    }

    /// Connects without a word: the channel stays as it is.
    ///
    /// # Errors
    /// [`ClientError::Line`].
    pub fn connect(address: SocketAddr) -> Result<Self, ClientError> {
        let stream = TcpStream::connect(address)?;
        stream.set_nodelay(true)?;
        Ok(Self { stream, line: LineBuffer::new(), frames: VecDeque::new(), written: 0, acknowledged: 0, refused: 0 })
    }

    /// Puts a frame on the bus. The adapter's acknowledgement is counted when it comes.
    ///
    /// # Errors
    /// [`ClientError::Line`].
    pub fn send(&mut self, frame: &Frame) -> Result<(), ClientError> {
        self.write(&slcan::encode(frame, None))
    }

    /// Writes bytes as they are, be they commands or garbage.
    ///
    /// # Errors
    /// [`ClientError::Line`].
    pub fn write(&mut self, bytes: &[u8]) -> Result<(), ClientError> {
        self.written += bytes.iter().filter(|&&byte| byte == b'\r').count() as u64;
        Ok(self.stream.write_all(bytes)?)
    }

    /// The next frame from the bus, in the order of their coming; None if there is none within `limit`.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn receive(&mut self, limit: Duration) -> Result<Option<Frame>, ClientError> {
        self.receive_where(limit, |_| true)
    }

    /// The next frame that `wanted` accepts; frames before it are dropped. None if there is none within `limit`.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn receive_where(
        &mut self,
        limit: Duration,
        wanted: impl Fn(&Frame) -> bool,
    ) -> Result<Option<Frame>, ClientError> {
        let deadline = Instant::now() + limit;
        loop {
            while let Some(frame) = self.frames.pop_front() {
                if wanted(&frame) {
                    return Ok(Some(frame));
                }
            }
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(None);
            }
            self.hear(left)?;
        }
    }

    /// The line itself, for a writer that does not wait.
    pub fn stream(&self) -> &TcpStream {
        &self.stream
    }

    /// Commands and frames that the adapter acknowledged, as far as its answers were read.
    pub fn acknowledged(&self) -> u64 {
        self.acknowledged
    }

    /// Lines that the adapter answered with a bell, as far as its answers were read.
    pub fn refused(&self) -> u64 {
        self.refused
    }

    /// Asks the adapter so many times for nothing but its answer, a byte each way.
    ///
    /// # Errors
    /// [`ClientError::Line`].
    pub fn ping(&mut self, times: usize) -> Result<(), ClientError> {
        self.write(&vec![b'\r'; times])
    }

    /// Lines that the adapter has not answered yet, as far as its answers were read. Lines that are answered by more than an
    /// acknowledgement, such as the version, count for ever.
    pub fn under_way(&self) -> u64 {
        self.written.saturating_sub(self.acknowledged + self.refused)
    }

    /// Lines written so far that the adapter answers.
    pub fn sent(&self) -> u64 {
        self.written
    }

    /// Reads what is there, waiting at most `limit` for the first byte.
    fn hear(&mut self, limit: Duration) -> Result<(), ClientError> {
        self.stream.set_read_timeout(Some(limit.max(SHORTEST_WAIT)))?;
        let mut bytes = [0; 1024];
        let len = match self.stream.read(&mut bytes) {
            Ok(0) => return Err(ClientError::Closed),
            Ok(len) => len,
            Err(error) if nothing_came(&error) => 0,
            Err(error) => return Err(error.into()),
        };
        for &byte in &bytes[..len] {
            self.take(byte);
        }
        Ok(())
    }

    fn take(&mut self, byte: u8) {
        // a bell has no carriage return behind it
        if byte == 0x07 {
            self.refused += 1;
        } else if let Some(Ok(line)) = self.line.push(byte) {
            match line {
                b"" | b"z" | b"Z" => self.acknowledged += 1,
                frame => {
                    if let Ok(Command::Transmit(frame)) = slcan::parse(frame) {
                        self.frames.push_back(frame);
                    }
                }
            }
        }
    }
}

impl Drop for SlcanClient {
    fn drop(&mut self) {
        // a line that is already broken needs no closing
        let _ = self.write(b"C\r");
    }
}
