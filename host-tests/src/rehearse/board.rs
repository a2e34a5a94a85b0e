//! The emulated drive board as a [`Bench`]: rig link and SLCAN over TCP, in real time.

use super::bench::{Bench, BenchError};
use crate::emulator::{Emulator, EmulatorError};
use crate::slcan_client::SlcanClient;
use glenoid::can::Frame;
use glenoid::rig::CABLES;
use std::io::Write;
use std::net::TcpStream;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// A booted board with both of its lines connected. Dropping it ends the emulator.
pub struct EmulatedBoard {
    emulator: Emulator,
    rig: TcpStream,
    can: SlcanClient,
    /// When the time that was asked for so far is over.
    clock: Instant,
    stop: Option<&'static AtomicBool>,
}

impl EmulatedBoard {
    /// Connects the rig link and opens the CAN channel.
    ///
    /// # Errors
    /// [`BenchError`] when a line cannot be reached.
    pub fn connect(emulator: Emulator) -> Result<Self, BenchError> {
        let rig = emulator.connect_rig().map_err(|error: EmulatorError| BenchError(error.to_string()))?;
        let can = SlcanClient::open(emulator.can_address()).map_err(|error| BenchError(error.to_string()))?;
        Ok(Self { emulator, rig, can, clock: Instant::now(), stop: None })
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

    fn gone(error: impl std::error::Error) -> BenchError {
        BenchError(format!("the emulated board is gone: {error}"))
    }
}

impl Bench for EmulatedBoard {
    fn set_counts(&mut self, [c1, c2, c3, c4, c5, c6]: &[i32; CABLES]) -> Result<(), BenchError> {
        // One write for one line: a pause within it would delay the sample.
        self.rig.write_all(format!("e {c1} {c2} {c3} {c4} {c5} {c6}\n").as_bytes()).map_err(Self::gone)
    }

    fn send(&mut self, frame: &Frame) -> Result<(), BenchError> {
        self.can.send(frame).map_err(Self::gone)
    }

    fn pass(&mut self, ms: u32) -> Result<Vec<Frame>, BenchError> {
        if self.stop.is_some_and(|stop| stop.load(Ordering::Relaxed)) {
            return Err(BenchError("interrupted".to_string()));
        }
        // The pace is kept against a clock that runs on, so that the work between two calls does not add up. A host
        // that fell far behind does not catch up: the board would see an arm that leaps.
        let asked = Duration::from_millis(u64::from(ms));
        self.clock = (self.clock + asked).max(Instant::now());
        let mut frames = Vec::new();
        while let Some(left) = self.clock.checked_duration_since(Instant::now()) {
            match self.can.receive(left).map_err(Self::gone)? {
                Some(frame) => frames.push(frame),
                None => break,
            }
        }
        Ok(frames)
    }

    fn restart(&mut self) -> Result<(), BenchError> {
        let failed = |error: EmulatorError| BenchError(format!("the board does not come back: {error}"));
        self.emulator.power_cycle().map_err(failed)?;
        self.rig = self.emulator.connect_rig().map_err(failed)?;
        self.can = SlcanClient::open(self.emulator.can_address()).map_err(|error| BenchError(error.to_string()))?;
        self.clock = Instant::now();
        Ok(())
    }
}
