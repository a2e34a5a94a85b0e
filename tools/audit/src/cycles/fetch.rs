//! What fetching instructions costs on the drive board: its flash is slower than its core.
//!
//! RM0440, "Embedded flash memory", read access: at 170 MHz a read takes four wait states and brings 64 bits (two banks). What
//! was read before may lie in the instruction cache, 32 lines of four times 64 bits, the one that was used longest ago is
//! given up; with prefetch the 64 bits that follow are read meanwhile, and what prefetch brought does not enter the
//! cache. The core-coupled memory (CCM) does not wait.
//!
//! The manual does not say everything, so this much is assumed: of a line only what was read is valid; a read that has begun is
//! finished even when a branch leaves it behind; the core asks for the next 64 bits when it has all of the present ones, as its
//! queue of three words lets it (DDI 0439, 1.3). Constants that code reads from the flash are not in it.

/// Bytes that one read of the flash brings.
const READ_BYTES: u64 = 8;
/// Cycles of a read beyond the one that every fetch takes.
const WAIT_STATES: u64 = 4;
/// Lines of the instruction cache.
const LINES: usize = 32;
/// Reads that make up a line.
const READS_PER_LINE: u64 = 4;
/// A call between flash and CCM is too far for the instruction, and goes by way of two more and a jump.
const VENEER_CYCLES: u64 = 6;

/// Addresses, the end not included.
pub type Range = std::ops::Range<u64>;

/// How a board's memories are used.
#[derive(Debug, Clone, Default)]
pub struct Placement {
    /// Code that does not wait.
    pub ccm: Range,
    /// Read ahead (FLASH_ACR.PRFTEN).
    pub prefetch: bool,
}

/// A line of the cache: which, and which of its reads are there.
#[derive(Debug, Clone, Copy)]
struct Line {
    number: u64,
    valid: [bool; READS_PER_LINE as usize],
}

/// The way of instructions from memory to core, with its clock.
#[derive(Debug)]
pub struct Fetch {
    placement: Placement,
    /// Cycles since the start, waits included.
    now: u64,
    /// The read that the core has, by its number; None after a stay in the CCM.
    present: Option<u64>,
    /// The read that was asked for ahead, and when it is there.
    ahead: Option<(u64, u64)>,
    /// When the flash can begin another read.
    free_at: u64,
    /// Lines of the cache, the one used last in front.
    cache: Vec<Line>,
    was_in_ccm: Option<bool>,
    last_was_call: bool,
}

impl Fetch {
    /// Nothing is in the cache: whatever ran before was something else.
    pub fn new(placement: Placement) -> Self {
        Self {
            placement,
            now: 0,
            present: None,
            ahead: None,
            free_at: 0,
            cache: Vec::with_capacity(LINES),
            was_in_ccm: None,
            last_was_call: false,
        }
    }

    /// Executes one instruction.
    pub fn execute(&mut self, address: u64, bytes: u64, cycles: u64, is_call: bool) {
        let in_ccm = self.placement.ccm.contains(&address);
        if self.last_was_call && self.was_in_ccm.is_some_and(|was| was != in_ccm) {
            self.now += VENEER_CYCLES;
        }
        (self.was_in_ccm, self.last_was_call) = (Some(in_ccm), is_call);
        if in_ccm {
            self.present = None;
        } else {
            for read in address / READ_BYTES..=(address + bytes - 1) / READ_BYTES {
                self.need(read);
            }
        }
        self.now += cycles;
    }

    /// Cycles since the start.
    pub fn cycles(&self) -> u64 {
        self.now
    }

