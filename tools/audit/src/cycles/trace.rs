//! Counting each instruction by itself, from the emulator's log.
//!
//! With `-d in_asm,exec,nochain` QEMU writes each block of instructions once, when it is translated, and a line each
//! time that it is executed. The image's two marks divide the executions into counts; the sum over the instructions of
//! a count must agree with the ticks of [`run`](super::run), which is measured in another way.

use std::array;
use std::collections::HashMap;
use std::ops::Range;
use std::path::Path as FilePath;

use super::emulation::{self, RunError};
use super::fetch::{Fetch, Placement};
use super::pipeline;
use super::timing::{self, Instruction};
use firmware_image::elf::Elf;

/// Log what is translated and what is executed, every block.
const LOG: [&str; 2] = ["-d", "in_asm,exec,nochain"];

/// The image's marks around a count (`counter.rs`).
const MARKS: [&str; 2] = ["count_begins", "count_ends"];
/// Its marks of a kind of event, before a count; an image without the device has none.
const KINDS: [&str; 3] = ["kind_tick", "kind_sample", "kind_frame"];

/// A block that the emulator executes as a whole.
#[derive(Debug, Default)]
struct Block {
    instructions: Vec<Instruction>,
    cycles: u64,
}

/// What was executed between a pair of marks.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Count {
    /// Instructions.
    pub instructions: u64,
    /// Estimated cycles where memory does not wait.
    pub core_cycles: u64,
    /// Estimated cycles with the flash as each of [`PLACEMENTS`] uses it.
    pub fetched: [u64; PLACEMENTS.len()],
}

impl Count {
    /// Estimated cycles on the drive board as it is built.
    pub fn cycles(&self) -> u64 {
        self.fetched[AS_BUILT]
    }

    /// Both together.
    #[must_use]
    pub fn with(&self, other: &Self) -> Self {
        Self {
            instructions: self.instructions + other.instructions,
            core_cycles: self.core_cycles + other.core_cycles,
            fetched: array::from_fn(|at| self.fetched[at] + other.fetched[at]),
        }
    }

    /// This one without what the other counts too.
    #[must_use]
    pub fn without(&self, other: &Self) -> Self {
        Self {
            instructions: self.instructions.saturating_sub(other.instructions),
            core_cycles: self.core_cycles.saturating_sub(other.core_cycles),
            fetched: array::from_fn(|at| self.fetched[at].saturating_sub(other.fetched[at])),
        }
    }
}

/// Ways to use the memories that are estimated side by side: code in the CCM or all in the flash, each without and with
/// prefetch.
pub const PLACEMENTS: [(&str, bool, bool); 4] = [
    ("as built: marked code in the CCM, no prefetch", true, false),
    ("marked code in the CCM, prefetch", true, true),
    ("all in the flash, no prefetch", false, false),
    ("all in the flash, prefetch", false, true),
];
/// Which of them the drive board's image is.
const AS_BUILT: usize = 0;
/// The section of the code for the CCM.
const CCM_SECTION: &str = ".ccm_code";

/// A place's share of a run: an instruction, how often it was executed, and the cycles that its fetch waited in all.
pub type Executed<'a> = (&'a Instruction, u64, u64);

/// What was executed of a block.
#[derive(Debug, Clone, Copy, Default)]
struct Executions {
    times: u64,
    waits: u64,
}

/// The counts of a traced run, and how often each instruction was executed in the counts of each path.
#[derive(Debug, Default)]
pub struct Trace {
    /// Every count in the order of its execution.
    pub counts: Vec<Count>,
    /// Of each count, which kind of event it is of: a tick, a sample or a frame.
    pub kinds: Vec<Option<usize>>,
    /// For each count, the blocks that were executed and how often.
    executions: Vec<HashMap<usize, Executions>>,
    blocks: Vec<Block>,
}

/// Runs the image's single-precision paths under trace.
///
/// # Errors
/// [`RunError`]; [`RunError::Trace`] when the emulator was built without its disassembler.
pub fn single_precision(image: &FilePath) -> Result<Trace, RunError> {
    run(image, "f32")
}

/// Runs everything that the image holds under trace.
///
/// # Errors
/// As [`single_precision`].
pub fn everything(image: &FilePath) -> Result<Trace, RunError> {
    run(image, "all")
}

fn run(image: &FilePath, argument: &str) -> Result<Trace, RunError> {
    let mut reader = Reader::new(&Elf::read(image).map_err(|error| RunError::Trace(error.to_string()))?)?;
    emulation::run(image, &LOG, argument, |line| reader.line(line))?;
    reader.finish()
}

