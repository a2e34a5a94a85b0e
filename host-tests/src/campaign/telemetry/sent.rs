//! What the device has sent: the sets as they left it, to hold against what a consumer takes.

use super::consumer::Set;
use glenoid::can::set::PIECE_LEN;
use glenoid::can::telemetry::{TELEMETRY_FRAMES, TELEMETRY_LEN};
use std::collections::VecDeque;

/// Sets that are remembered: far more than can be under way.
const REMEMBERED: usize = 64;

/// A consumer must have a set so soon after it was packed, µs: three periods.
const FRESH_US: u64 = 60_000;

/// The last sets.
#[derive(Debug)]
pub struct Sent {
    under_way: Set,
    began_us: u64,
    /// Number of each set, when it was packed, and its bytes.
    sets: VecDeque<(u64, u64, Set)>,
    /// Sets that have left the device.
    pub number: u64,
}

/// What a consumer has taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Taken {
    /// The set with this number, so old, µs.
    Fresh(u64, u64),
    /// A set that is too old.
    Stale,
    /// No set that the device ever sent.
    Mixed,
}

impl Sent {
    /// Nothing yet.
    pub const fn new() -> Self {
        Self { under_way: [0; TELEMETRY_LEN], began_us: 0, sets: VecDeque::new(), number: 0 }
    }

    /// The device sends a piece.
    pub fn piece(&mut self, now_us: u64, [head, bytes @ ..]: [u8; 8]) {
        let index = usize::from(head & 0x1F);
        if index == 0 {
            self.began_us = now_us;
        }
        if let Some(place) = self.under_way.as_chunks_mut::<PIECE_LEN>().0.get_mut(index) {
            *place = bytes;
        }
        if index + 1 == TELEMETRY_FRAMES {
            self.number += 1;
            self.sets.push_back((self.number, self.began_us, self.under_way));
            if self.sets.len() > REMEMBERED {
                self.sets.pop_front();
            }
        }
    }

    /// Judges what was taken, by bytes.
    pub fn judge(&self, now_us: u64, taken: &Set) -> Taken {
        match self.sets.iter().rev().find(|(_, _, set)| set == taken) {
            None => Taken::Mixed,
            Some((_, began_us, _)) if now_us - began_us > FRESH_US => Taken::Stale,
            Some((number, began_us, _)) => Taken::Fresh(*number, now_us - began_us),
        }
    }
}
