//! The flash controller, and the second bank of the flash (RM0440, "Embedded flash memory"). The program lies in the
//! first one, which nothing here changes.

use super::Env;
use super::words::{PAGE_WORDS, WORD_LEN, Word};
use crate::breach::Rule;
use crate::core::nvic::exception::NMI;
use crate::register_file::RegisterFile;
use crate::time::{PS_A_MS, PS_A_US};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeSet;

/// Where the second bank begins.
pub const BANK_2: u32 = 0x0804_0000;
/// Its length, bytes.
pub const BANK_LEN: u32 = 0x4_0000;
const KEYS: [u32; 2] = [0x4567_0123, 0xCDEF_89AB];
/// Erasing a page (STM32G474 datasheet, flash memory characteristics: 22.02 ms typical).
const ERASE_PS: u64 = 22 * PS_A_MS;
/// Programming a double word (datasheet: 81.7 us typical).
const PROGRAM_PS: u64 = 82 * PS_A_US;
/// Who asks again within this time does nothing else meanwhile: twenty instructions.
const POLLED_PS: u64 = PS_A_US / 8;
/// Errors of SR; they stay until they are cleared.
const ERRORS: [&str; 7] = ["OPERR", "PROGERR", "WRPERR", "PGAERR", "SIZERR", "PGSERR", "MISERR"];

/// Something that takes time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Operation {
    /// Erasing a page of the second bank.
    Erase(usize),
    /// Programming a double word.
    Program(usize, u64),
}

/// The cells, which outlive a power cut, and what the option bytes say.
#[derive(Debug, Clone)]
pub struct Cells {
    /// The second bank.
    pub words: Vec<Word>,
    /// FLASH_OPTR as the option bytes set it.
    pub optr: u32,
    /// Pages of the second bank that are write-protected.
    pub protected: BTreeSet<usize>,
    /// Chances.
    pub random: ChaCha8Rng,
}

impl Cells {
    /// A chip as it leaves the factory, but for what its second bank holds: noise.
    pub fn new(seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let words = (0..BANK_LEN / WORD_LEN).map(|_| Word::noise(&mut random)).collect();
        // RM0440: FLASH_OPTR, the factory's setting: two banks, no protection
        Self { words, optr: 0xFFEF_F8AA, protected: BTreeSet::new(), random }
    }

    /// An operation is cut short.
    pub fn tear(&mut self, operation: Operation) {
        let Self { words, random, .. } = self;
        match operation {
            Operation::Program(at, bits) => words[at] = Word::torn_in_programming(bits, random),
            Operation::Erase(page) => {
                for word in &mut words[page * PAGE_WORDS..(page + 1) * PAGE_WORDS] {
                    *word = word.torn_in_erasing(random);
                }
            }
        }
    }
}

/// The peripheral.
#[derive(Debug, Clone)]
pub struct Flash {
    /// Its registers.
    pub file: RegisterFile,
    /// What it keeps.
    pub cells: Cells,
    keys: usize,
    locked_for_good: bool,
    /// The first half of a double word: its address and bits.
    half: Option<(u32, u32)>,
    /// What is under way, and until when.
    pub busy: Option<(Operation, u64)>,
    /// Operations begun since power-up.
    pub operations: u32,
    /// The cells before each operation, if somebody wants to know.
    pub journal: Option<Vec<(Cells, Operation)>>,
    cache_is_old: bool,
    /// A read of the second bank has to wait until then, ps.
    pub stall_until_ps: u64,
    /// Loads that had to wait, and turns of loops that did nothing but ask, since power-up and while the sampling was on.
    pub stalls: u32,
    /// When the status was read last, ps, while BSY was set.
    polled_ps: u64,
}

impl Flash {
    /// As a reset leaves it.
    pub fn new(cells: Cells) -> Self {
        let mut flash = Self {
            file: RegisterFile::new("FLASH"),
            cells,
            keys: 0,
            locked_for_good: false,
            half: None,
            busy: None,
            operations: 0,
            journal: None,
            cache_is_old: false,
            stall_until_ps: 0,
            stalls: 0,
            polled_ps: 0,
        };
        flash.reset();
        flash
    }