impl Trace {
    /// How often each instruction was executed in the given counts. A block's waits stand at its first instruction.
    pub fn instructions(&self, counts: &[usize]) -> Vec<Executed<'_>> {
        let mut all: HashMap<usize, Executions> = HashMap::new();
        for (block, executed) in counts.iter().filter_map(|count| self.executions.get(*count)).flatten() {
            let sum = all.entry(*block).or_default();
            sum.times += executed.times;
            sum.waits += executed.waits;
        }
        let of_block = |(block, Executions { times, waits }): (usize, Executions)| {
            let waits = std::iter::once(waits).chain(std::iter::repeat(0));
            self.blocks[block].instructions.iter().zip(waits).map(move |(one, waits)| (one, times, waits))
        };
        all.into_iter().flat_map(of_block).collect()
    }
}

/// Reads the log line by line.
struct Reader {
    marks: [u64; 2],
    mark_sizes: [u64; 2],
    kinds: [Option<u64>; 3],
    /// The kind of the next count.
    kind: Option<usize>,
    /// Instructions of the block that was translated last, until it is executed.
    translated: Vec<Instruction>,
    /// Blocks by the address of their translation.
    known: HashMap<u64, usize>,
    /// The block of the line before: the next line may say that it was not executed.
    last: Option<usize>,
    open: bool,
    /// Where code lies that does not wait.
    ccm: Range<u64>,
    /// One for each of [`PLACEMENTS`], of the count that is open.
    fetches: Vec<Fetch>,
    trace: Trace,
    problem: Option<String>,
}

impl Reader {
    fn new(image: &Elf) -> Result<Self, RunError> {
        let find = |name: &str| image.function(name).map_err(|error| RunError::Trace(error.to_string()));
        let [begin, end] = [find(MARKS[0])?, find(MARKS[1])?];
        let sections = image.sections().map_err(|error| RunError::Trace(error.to_string()))?;
        let ccm = sections.iter().find(|section| section.name == CCM_SECTION);
        Ok(Self {
            ccm: ccm.map_or(0..0, |section| section.address..section.address + section.size_bytes),
            fetches: Vec::new(),
            marks: [begin.address, end.address],
            mark_sizes: [begin.size_bytes, end.size_bytes],
            kinds: KINDS.map(|name| image.function(name).ok().map(|function| function.address)),
            kind: None,
            translated: Vec::new(),
            known: HashMap::new(),
            last: None,
            open: false,
            trace: Trace::default(),
            problem: None,
        })
    }

    fn line(&mut self, line: &[u8]) {
        if line.starts_with(b"Trace ") {
            match std::str::from_utf8(line).ok().and_then(executed) {
                Some((translation, address)) => self.execute(translation, address),
                None => self.complain(line),
            }
        } else if line.starts_with(b"0x") {
            match std::str::from_utf8(line).ok().and_then(instruction) {
                Some(instruction) => self.translated.push(instruction),
                None => self.complain(line),
            }
        } else if line.starts_with(b"Stopped execution") {
            // The block of the line before was not executed after all; it comes again.
            self.last = None;
        } else if line.starts_with(b"OBJD") {
            self.problem.get_or_insert_with(|| "the emulator was built without a disassembler".to_owned());
        }
    }

    fn complain(&mut self, line: &[u8]) {
        self.problem.get_or_insert_with(|| String::from_utf8_lossy(line).into_owned());
    }

    fn execute(&mut self, translation: u64, address: u64) {
        self.count_last();
        if !self.translated.is_empty() {
            let mut instructions = std::mem::take(&mut self.translated);
            pipeline::adjust(&mut instructions);
            let cycles = instructions.iter().map(|one| one.cycles).sum();
            self.trace.blocks.push(Block { instructions, cycles });
            self.known.insert(translation, self.trace.blocks.len() - 1);
        }
        if let Some(mark) =
            (0..2).find(|&mark| (self.marks[mark]..self.marks[mark] + self.mark_sizes[mark]).contains(&address))
        {
            let opens = mark == 0;
            if opens && !self.open {
                self.trace.counts.push(Count::default());
                self.trace.kinds.push(self.kind.take());
                self.trace.executions.push(HashMap::new());
                let placement = |&(_, uses_ccm, prefetch): &(&str, bool, bool)| Placement {
                    ccm: if uses_ccm { self.ccm.clone() } else { 0..0 },
                    prefetch,
                };
                self.fetches = PLACEMENTS.iter().map(placement).map(Fetch::new).collect();
            }
            self.open = opens;
        } else if !self.open {
            self.kind = self.kinds.iter().position(|kind| *kind == Some(address)).or(self.kind);
        } else {
            self.last = self.known.get(&translation).copied();
            if self.last.is_none() {
                self.problem.get_or_insert_with(|| format!("a block at {address:#x} was never translated"));
            }
        }
    }

    /// Counts the block of the line before: nothing has taken it back.
    fn count_last(&mut self) {
        let (Some(at), Some(count), Some(executions)) =
            (self.last.take(), self.trace.counts.last_mut(), self.trace.executions.last_mut())
        else {
            return;
        };
        let block = &self.trace.blocks[at];
        let before = count.cycles();
        count.instructions += block.instructions.len() as u64;
        count.core_cycles += block.cycles;
        for (fetch, fetched) in self.fetches.iter_mut().zip(&mut count.fetched) {
            for one in &block.instructions {
                fetch.execute(one.address, one.bytes, one.cycles, one.is_call());
            }
            *fetched = fetch.cycles();
        }
        let executed = executions.entry(at).or_default();
        executed.times += 1;
        executed.waits += count.cycles() - before - block.cycles;
    }