    /// Waits until the core has this read, and asks for the one behind it.
    fn need(&mut self, read: u64) {
        if self.present == Some(read) {
            return;
        }
        self.present = Some(read);
        match self.ahead.take() {
            Some((ahead, at)) if ahead == read => {
                self.now = self.now.max(at);
                self.placed_in_cache(read, !self.placement.prefetch);
            }
            // Left behind by a branch, but on its way into the cache all the same.
            left => {
                if let Some((left, _)) = left.filter(|_| !self.placement.prefetch) {
                    self.placed_in_cache(left, true);
                }
                if !self.placed_in_cache(read, false) {
                    self.now = self.now.max(self.free_at) + WAIT_STATES;
                    self.free_at = self.now;
                    self.placed_in_cache(read, true);
                }
            }
        }
        if !self.placed_in_cache(read + 1, false) {
            // With prefetch the flash goes on by itself; else the core must have taken the second word first.
            let asked = self.now + u64::from(!self.placement.prefetch);
            self.free_at = self.free_at.max(asked) + 1 + WAIT_STATES;
            self.ahead = Some((read + 1, self.free_at));
        }
    }

    /// Whether the read is in the cache, where it is put when `fill`.
    fn placed_in_cache(&mut self, read: u64, fill: bool) -> bool {
        let (number, part) = (read / READS_PER_LINE, (read % READS_PER_LINE) as usize);
        match self.cache.iter().position(|line| line.number == number) {
            Some(at) if fill || self.cache[at].valid[part] => {
                self.cache[..=at].rotate_right(1);
                self.cache[0].valid[part] = true;
                true
            }
            None if fill => {
                self.cache.truncate(LINES - 1);
                let mut valid = [false; READS_PER_LINE as usize];
                valid[part] = true;
                self.cache.insert(0, Line { number, valid });
                true
            }
            _ => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Executes instructions of four bytes and one cycle at these addresses.
    fn run(fetch: &mut Fetch, addresses: impl IntoIterator<Item = u64>) -> u64 {
        let before = fetch.cycles();
        addresses.into_iter().for_each(|address| fetch.execute(address, 4, 1, false));
        fetch.cycles() - before
    }

    fn straight(from: u64, instructions: u64) -> impl Iterator<Item = u64> {
        (0..instructions).map(move |index| from + 4 * index)
    }

    #[test]
    fn straight_code_takes_a_read_every_two_words() {
        // The first read waits four cycles; each further one is asked for when its predecessor is there and takes five,
        // while two instructions are executed.
        let mut ahead = Fetch::new(Placement { prefetch: true, ..Placement::default() });
        assert_eq!(run(&mut ahead, straight(0, 20)), 4 + 9 * 5 + 2);
        let mut alone = Fetch::new(Placement::default());
        assert_eq!(run(&mut alone, straight(0, 20)), 4 + 9 * 6 + 2);
    }

    #[test]
    fn a_loop_that_fits_the_cache_waits_once() {
        let mut fetch = Fetch::new(Placement::default());
        run(&mut fetch, straight(0, 40));
        assert_eq!(run(&mut fetch, straight(0, 40)), 40);
        // What prefetch brought is not kept: the jump's target is.
        let mut fetch = Fetch::new(Placement { prefetch: true, ..Placement::default() });
        run(&mut fetch, straight(0, 40));
        assert!(run(&mut fetch, straight(0, 40)) > 80);
    }

    #[test]
    fn a_loop_longer_than_the_cache_waits_every_time() {
        let longer = LINES as u64 * 8 + 8;
        let mut fetch = Fetch::new(Placement::default());
        let first = run(&mut fetch, straight(0, longer));
        let second = run(&mut fetch, straight(0, longer));
        assert!(second.abs_diff(first) <= WAIT_STATES + 1, "{first} {second}");
    }

    #[test]
    fn long_instructions_hide_the_reads() {
        let mut fetch = Fetch::new(Placement::default());
        (0..10).for_each(|index| fetch.execute(4 * index, 4, 14, false));
        assert_eq!(fetch.cycles(), 4 + 140);
    }

    #[test]
    fn the_ccm_never_waits_and_is_called_by_a_veneer() {
        let mut fetch = Fetch::new(Placement { ccm: 0x1000..0x2000, prefetch: false });
        assert_eq!(run(&mut fetch, straight(0x1000, 400)), 400);
        fetch.execute(0x1640, 4, 1, true);
        assert_eq!(run(&mut fetch, [0]), VENEER_CYCLES + WAIT_STATES + 1);
        assert_eq!(run(&mut fetch, [0x1000]), 1);
    }
}
