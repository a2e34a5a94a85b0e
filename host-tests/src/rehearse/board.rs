//! The emulated drive board as a [`Bench`]: rig link and SLCAN over TCP, in real time or, on a busy host, slower.

use super::bench::{Bench, BenchError};
use crate::board_lines::{BoardLines, LinesError};
use crate::emulator::{Emulator, EmulatorError};
use glenoid::can::Frame;
use glenoid::rig::CABLES;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// A booted board with both of its lines connected. Dropping it ends the emulator.
pub struct EmulatedBoard {
    emulator: Emulator,
    lines: BoardLines,
    stop: Option<&'static AtomicBool>,
}

impl EmulatedBoard {
    /// Connects the rig link and opens the CAN channel.
    ///
    /// # Errors
    /// [`BenchError`] when a line cannot be reached.
    pub fn connect(emulator: Emulator) -> Result<Self, BenchError> {
        let lines = BoardLines::connect(&emulator).map_err(|error| BenchError(error.to_string()))?;
        Ok(Self { emulator, lines, stop: None })
    }

    /// The same board, given up as soon as `stop` is set.
    #[must_use]
    pub fn until(self, stop: &'static AtomicBool) -> Self {
        Self { stop: Some(stop), ..self }
    }

    /// Waits until the board has logged a line with `text` in it, and gives that line.
    ///
    /// # Errors
    /// [`EmulatorError`] when there is none within `limit`.
    pub fn wait_for_log(&mut self, text: &str, limit: Duration) -> Result<String, EmulatorError> {
        self.emulator.wait_for_log(text, limit)
    }

    /// The end of the board's log, for a report on what went wrong.
    pub fn crash_record(&self) -> Vec<String> {
        let log = self.emulator.log();
        log[log.len().saturating_sub(10)..].to_vec()
    }

    fn gone(error: LinesError) -> BenchError {
        BenchError(format!("the emulated board is gone: {error}"))
    }
}

impl Bench for EmulatedBoard {
    fn set_counts(&mut self, counts: &[i32; CABLES]) -> Result<(), BenchError> {
        self.lines.sample(counts).map_err(Self::gone)
    }

    fn send(&mut self, frame: &Frame) -> Result<(), BenchError> {
        self.lines.send(frame).map_err(Self::gone)
    }

    fn pass(&mut self, ms: u32) -> Result<Vec<Frame>, BenchError> {
        if self.stop.is_some_and(|stop| stop.load(Ordering::Relaxed)) {
            return Err(BenchError("interrupted".to_string()));
        }
        self.lines.pass(Duration::from_millis(u64::from(ms)), 0).map_err(Self::gone)
    }

    fn restart(&mut self) -> Result<(), BenchError> {
        let failed = |error: &dyn std::error::Error| BenchError(format!("the board does not come back: {error}"));
        self.emulator.power_cycle().map_err(|error| failed(&error))?;
        self.lines = BoardLines::connect(&self.emulator).map_err(|error| failed(&error))?;
        Ok(())
    }
}