    fn finish(mut self) -> Result<Trace, RunError> {
        self.count_last();
        match self.problem {
            Some(problem) => Err(RunError::Trace(problem)),
            None => Ok(self.trace),
        }
    }
}

/// `Trace 0: 0x7f6118000100 [00800408/00000048/00000110/ff000200] Reset`: where the translation lies in the emulator,
/// and the address of the block's first instruction on the board.
fn executed(line: &str) -> Option<(u64, u64)> {
    let (_, rest) = line.split_once(": 0x")?;
    let (translation, rest) = rest.split_once(" [")?;
    let address = rest.split('/').nth(1)?;
    Some((u64::from_str_radix(translation, 16).ok()?, u64::from_str_radix(address, 16).ok()?))
}

/// `0x0000004c:  f44f 0170  mov.w    r1, #0xf00000`
fn instruction(line: &str) -> Option<Instruction> {
    let (address, rest) = line.strip_prefix("0x")?.split_once(':')?;
    let is_code = |word: &&str| word.len() == 4 && word.bytes().all(|b| b.is_ascii_hexdigit());
    let mut words = rest.split_ascii_whitespace().peekable();
    // One or two half-words. No mnemonic of four letters is a number in base 16.
    let mut halves = 0;
    while halves < 2 && words.next_if(is_code).is_some() {
        halves += 1;
    }
    let mnemonic = words.next().filter(|_| halves > 0)?.to_owned();
    let operands = words.collect::<Vec<_>>().join(" ");
    let cycles = timing::cycles(&mnemonic, &operands);
    Some(Instruction { address: u64::from_str_radix(address, 16).ok()?, bytes: 2 * halves, mnemonic, operands, cycles })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reader() -> Reader {
        Reader {
            marks: [0x10, 0x20],
            mark_sizes: [8, 8],
            kinds: [None, Some(0x30), None],
            kind: None,
            translated: Vec::new(),
            known: HashMap::new(),
            last: None,
            open: false,
            ccm: 0..0,
            fetches: Vec::new(),
            trace: Trace::default(),
            problem: None,
        }
    }

    #[test]
    fn blocks_between_the_marks_are_counted() {
        let log = "IN: kind_sample\n0x00000030:  bf00  nop\nTrace 0: 0xd [0/00000030/0/0] kind_sample\n\
                   IN: count_begins\n0x00000010:  4770  bx lr\nTrace 0: 0xa [0/00000010/0/0] count_begins\n\
                   IN: f\n0x00000100:  ee30 0a20  vadd.f32 s0, s0, s1\n0x00000104:  d1fc  bne #0x100\n\
                   Trace 0: 0xb [0/00000100/0/0] f\nTrace 0: 0xb [0/00000100/0/0] f\n\
                   Trace 0: 0xb [0/00000100/0/0] f\nStopped execution of TB chain before 0xb [00000100] f\n\
                   IN: count_ends\n0x00000020:  4770  bx lr\nTrace 0: 0xc [0/00000020/0/0] count_ends\n\
                   Trace 0: 0xb [0/00000100/0/0] f\n";
        let mut reader = reader();
        log.lines().for_each(|line| reader.line(line.as_bytes()));
        let trace = reader.finish().unwrap();
        assert_eq!((trace.counts.len(), trace.counts[0].instructions, trace.counts[0].core_cycles), (1, 4, 6));
        // The first read waits; the second time everything is there.
        assert_eq!(trace.counts[0].cycles(), 6 + 4);
        assert_eq!(trace.kinds, [Some(1)]);
        let mut instructions = trace.instructions(&[0]);
        instructions.sort_by_key(|(one, ..)| one.address);
        assert_eq!(
            instructions.iter().map(|(one, times, waits)| (one.address, *times, *waits)).collect::<Vec<_>>(),
            [(0x100, 2, 4), (0x104, 2, 0)]
        );
    }

    #[test]
    fn an_instruction_is_read_with_its_operands() {
        let one = instruction("0x0000004c:  f44f 0170  mov.w    r1, #0xf00000").unwrap();
        assert_eq!((one.address, one.mnemonic.as_str(), one.operands.as_str()), (0x4c, "mov.w", "r1, #0xf00000"));
        assert_eq!(instruction("0x00000050:  2200       movs     r2, #0").unwrap().mnemonic, "movs");
        assert_eq!(instruction("0x00000050:  "), None);
    }

    #[test]
    fn a_log_without_disassembly_is_an_error() {
        let mut reader = reader();
        reader.line(b"OBJD-T: 25f09efb");
        assert!(matches!(reader.finish(), Err(RunError::Trace(_))));
    }
}
