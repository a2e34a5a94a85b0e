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
/// Extended filters that there is room for.
const EXTENDED_FILTERS: usize = 8;
/// All bits of an extended identifier.
const ID_29: u32 = 0x1FFF_FFFF;

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

impl Verdict {
    /// What a matching filter says by its code (SFEC, EFEC); None for one that is off. Codes that only set a flag, which
    /// the model lacks, store nothing.
    fn of(action: u32) -> Option<Self> {
        match action {
            0 => None,
            1 | 5 => Some(Self::Fifo(0)),
            2 | 6 => Some(Self::Fifo(1)),
            _ => Some(Self::Reject),
        }
    }
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

    /// As an earlier program left it, for all that this one knows: the words from this one on.
    pub fn leave(&mut self, from: usize, words: &[u32]) {
        self.words[from..from + words.len()].copy_from_slice(words);
        self.written[from..from + words.len()].fill(false);
    }

    /// What the first `filters` standard filters say of a frame (RM0440, "FDCAN standard message ID filter element").
    pub fn judge_standard(&self, filters: usize, id: u32, breaches: &mut Breaches) -> Verdict {
        for index in 0..filters.min(EXTENDED) {
            let word = self.filter_word(index, breaches);
            let (kind, action) = (word >> 30, word >> 27 & 7);
            let (first, second) = (word >> 16 & 0x7FF, word & 0x7FF);
            if word & FILTER_RESERVED != 0 {
                breaches.add(Rule::ReservedBit, format!("FDCAN: filter {index} is {word:#010x}"));
            }
            let Some(verdict) = Verdict::of(action) else { continue };
            let matches = match kind {
                0 => (first..=second).contains(&id),
                1 => id == first || id == second,
                2 => id & second == first & second,
                _ => false,
            };
            if matches {
                return verdict;
            }
        }
        Verdict::NoMatch
    }

    /// What the first `filters` extended filters say of a frame (RM0440, "FDCAN extended message ID filter element"). `mask` is
    /// XIDAM: all kinds of filters see the identifier through it but for the last, a range without it.
    pub fn judge_extended(&self, filters: usize, id: u32, mask: u32, breaches: &mut Breaches) -> Verdict {
        for index in 0..filters.min(EXTENDED_FILTERS) {
            let at = EXTENDED + 2 * index;
            let word = self.filter_word(at, breaches);
            let Some(verdict) = Verdict::of(word >> 29) else { continue };
            let other = self.filter_word(at + 1, breaches);
            let (first, second, masked) = (word & ID_29, other & ID_29, id & mask);
            let matches = match other >> 30 {
                0 => (first..=second).contains(&masked),
                1 => masked == first || masked == second,
                2 => masked & second == first & second,
                _ => (first..=second).contains(&id),
            };
            if matches {
                return verdict;
            }
        }
        Verdict::NoMatch
    }

    /// A word that the controller reads as a filter.
    fn filter_word(&self, at: usize, breaches: &mut Breaches) -> u32 {
        if !self.written[at] {
            breaches.add(Rule::StaleMemory, format!("FDCAN: word {at} of the filters was never written"));
        }
        self.words[at]
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

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: u32 = ID_29;

    /// The verdict of a list of extended filters: code, kind and two identifiers each.
    fn verdict(filters: &[(u32, u32, u32, u32)], size: usize, id: u32, mask: u32) -> Verdict {
        let mut ram = MessageRam::new(1);
        for (index, (action, kind, first, second)) in filters.iter().enumerate() {
            ram.write(0x70 + 8 * index as u32, action << 29 | first);
            ram.write(0x74 + 8 * index as u32, kind << 30 | second);
        }
        let mut breaches = Breaches::default();
        let verdict = ram.judge_extended(size, id, mask, &mut breaches);
        assert_eq!(breaches.all(), []);
        verdict
    }

    /// RM0440, "FDCAN extended message ID filter element" and "Acceptance filter".
    #[test]
    fn an_extended_filter_matches_by_its_kind() {
        use Verdict::{Fifo, NoMatch};
        let range = [(1, 0, 0x100, 0x200)];
        for (id, expected) in [(0xFF, NoMatch), (0x100, Fifo(0)), (0x200, Fifo(0)), (0x201, NoMatch)] {
            assert_eq!(verdict(&range, 1, id, ALL), expected, "{id:#x}");
        }
        let two = [(2, 1, 0x100, 0x1FFF_FFFF)];
        for (id, expected) in [(0x100, Fifo(1)), (0x101, NoMatch), (0x1FFF_FFFF, Fifo(1))] {
            assert_eq!(verdict(&two, 1, id, ALL), expected, "{id:#x}");
        }
        let classic = [(1, 2, 0x1234_5600, 0x1FFF_FF00)];
        for (id, expected) in [(0x1234_56AB, Fifo(0)), (0x1234_57AB, NoMatch)] {
            assert_eq!(verdict(&classic, 1, id, ALL), expected, "{id:#x}");
        }
    }

    #[test]
    fn the_mask_is_for_all_kinds_but_the_last() {
        use Verdict::{Fifo, NoMatch};
        // the upper byte does not count
        let (id, mask) = (0x1200_0150, 0x00FF_FFFF);
        for (kind, second, expected) in [(0, 0x200, Fifo(0)), (1, 0x150, Fifo(0)), (3, 0x200, NoMatch)] {
            assert_eq!(verdict(&[(1, kind, 0x100, second)], 1, id, mask), expected, "{kind}");
        }
        assert_eq!(verdict(&[(1, 2, 0x150, ALL)], 1, id, mask), Fifo(0));
        assert_eq!(verdict(&[(1, 2, 0x150, ALL)], 1, id, ALL), NoMatch);
        assert_eq!(verdict(&[(1, 3, 0x1200_0000, 0x1200_0200)], 1, id, mask), Fifo(0));
    }

    #[test]
    fn the_first_match_decides_and_what_is_off_does_not_count() {
        let everything = |action| (action, 2, 0, 0);
        let second = [everything(0), everything(3), everything(1)];
        assert_eq!(verdict(&second, 3, 5, ALL), Verdict::Reject);
        assert_eq!(verdict(&second, 1, 5, ALL), Verdict::NoMatch);
        assert_eq!(verdict(&second, 0, 5, ALL), Verdict::NoMatch);
        for (action, expected) in
            [(4, Verdict::Reject), (5, Verdict::Fifo(0)), (6, Verdict::Fifo(1)), (7, Verdict::Reject)]
        {
            assert_eq!(verdict(&[everything(action)], 1, 5, ALL), expected, "{action}");
        }
    }

    /// A size above eight means eight, and what nobody has written is told.
    #[test]
    fn no_more_than_eight_are_looked_at() {
        let none = [(0, 0, 0, 0); 8];
        assert_eq!(verdict(&none, 15, 5, ALL), Verdict::NoMatch);
        let mut breaches = Breaches::default();
        MessageRam::new(1).judge_extended(1, 5, ALL, &mut breaches);
        assert!(breaches.all().iter().any(|breach| breach.rule == Rule::StaleMemory));
    }
}