    /// A reset of the chip: an operation under way ends as if the power had failed.
    pub fn reset(&mut self) {
        self.cut();
        self.file.reset();
        let optr = self.file.offset("OPTR");
        self.file.put_at(optr, self.cells.optr);
        self.file.put("CR", "LOCK", 1);
        (self.keys, self.locked_for_good, self.half, self.cache_is_old) = (0, false, None, false);
    }

    /// The power fails: what is under way is torn.
    pub fn cut(&mut self) {
        if let Some((operation, _)) = self.busy.take() {
            self.cells.tear(operation);
        }
    }

    /// Lets time pass.
    pub fn advance(&mut self, now_ps: u64) {
        let Some((operation, until_ps)) = self.busy else { return };
        if now_ps >= until_ps {
            self.busy = None;
            match operation {
                Operation::Program(at, bits) => self.cells.words[at] = Word::Whole(bits),
                Operation::Erase(page) => {
                    self.cells.words[page * PAGE_WORDS..(page + 1) * PAGE_WORDS].fill(Word::Erased);
                    self.file.put("CR", "STRT", 0);
                }
            }
            self.file.put("SR", "BSY", 0);
        }
    }

    /// When the firmware does nothing but ask whether the work is done: until when it will, ps.
    pub fn waits_until_ps(&mut self, now_ps: u64) -> Option<u64> {
        let (_, until_ps) = self.busy?;
        let waits = now_ps - std::mem::replace(&mut self.polled_ps, now_ps) < POLLED_PS;
        waits.then_some(until_ps)
    }

    /// Reads a register.
    pub fn read(&mut self, offset: u32, env: &mut Env) -> u32 {
        self.advance(env.now_ps);
        self.file.at(offset)
    }

    /// Writes a register.
    pub fn write(&mut self, offset: u32, value: u32, env: &mut Env) {
        self.advance(env.now_ps);
        match self.file.name_at(offset) {
            Some("KEYR") => self.unlock(value, env),
            Some("SR") => {
                let cleared = value & !(1 << 16);
                self.file.put_at(offset, self.file.at(offset) & !cleared);
            }
            Some("ECCR") => {
                let flags = 0xF000_0000;
                let kept = self.file.at(offset) & !(value & flags);
                self.file.put_at(offset, kept);
            }
            Some("CR") => self.control(offset, value, env),
            Some("ACR") => {
                let resets_cache = self.file.field_of(value, "ACR", "DCRST") != 0;
                if resets_cache && self.file.is("ACR", "DCEN") {
                    env.breaches.add(Rule::Protected, "FLASH.ACR.DCRST while the data cache is on");
                } else if resets_cache {
                    self.cache_is_old = false;
                }
                self.file.write(offset, value, env.breaches);
            }
            Some(name) => env.breaches.add(Rule::Protected, format!("FLASH.{name} is written")),
            None => {}
        }
    }

    fn unlock(&mut self, key: u32, env: &mut Env) {
        if self.locked_for_good || !self.file.is("CR", "LOCK") || KEYS.get(self.keys) != Some(&key) {
            env.breaches.add(Rule::WrongKey, format!("FLASH.KEYR: {key:#x}"));
            self.locked_for_good = true;
            return;
        }
        self.keys += 1;
        if self.keys == KEYS.len() {
            self.keys = 0;
            self.file.put("CR", "LOCK", 0);
        }
    }

    fn control(&mut self, offset: u32, value: u32, env: &mut Env) {
        if self.file.is("CR", "LOCK") {
            env.breaches.add(Rule::Protected, "FLASH.CR while it is locked");
            return;
        }
        if self.busy.is_some() {
            env.breaches.add(Rule::FlashBusy, "FLASH.CR while BSY is set");
            return;
        }
        self.file.write(offset, value, env.breaches);
        // OPTLOCK and LOCK are only ever set here
        if self.file.is("CR", "LOCK") {
            self.half = None;
        }
        if self.file.is("CR", "STRT") {
            self.start_erase(env);
        }
    }

