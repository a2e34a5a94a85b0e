//! Two consumers of the same frames: one by the rules of the protection, and one that believes whatever comes.

use glenoid::can::set::{PIECE_LEN, Received, Receiver};
use glenoid::can::telemetry::{TELEMETRY_FRAMES, TELEMETRY_ID, TELEMETRY_LEN};

/// A set of telemetry, packed.
pub type Set = [u8; TELEMETRY_LEN];

/// After so long without a good set the consumer begins anew, µs: five periods.
const STALE_US: u64 = 100_000;

/// The consumer by the rules.
#[derive(Debug)]
pub struct Consumer {
    receiver: Receiver<TELEMETRY_LEN>,
    last_us: u64,
    /// Sets that were lost on the way, as the counter says.
    pub lost: u64,
    /// Sets that were refused by their check, or as repeated.
    pub refused: u64,
}

impl Consumer {
    /// Knows nothing yet.
    pub const fn new() -> Self {
        Self { receiver: Receiver::new(TELEMETRY_ID), last_us: 0, lost: 0, refused: 0 }
    }

    /// Takes a frame's bytes; gives the set that it completes.
    pub fn take(&mut self, now_us: u64, piece: [u8; 8]) -> Option<Set> {
        if now_us - self.last_us > STALE_US {
            // the sender may have started anew, and counts from elsewhere then
            self.receiver.restart();
            self.last_us = now_us;
        }
        match self.receiver.take(piece) {
            Received::Nothing => None,
            Received::Repeated | Received::Refused(_) => {
                self.refused += 1;
                None
            }
            Received::Set { data, ahead } => {
                self.lost += u64::from(ahead.unwrap_or(1) - 1);
                self.last_us = now_us;
                Some(data)
            }
        }
    }
}

/// The consumer that puts every piece in its place and takes what is there with the last one.
#[derive(Debug)]
pub struct Careless {
    data: Set,
}

impl Careless {
    /// Knows nothing yet.
    pub const fn new() -> Self {
        Self { data: [0; TELEMETRY_LEN] }
    }

    /// Takes a frame's bytes; gives the set with the last piece.
    pub fn take(&mut self, [head, bytes @ ..]: [u8; 8]) -> Option<Set> {
        let index = usize::from(head & 0x1F);
        *self.data.as_chunks_mut::<PIECE_LEN>().0.get_mut(index)? = bytes;
        (index + 1 == TELEMETRY_FRAMES).then_some(self.data)
    }
}
