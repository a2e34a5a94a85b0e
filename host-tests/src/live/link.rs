//! The rig link of a person: samples of the encoders and the button, and cables that are pulled.

use super::person::{Order, PERIOD_MS};
use glenoid::rig::CABLES;
use std::collections::VecDeque;
use std::io::{self, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::mpsc::{Receiver, TryRecvError};
use std::thread;
use std::time::{Duration, Instant};

/// Samples that a pull of a cable takes, one with each telemetry, and how fast it is pulled: 12 mm in 0.4 s on the shoulder's drums.
const PULL_SAMPLES: i32 = 40;
const PULL_COUNTS_A_SAMPLE: i32 = 26;

/// Samples from the letting go of a cable to the pull of the next: 0.6 s.
const REST_SAMPLES: i32 = 30;

/// The line to the board's encoders and button.
pub(super) struct Link {
    address: SocketAddr,
    stream: TcpStream,
    orders: Receiver<Order>,
    silent: bool,
    /// The cable that is being pulled, from 0, and for how many samples yet; below 0 the cables rest.
    pulled: Option<(usize, i32)>,
    /// The cables to be pulled after it.
    to_pull: VecDeque<usize>,
    next: Instant,
}

impl Link {
    /// Connects to the rig link of a board; orders come from outside.
    ///
    /// # Errors
    /// When it cannot be reached.
    pub(super) fn connect(address: SocketAddr, orders: Receiver<Order>) -> io::Result<Self> {
        let stream = TcpStream::connect(address)?;
        stream.set_nodelay(true)?;
        let (pulled, to_pull) = (None, VecDeque::new());
        Ok(Self { address, stream, orders, silent: false, pulled, to_pull, next: Instant::now() })
    }

    /// Is a cable being pulled, or the pause behind that not over?
    pub(super) fn pulls(&self) -> bool {
        self.pulled.is_some()
    }

    /// How far which cable is pulled at the next sample, counts.
    fn pull(&mut self) -> Option<(usize, i32)> {
        if self.pulled.is_none() {
            self.pulled = self.to_pull.pop_front().map(|cable| (cable, PULL_SAMPLES));
        }
        let (cable, left) = self.pulled?;
        self.pulled = (left > -REST_SAMPLES).then_some((cable, left - 1));
        // there and back
        (left > 0).then_some((cable, PULL_COUNTS_A_SAMPLE * left.min(PULL_SAMPLES - left)))
    }

    /// Obeys what was ordered, and sends one sample when its time has come.
    pub(super) fn sample(&mut self, counts: &[i32; CABLES]) -> io::Result<()> {
        thread::sleep(self.next.saturating_duration_since(Instant::now()));
        // A host that fell behind does not catch up: the board would see an arm that leaps.
        self.next = (self.next + Duration::from_millis(PERIOD_MS.into())).max(Instant::now());
        loop {
            match self.orders.try_recv() {
                Ok(Order::Button(down)) => self.write(&format!("b {}\n", u8::from(down)))?,
                Ok(Order::Encoders(sound)) => self.silent = !sound,
                Ok(Order::Pull(cable)) => self.to_pull.push_back(usize::from(cable) - 1),
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) => return Err(io::ErrorKind::BrokenPipe.into()),
            }
        }
        let mut counts = *counts;
        if let Some((cable, pulled)) = self.pull() {
            counts[cable] += pulled;
        }
        let [c1, c2, c3, c4, c5, c6] = counts;
        if self.silent { Ok(()) } else { self.write(&format!("e {c1} {c2} {c3} {c4} {c5} {c6}\n")) }
    }

    /// One write for one line: a pause within it would delay the sample. A board that was switched off and on again is
    /// found again.
    fn write(&mut self, line: &str) -> io::Result<()> {
        if self.stream.write_all(line.as_bytes()).is_err() {
            self.stream = TcpStream::connect(self.address)?;
            self.stream.set_nodelay(true)?;
        }
        Ok(())
    }
}
