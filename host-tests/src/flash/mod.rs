//! A flash memory whose power can be cut in the middle of every operation.
//!
//! Modelled on the STM32G474's (RM0440, section 3): words of 8 bytes that can be written once between two erases, pages
//! of 2 KiB, and an error correcting code per word, so that a word torn by a power cut does not read as a mixture of old
//! and new alone. What it does read as nobody has measured; [`TornWord`] lists what has been seen or feared.

mod word;

pub use word::TornWord;

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};
use glenoid::record::PageFlash;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use word::Word;

/// Bytes of a word.
pub const WORD_LEN: usize = 8;
/// Bytes of a page.
pub const PAGE_LEN: usize = 2048;
/// Words of a page.
const PAGE_WORDS: usize = PAGE_LEN / WORD_LEN;

/// Why a flash operation failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FlashError {
    /// The power is off.
    NoPower,
    /// A word that is not erased was to be written.
    NotErased,
    /// The page is write-protected.
    Protected,
    /// The word's error correcting code says that it is beyond repair.
    BeyondRepair,
    /// It is busy with what was started.
    Busy,
    /// Bad arguments.
    Arguments(NorFlashErrorKind),
}

impl NorFlashError for FlashError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::Arguments(kind) => *kind,
            _ => NorFlashErrorKind::Other,
        }
    }
}

/// How a page fails besides power cuts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Defect {
    /// Erasing and writing are refused.
    Protected,
    /// Erasing leaves one bit of every word at 0.
    NotErasing,
    /// Writing is refused, erasing is not.
    RefusingWrites,
    /// Writing leaves one bit of every word at 1.
    NotWriting,
}

/// The flash.
#[derive(Debug, Clone)]
pub struct MockFlash {
    words: Vec<Word>,
    torn: TornWord,
    random: ChaCha8Rng,
    /// Operations until the one that the power fails in.
    cut_in: Option<u32>,
    off: bool,
    operations: u32,
    /// So often it will say that it is busy with what was started, and how that went.
    busy: u32,
    outcome: Result<(), FlashError>,
    defects: Vec<(usize, Defect)>,
}

impl MockFlash {
    /// An erased flash of so many pages, whose torn words read in the given way.
    pub fn new(pages: usize, torn: TornWord, seed: u64) -> Self {
        Self {
            words: vec![Word::ERASED; pages * PAGE_WORDS],
            torn,
            random: ChaCha8Rng::seed_from_u64(seed),
            cut_in: None,
            off: false,
            operations: 0,
            busy: 0,
            outcome: Ok(()),
            defects: Vec::new(),
        }
    }

    /// A copy whose chances fall differently from here on.
    pub fn fork(&self, seed: u64) -> Self {
        Self { random: ChaCha8Rng::seed_from_u64(seed), ..self.clone() }
    }

    /// The power will fail in the middle of the operation after the next `operations`. A word written and a page erased
    /// are one operation each.
    pub fn cut_after(&mut self, operations: u32) {
        self.cut_in = Some(operations);
    }

    /// The power comes back.
    pub fn power_up(&mut self) {
        self.off = false;
        self.cut_in = None;
        (self.busy, self.outcome) = (0, Ok(()));
    }

    /// The power has failed.
    pub fn is_off(&self) -> bool {
        self.off
    }

    /// Words written and pages erased so far, those cut short among them.
    pub fn operations(&self) -> u32 {
        self.operations
    }

    /// Gives a page a defect.
    pub fn spoil(&mut self, page: usize, defect: Defect) {
        self.defects.push((page, defect));
    }

    /// Changes bits of the byte at `at`, as time and radiation do.
    pub fn flip(&mut self, at: usize, bits: u8) {
        self.words[at / WORD_LEN].flip(u64::from(bits) << (at % WORD_LEN * 8));
    }

    fn has(&self, page: usize, defect: Defect) -> bool {
        self.defects.contains(&(page, defect))
    }

    /// Begins an operation; true when the power fails in it.
    fn begin(&mut self) -> Result<bool, FlashError> {
        self.answers()?;
        self.operations += 1;
        self.off = self.cut_in == Some(0);
        self.cut_in = self.cut_in.and_then(|left| left.checked_sub(1));
        Ok(self.off)
    }

    /// Neither is the power off, nor is something going on.
    fn answers(&self) -> Result<(), FlashError> {
        match (self.off, self.busy) {
            (true, _) => Err(FlashError::NoPower),
            (false, 0) => Ok(()),
            (false, _) => Err(FlashError::Busy),
        }
    }

