//! Both serial lines of an emulated board, in the board's own time.
//!
//! A host that has too much to do lets the emulator stand still for seconds, and takes the time of whoever writes to it as
//! well. Samples of the encoders that had piled up in the line meanwhile would reach the board within a few milliseconds
//! each: an arm in motion would be an encoder that leaps. So a sample goes out only when the board has taken the one before.

use std::fmt;
use std::io::{self, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use glenoid::can::Frame;
use glenoid::rig::CABLES;

use crate::emulator::{Emulator, EmulatorError};
use crate::slcan_client::{ClientError, SlcanClient};

/// Shortest time between the taking of one sample and the sending of the next.
pub(crate) const APART: Duration = Duration::from_millis(5);

/// Longest wait for frames before it is looked again whether the sample was taken.
const LOOK: Duration = Duration::from_millis(1);

/// A board that has taken nothing for so long is gone.
const LIMIT: Duration = Duration::from_secs(60);

/// Why the lines cannot be used any more.
#[derive(Debug)]
pub enum LinesError {
    /// The rig link could not be reached.
    Emulator(EmulatorError),
    /// The rig link broke.
    Rig(io::Error),
    /// The CAN line broke, or the adapter did not answer the opening.
    Can(ClientError),
    /// So many lines were not answered for the limit.
    Unanswered(u64),
}

impl fmt::Display for LinesError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Emulator(error) => write!(f, "{error}"),
            Self::Rig(error) => write!(f, "the rig link failed: {error}"),
            Self::Can(error) => write!(f, "{error}"),
            Self::Unanswered(lines) => {
                write!(f, "the board has left {lines} lines unanswered for {} s", LIMIT.as_secs())
            }
        }
    }
}

impl std::error::Error for LinesError {}

impl From<ClientError> for LinesError {
    fn from(error: ClientError) -> Self {
        Self::Can(error)
    }
}

/// The rig link and an open CAN channel. Dropping them closes the channel.
#[derive(Debug)]
pub struct BoardLines {
    rig: TcpStream,
    can: SlcanClient,
    pace: Pace,
}

impl BoardLines {
    /// Connects the rig link and opens the CAN channel.
    ///
    /// # Errors
    /// [`LinesError`].
    pub fn connect(board: &Emulator) -> Result<Self, LinesError> {
        let rig = board.connect_rig().map_err(LinesError::Emulator)?;
        Ok(Self::over(rig, SlcanClient::open(board.can_address())?))
    }

    /// The lines of whatever board these lead to.
    pub fn over(rig: TcpStream, can: SlcanClient) -> Self {
        Self { rig, can, pace: Pace::new() }
    }

    /// The client on the bus vanishes, and another one takes its place. The line has one end: the old client must have
    /// gone before the new one can be heard.
    ///
    /// # Errors
    /// [`LinesError`].
    pub fn with_a_new_client(self, board: &Emulator) -> Result<Self, LinesError> {
        let Self { rig, can, pace } = self;
        drop(can);
        Ok(Self { rig, can: SlcanClient::open(board.can_address())?, pace })
    }

    /// Sends a sample of the six encoder counters.
    ///
    /// # Errors
    /// [`LinesError`].
    pub fn sample(&mut self, [c1, c2, c3, c4, c5, c6]: &[i32; CABLES]) -> Result<(), LinesError> {
        // One write for one line: a pause within it would delay the sample.
        let line = format!("e {c1} {c2} {c3} {c4} {c5} {c6}\n");
        self.rig.write_all(line.as_bytes()).map_err(LinesError::Rig)?;
        // As many bytes on the line that answers: the emulator takes both lines byte by byte.
        Ok(self.can.ping(line.len())?)
    }

    /// Puts a frame on the bus.
    ///
    /// # Errors
    /// [`LinesError`].
    pub fn send(&mut self, frame: &Frame) -> Result<(), LinesError> {
        Ok(self.can.send(frame)?)
    }

    /// Lines that the board has not answered yet, as far as its answers were read.
    pub fn under_way(&self) -> u64 {
        self.can.under_way()
    }

    /// Lets so much time pass, and more until the board has answered all but `granted` of what was sent to it. Gives the
    /// frames that it sent meanwhile, in order.
    ///
    /// # Errors
    /// [`LinesError`].
    pub fn pass(&mut self, time: Duration, granted: u64) -> Result<Vec<Frame>, LinesError> {
        let apart = if granted > 0 { Duration::ZERO } else { APART };
        let mut turn = self.pace.turn(time, apart);
        let mut frames = Vec::new();
        while !turn.is_over(self.can.under_way() <= granted, &mut self.pace) {
            if turn.takes_too_long() {
                return Err(LinesError::Unanswered(self.can.under_way()));
            }
            frames.extend(self.can.receive(LOOK)?);
        }
        Ok(frames)
    }

    /// The next frame from the board, waiting for it as long as [`LOOK`].
    pub(crate) fn receive(&mut self) -> Result<Option<Frame>, LinesError> {
        Ok(self.can.receive(LOOK)?)
    }

    /// Lines that were sent to the board so far, as a place that [`has_answered`](Self::has_answered) can be asked about.
    pub(crate) fn sent(&self) -> u64 {
        self.can.sent()
    }

    /// Has the board answered everything up to that place?
    pub(crate) fn has_answered(&self, sent: u64) -> bool {
        self.can.sent() - self.can.under_way() >= sent
    }
}

/// The pace of the samples, kept against a clock that runs on, so that the work between two of them does not add up.
#[derive(Debug)]
pub(crate) struct Pace {
    /// When the time that was asked for so far is over.
    due: Instant,
}

/// From one sample to the next.
#[derive(Debug)]
pub(crate) struct Turn {
    began: Instant,
    answered: Option<Instant>,
    apart: Duration,
}

impl Pace {
    pub(crate) fn new() -> Self {
        Self { due: Instant::now() }
    }

    /// A turn of so much time at least, which goes on for so much longer after the answer.
    pub(crate) fn turn(&mut self, time: Duration, apart: Duration) -> Turn {
        let began = Instant::now();
        self.due = (self.due + time).max(began);
        Turn { began, answered: None, apart }
    }
}

impl Turn {
    /// Is it over, now that everything `is_answered`?
    pub(crate) fn is_over(&mut self, is_answered: bool, pace: &mut Pace) -> bool {
        if !is_answered {
            return false;
        }
        let now = Instant::now();
        let since = *self.answered.get_or_insert(now);
        if now < pace.due || now < since + self.apart {
            return false;
        }
        // a host that fell behind does not catch up
        if now >= pace.due + APART {
            pace.due = now;
        }
        true
    }

    /// Whoever has not answered by now is gone.
    pub(crate) fn takes_too_long(&self) -> bool {
        self.began.elapsed() >= LIMIT
    }
}
