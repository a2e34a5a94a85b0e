//! The message RAM of the first FDCAN controller: 212 words (RM0440, "Message RAM"). What nobody wrote is noise.

use crate::breach::{Breaches, Rule};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Where it shows.
pub const FROM: u32 = 0x4000_A400;
/// Its length, bytes.
pub const LEN: u32 = 212 * 4;

/// Distances of its parts, words.
const EXTENDED: usize = 28;
const FIFO_0: usize = EXTENDED + 16;
const FIFO_1: usize = FIFO_0 + 3 * ELEMENT;
const EVENTS: usize = FIFO_1 + 3 * ELEMENT;
const BUFFERS: usize = EVENTS + 6;
/// Words of an element.
const ELEMENT: usize = 18;
/// Reserved bits of a standard filter.
const FILTER_RESERVED: u32 = 0xF800;

/// A classic frame on the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BusFrame {
    /// Identifier.
    pub id: u32,
    /// It has 29 bits.
    pub extended: bool,
    /// It asks for data.
    pub remote: bool,
    /// Bytes, 0 to 8.
    pub len: usize,
    /// Its data.
    pub data: [u8; 8],
}

/// What a filter says of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// It goes to this FIFO.
    Fifo(usize),
    /// It is dropped.
    Reject,
    /// No filter has it.
    NoMatch,
}

/// The memory.
#[derive(Debug, Clone)]
pub struct MessageRam {
    words: Vec<u32>,
    written: Vec<bool>,
}

impl MessageRam {
    /// As the supply finds it: noise.
    pub fn new(seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let words: Vec<u32> = (0..LEN / 4).map(|_| random.random()).collect();
        let written = vec![false; words.len()];
        Self { words, written }
    }

    /// The firmware reads.
    pub fn read(&self, offset: u32) -> u32 {
        self.words[(offset / 4) as usize]
    }

    /// The firmware writes.
    pub fn write(&mut self, offset: u32, value: u32) {
        self.words[(offset / 4) as usize] = value;
        self.written[(offset / 4) as usize] = true;
    }

    /// What the first `filters` standard filters say of a frame.
    pub fn judge(&self, filters: usize, id: u32, breaches: &mut Breaches) -> Verdict {
        for index in 0..filters.min(EXTENDED) {
            let word = self.words[index];
            if !self.written[index] {
                breaches.add(Rule::StaleMemory, format!("FDCAN: filter {index} was never written"));
            }
            let (kind, action) = (word >> 30, word >> 27 & 7);
            let (first, second) = (word >> 16 & 0x7FF, word & 0x7FF);
            if word & FILTER_RESERVED != 0 {
                breaches.add(Rule::ReservedBit, format!("FDCAN: filter {index} is {word:#010x}"));
            }
            if action == 0 {
                continue;
            }
            let matches = match kind {
                0 => (first..=second).contains(&id),
                1 => id == first || id == second,
                2 => id & second == first & second,
                _ => false,
            };
            if matches {
                return match action {
                    1 | 5 => Verdict::Fifo(0),
                    2 | 6 => Verdict::Fifo(1),
                    _ => Verdict::Reject,
                };
            }
        }
        Verdict::NoMatch
    }

    /// Puts a received frame into an element of a FIFO.
    pub fn receive(&mut self, fifo: usize, index: usize, frame: &BusFrame) {
        let at = if fifo == 0 { FIFO_0 } else { FIFO_1 } + index * ELEMENT;
        let id = if frame.extended { frame.id | 1 << 30 } else { frame.id << 18 };
        self.words[at] = id | u32::from(frame.remote) << 29;
        self.words[at + 1] = (frame.len as u32) << 16;
        let [low, high] = [0, 4].map(|from| u32::from_le_bytes(std::array::from_fn(|k| frame.data[from + k])));
        (self.words[at + 2], self.words[at + 3]) = (low, high);
    }

    /// The frame in a transmit buffer.
    pub fn to_send(&self, buffer: usize, breaches: &mut Breaches) -> BusFrame {
        let at = BUFFERS + buffer * ELEMENT;
        if !self.written[at..at + 4].iter().all(|written| *written) {
            breaches.add(Rule::StaleMemory, format!("FDCAN: transmit buffer {buffer} was never written"));
        }
        let [first, second, low, high] = [0, 1, 2, 3].map(|word| self.words[at + word]);
        let extended = first >> 30 & 1 == 1;
        let mut data = [0; 8];
        data[..4].copy_from_slice(&low.to_le_bytes());
        data[4..].copy_from_slice(&high.to_le_bytes());
        if second >> 21 & 1 == 1 {
            breaches.add(Rule::NotSetUp, "FDCAN: a frame in CAN FD format");
        }
        BusFrame {
            id: if extended { first & 0x1FFF_FFFF } else { first >> 18 & 0x7FF },
            extended,
            remote: first >> 29 & 1 == 1,
            len: (second >> 16 & 0xF).min(8) as usize,
            data,
        }
    }
}