    /// Something was started, and went like this. It takes its time.
    fn started(&mut self, outcome: Result<(), FlashError>) {
        self.busy = self.random.random_range(0..3);
        self.outcome = outcome;
    }

    fn write_word(&mut self, index: usize, value: u64) -> Result<(), FlashError> {
        let page = index / PAGE_WORDS;
        if self.has(page, Defect::Protected) || self.has(page, Defect::RefusingWrites) {
            return Err(FlashError::Protected);
        }
        if !self.words[index].is_erased() {
            return Err(FlashError::NotErased);
        }
        let value = if self.has(page, Defect::NotWriting) { value | 1 } else { value };
        if self.begin()? {
            self.words[index] = Word::torn_in_writing(value, self.torn, &mut self.random);
            return Err(FlashError::NoPower);
        }
        self.words[index] = Word::written(value);
        Ok(())
    }

    fn erase_page(&mut self, page: usize) -> Result<(), FlashError> {
        if self.has(page, Defect::Protected) {
            return Err(FlashError::Protected);
        }
        let cut = self.begin()?;
        let erased = if self.has(page, Defect::NotErasing) { Word::written(!1) } else { Word::ERASED };
        let share = disturbed_share(&mut self.random);
        for word in &mut self.words[page * PAGE_WORDS..(page + 1) * PAGE_WORDS] {
            if !cut {
                *word = erased;
            } else if self.random.random_bool(share) {
                word.tear_in_erasing(self.torn, &mut self.random);
            }
        }
        if cut { Err(FlashError::NoPower) } else { Ok(()) }
    }
}

/// How much of a page an erase that is cut short disturbs: mostly half of its words, at times one, none or all.
fn disturbed_share(random: &mut impl Rng) -> f64 {
    match random.random_range(0..8) {
        0 => 0.0,
        1 => 1.0,
        2 => 1.0 / PAGE_WORDS as f64,
        _ => 0.5,
    }
}

impl ErrorType for MockFlash {
    type Error = FlashError;
}

impl ReadNorFlash for MockFlash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        check_read(self, offset, bytes.len()).map_err(FlashError::Arguments)?;
        self.answers()?;
        let mut read = None;
        for (at, byte) in (offset as usize..).zip(bytes) {
            // one access a word: its bytes are of one reading
            let word = match read {
                Some((index, value)) if index == at / WORD_LEN => value,
                _ => self.words[at / WORD_LEN].read(&mut self.random).ok_or(FlashError::BeyondRepair)?,
            };
            read = Some((at / WORD_LEN, word));
            *byte = word.to_le_bytes()[at % WORD_LEN];
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.words.len() * WORD_LEN
    }
}

impl NorFlash for MockFlash {
    const WRITE_SIZE: usize = WORD_LEN;
    const ERASE_SIZE: usize = PAGE_LEN;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        check_erase(self, from, to).map_err(FlashError::Arguments)?;
        (from as usize / PAGE_LEN..to as usize / PAGE_LEN).try_for_each(|page| self.erase_page(page))
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        check_write(self, offset, bytes.len()).map_err(FlashError::Arguments)?;
        let first = offset as usize / WORD_LEN;
        bytes
            .as_chunks()
            .0
            .iter()
            .enumerate()
            .try_for_each(|(index, word)| self.write_word(first + index, u64::from_le_bytes(*word)))
    }
}

/// What goes wrong is said when it is over, as on the chip.
impl PageFlash for MockFlash {
    fn start_erase(&mut self, from: u32) -> Result<(), FlashError> {
        self.answers()?;
        let outcome = self.erase(from, from + PAGE_LEN as u32);
        self.started(outcome);
        Ok(())
    }

    fn start_write(&mut self, at: u32, word: &[u8]) -> Result<(), FlashError> {
        assert_eq!(word.len(), WORD_LEN, "one word at a time");
        self.answers()?;
        let outcome = self.write(at, word);
        self.started(outcome);
        Ok(())
    }

    fn is_busy(&mut self) -> Result<bool, FlashError> {
        let is_busy = self.busy != 0;
        self.busy = self.busy.saturating_sub(1);
        if is_busy {
            return Ok(true);
        }
        std::mem::replace(&mut self.outcome, Ok(())).map(|()| false)
    }
}

#[cfg(test)]
mod tests;
