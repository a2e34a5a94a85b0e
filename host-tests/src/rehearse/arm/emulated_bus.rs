//! Emulated boards on one CAN bus: each board's SLCAN line is its place on it.
//!
//! A frame goes to a board only while few are under way to it, those of the host first, as their identifiers win on a bus; and
//! the next sample of the encoders only when every board has taken the one before. A slow host makes the bus slow, and nothing
//! is lost.

use super::bus::Bus;
use crate::board_lines::{APART, BoardLines, LinesError, Pace};
use crate::emulator::{self, Emulator};
use crate::rehearse::bench::BenchError;
use glenoid::can::Frame;
use glenoid::rig::CABLES;
use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Lines that may be on their way to a board at once: what its UART takes in a few milliseconds.
const UNDER_WAY: u64 = 16;

/// A board whose joint rests samples its encoders at every so many turns only: each sample costs the emulator as much as ten
/// frames.
const RESTING: u64 = 10;
/// Time between two samples while a board starts.
const SAMPLES_APART: Duration = Duration::from_millis(10);

/// Boards of one image on a bus.
pub struct EmulatedBus {
    image: PathBuf,
    boards: Vec<Option<Plugged>>,
    pace: Pace,
    turns: u64,
    stop: Option<&'static AtomicBool>,
}

/// A board that is plugged in.
struct Plugged {
    emulator: Emulator,
    lines: BoardLines,
    counts: Option<[i32; CABLES]>,
    /// The encoders were set since the last sample.
    is_fresh: bool,
    /// Frames of the host and of other boards that it has not been sent yet.
    from_host: VecDeque<Frame>,
    from_boards: VecDeque<Frame>,
    /// What it must have answered to have taken the last sample.
    sampled: u64,
}

impl EmulatedBus {
    /// A bus without boards.
    pub fn new(image: PathBuf) -> Self {
        Self { image, boards: Vec::new(), pace: Pace::new(), turns: 0, stop: None }
    }

    /// The same bus, given up as soon as `stop` is set.
    #[must_use]
    pub fn until(self, stop: &'static AtomicBool) -> Self {
        Self { stop: Some(stop), ..self }
    }

    /// The end of every board's log, for a report on what went wrong.
    pub fn logs(&self) -> Vec<String> {
        let logs = self.boards.iter().flatten().map(|board| board.emulator.log());
        logs.enumerate().flat_map(|(number, log)| last_lines(number, &log)).collect()
    }

    fn pass_on(&mut self, sender: usize, frame: Frame) {
        for (number, board) in self.boards.iter_mut().enumerate() {
            if let Some(board) = board
                && number != sender
            {
                board.from_boards.push_back(frame);
            }
        }
    }

    fn go_on(&mut self, time: Duration) -> Result<Vec<Frame>, LinesError> {
        self.turns += 1;
        for board in self.boards.iter_mut().flatten() {
            if std::mem::take(&mut board.is_fresh) || self.turns.is_multiple_of(RESTING) {
                board.sample()?;
            }
        }
        let mut turn = self.pace.turn(time, APART);
        let mut heard = Vec::new();
        while !turn.is_over(self.boards.iter().flatten().all(Plugged::is_served), &mut self.pace) {
            if turn.takes_too_long() {
                let under_way = self.boards.iter().flatten().map(|board| board.lines.under_way());
                return Err(LinesError::Unanswered(under_way.max().unwrap_or_default()));
            }
            for number in 0..self.boards.len() {
                while let Some(board) = &mut self.boards[number]
                    && let Some(frame) = board.lines.receive()?
                {
                    heard.push(frame);
                    self.pass_on(number, frame);
                }
            }
            self.boards.iter_mut().flatten().try_for_each(Plugged::deliver)?;
        }
        Ok(heard)
    }
}

impl EmulatedBus {
    /// A board starts, which takes a while.
    fn while_others_go_on(
        &mut self,
        start: impl FnOnce() -> Result<Plugged, BenchError> + Send + 'static,
    ) -> Result<Plugged, BenchError> {
        let starting = std::thread::spawn(start);
        while !starting.is_finished() {
            self.go_on(SAMPLES_APART).map_err(|error| gone(&error))?;
        }
        starting.join().unwrap_or_else(|_| Err(BenchError("the thread that starts a board has panicked".to_owned())))
    }
}

fn last_lines(number: usize, log: &[String]) -> Vec<String> {
    log[log.len().saturating_sub(5)..].iter().map(|line| format!("board {}: {line}", number + 1)).collect()
}

fn gone(error: &dyn std::error::Error) -> BenchError {
    BenchError(format!("an emulated board is gone: {error}"))
}

impl Plugged {
    fn connect(emulator: Emulator) -> Result<Self, BenchError> {
        let lines = BoardLines::connect(&emulator).map_err(|error| gone(&error))?;
        Ok(Self {
            emulator,
            lines,
            counts: None,
            is_fresh: false,
            from_host: VecDeque::new(),
            from_boards: VecDeque::new(),
            sampled: 0,
        })
    }

    fn sample(&mut self) -> Result<(), LinesError> {
        if let Some(counts) = &self.counts {
            self.lines.sample(counts)?;
            self.sampled = self.lines.sent();
        }
        Ok(())
    }

    /// Sends what waits, as far as the board can take it.
    fn deliver(&mut self) -> Result<(), LinesError> {
        while self.lines.under_way() < UNDER_WAY
            && let Some(frame) = self.from_host.pop_front().or_else(|| self.from_boards.pop_front())
        {
            self.lines.send(&frame)?;
        }
        Ok(())
    }

    fn is_served(&self) -> bool {
        self.from_host.is_empty() && self.lines.has_answered(self.sampled)
    }
}

impl Bus for EmulatedBus {
    fn join(&mut self, serial: u32) -> Result<usize, BenchError> {
        let (image, options) = (self.image.clone(), emulator::Options { serial, ..emulator::Options::default() });
        let board = self.while_others_go_on(move || {
            let emulator = Emulator::start(&image, &options).map_err(|error| BenchError(error.to_string()))?;
            Plugged::connect(emulator)
        })?;
        self.boards.push(Some(board));
        Ok(self.boards.len() - 1)
    }

    fn unplug(&mut self, board: usize) {
        self.boards[board] = None;
    }

    fn set_counts(&mut self, board: usize, counts: &[i32; CABLES]) {
        if let Some(board) = &mut self.boards[board] {
            board.counts = Some(*counts);
            board.is_fresh = true;
        }
    }

    fn send(&mut self, frame: &Frame) -> Result<(), BenchError> {
        self.boards.iter_mut().flatten().for_each(|board| board.from_host.push_back(*frame));
        Ok(())
    }

    fn pass(&mut self, ms: u32) -> Result<Vec<Frame>, BenchError> {
        if self.stop.is_some_and(|stop| stop.load(Ordering::Relaxed)) {
            return Err(BenchError("interrupted".to_owned()));
        }
        self.go_on(Duration::from_millis(ms.into())).map_err(|error| gone(&error))
    }

    fn restart(&mut self, board: usize) -> Result<(), BenchError> {
        let Some(Plugged { mut emulator, counts, .. }) = self.boards[board].take() else {
            return Err(BenchError("the board is not plugged in".to_owned()));
        };
        let back = self.while_others_go_on(move || {
            emulator.power_cycle().map_err(|error| gone(&error))?;
            Plugged::connect(emulator)
        })?;
        self.boards[board] = Some(Plugged { counts, ..back });
        Ok(())
    }
}