    fn start_erase(&mut self, env: &mut Env) {
        let get = |field| self.file.get("CR", field);
        if get("PER") == 0 || get("PG") != 0 || get("BKER") == 0 || self.file.get("OPTR", "DBANK") == 0 {
            env.breaches.add(Rule::FlashBusy, "an erase that would stop the program, or of no single page");
            return;
        }
        let page = get("PNB") as usize;
        if self.has_error() || self.cells.protected.contains(&page) {
            self.file.put("SR", if self.has_error() { "PGSERR" } else { "WRPERR" }, 1);
            self.file.put("CR", "STRT", 0);
            return;
        }
        self.begin(Operation::Erase(page), ERASE_PS, env);
    }

    /// The firmware stores to the second bank.
    pub fn store(&mut self, address: u32, size: u32, value: u32, env: &mut Env) {
        self.advance(env.now_ps);
        let at = address - BANK_2;
        let page = at as usize / (PAGE_WORDS * WORD_LEN as usize);
        if self.busy.is_some() {
            env.breaches.add(Rule::FlashBusy, "a store to the flash while BSY is set");
        } else if !self.file.is("CR", "PG") || self.file.is("CR", "LOCK") {
            env.breaches.add(Rule::FlashAccess, format!("a store to {address:#x} while PG is 0"));
            self.file.put("SR", "PGSERR", 1);
        } else if self.has_error() {
            self.file.put("SR", "PGSERR", 1);
        } else if size != 4 {
            env.breaches.add(Rule::FlashAccess, format!("a store of {size} bytes"));
            self.file.put("SR", "SIZERR", 1);
        } else if self.cells.protected.contains(&page) {
            self.file.put("SR", "WRPERR", 1);
        } else {
            self.store_half(at, value, env);
        }
    }

    fn store_half(&mut self, at: u32, value: u32, env: &mut Env) {
        match (self.half.take(), at % WORD_LEN) {
            (None, 0) => self.half = Some((at, value)),
            (Some((first, low)), 4) if first + 4 == at => {
                let index = (first / WORD_LEN) as usize;
                let bits = u64::from(low) | u64::from(value) << 32;
                // a written word may still be programmed to zeros
                if self.cells.words[index] != Word::Erased && bits != 0 {
                    env.breaches.add(Rule::NotErased, format!("the word at {:#x}", BANK_2 + first));
                    self.file.put("SR", "PROGERR", 1);
                    return;
                }
                self.begin(Operation::Program(index, bits), PROGRAM_PS, env);
            }
            _ => {
                env.breaches.add(Rule::FlashAccess, format!("half a double word at {:#x}", BANK_2 + at));
                self.file.put("SR", "PGAERR", 1);
            }
        }
    }

    fn begin(&mut self, operation: Operation, takes_ps: u64, env: &Env) {
        self.operations += 1;
        if let Some(journal) = &mut self.journal {
            journal.push((self.cells.clone(), operation));
        }
        self.cache_is_old = true;
        self.busy = Some((operation, env.now_ps + takes_ps));
        self.file.put("SR", "BSY", 1);
    }

    fn has_error(&self) -> bool {
        ERRORS.iter().any(|error| self.file.is("SR", error))
    }

    /// The firmware loads from the second bank. While this is worked on, the core waits.
    pub fn load(&mut self, address: u32, env: &mut Env) -> u32 {
        if let Some((_, until_ps)) = self.busy {
            self.stall_until_ps = until_ps;
            self.advance(until_ps);
        }
        if self.cache_is_old && self.file.is("ACR", "DCEN") {
            env.breaches.add(Rule::StaleCache, format!("a load from {address:#x}"));
        }
        let at = address - BANK_2;
        let Cells { words, random, .. } = &mut self.cells;
        let (bits, is_bad) = words[(at / WORD_LEN) as usize].read(random);
        if is_bad {
            self.note_bad_word(at, true);
            env.nvic.pend(NMI);
        }
        (bits >> (8 * (at % WORD_LEN))) as u32
    }

    /// A word could not be corrected: its distance from the start of its bank, and whether that is the second.
    pub fn note_bad_word(&mut self, at: u32, in_bank_2: bool) {
        self.file.put("ECCR", "ADDR_ECC", at / WORD_LEN);
        self.file.put("ECCR", "BK_ECC", in_bank_2.into());
        self.file.put("ECCR", "ECCD", 1);
    }
}
