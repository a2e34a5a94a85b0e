//! Counting each instruction by itself, from the emulator's log.
//!
//! With `-d in_asm,exec,nochain` QEMU writes each block of instructions once, when it is translated, and a line each
//! time that it is executed. The image's two marks divide the executions into counts; the sum over the instructions of
//! a count must agree with the ticks of [`run`](super::run), which is measured in another way.

use std::collections::HashMap;
use std::path::Path as FilePath;

use super::emulation::{self, RunError};
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
    /// Estimated cycles.
    pub cycles: u64,
}

/// The counts of a traced run, and how often each instruction was executed in the counts of each path.
#[derive(Debug, Default)]
pub struct Trace {
    /// Every count in the order of its execution.
    pub counts: Vec<Count>,
    /// Of each count, which kind of event it is of: a tick, a sample or a frame.
    pub kinds: Vec<Option<usize>>,
    /// For each count, the blocks that were executed and how often.
    executions: Vec<HashMap<usize, u64>>,
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
    /// How often each instruction was executed in the given counts.
    pub fn instructions(&self, counts: &[usize]) -> Vec<(&Instruction, u64)> {
        let mut times: HashMap<usize, u64> = HashMap::new();
        for (block, executed) in counts.iter().filter_map(|count| self.executions.get(*count)).flatten() {
            *times.entry(*block).or_default() += executed;
        }
        times
            .into_iter()
            .flat_map(|(block, times)| self.blocks[block].instructions.iter().map(move |one| (one, times)))
            .collect()
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
    last: Option<usize>,
    open: bool,
    trace: Trace,
    problem: Option<String>,
}

impl Reader {
    fn new(image: &Elf) -> Result<Self, RunError> {
        let find = |name: &str| image.function(name).map_err(|error| RunError::Trace(error.to_string()));
        let [begin, end] = [find(MARKS[0])?, find(MARKS[1])?];
        Ok(Self {
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
            self.take_back();
        } else if line.starts_with(b"OBJD") {
            self.problem.get_or_insert_with(|| "the emulator was built without a disassembler".to_owned());
        }
    }

    fn complain(&mut self, line: &[u8]) {
        self.problem.get_or_insert_with(|| String::from_utf8_lossy(line).into_owned());
    }

    fn execute(&mut self, translation: u64, address: u64) {
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
            self.last = None;
            let opens = mark == 0;
            if opens && !self.open {
                self.trace.counts.push(Count::default());
                self.trace.kinds.push(self.kind.take());
                self.trace.executions.push(HashMap::new());
            }
            self.open = opens;
            return;
        }
        self.last = None;
        if !self.open {
            self.kind = self.kinds.iter().position(|kind| *kind == Some(address)).or(self.kind);
            return;
        }
        let Some(&block) = self.known.get(&translation) else {
            self.problem.get_or_insert_with(|| format!("a block at {address:#x} was never translated"));
            return;
        };
        if let (Some(count), Some(executions)) = (self.trace.counts.last_mut(), self.trace.executions.last_mut()) {
            count.instructions += self.trace.blocks[block].instructions.len() as u64;
            count.cycles += self.trace.blocks[block].cycles;
            *executions.entry(block).or_default() += 1;
            self.last = Some(block);
        }
    }

    fn take_back(&mut self) {
        let Some(block) = self.last.take() else { return };
        if let (Some(count), Some(executions)) = (self.trace.counts.last_mut(), self.trace.executions.last_mut()) {
            count.instructions -= self.trace.blocks[block].instructions.len() as u64;
            count.cycles -= self.trace.blocks[block].cycles;
            executions.entry(block).and_modify(|times| *times -= 1);
        }
    }

    fn finish(self) -> Result<Trace, RunError> {
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
    Some(Instruction { address: u64::from_str_radix(address, 16).ok()?, mnemonic, operands, cycles })
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
        assert_eq!(trace.counts, [Count { instructions: 4, cycles: 6 }]);
        assert_eq!(trace.kinds, [Some(1)]);
        let mut instructions = trace.instructions(&[0]);
        instructions.sort_by_key(|(one, _)| one.address);
        assert_eq!(
            instructions.iter().map(|(one, times)| (one.address, *times)).collect::<Vec<_>>(),
            [(0x100, 2), (0x104, 2)]
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
