//! Does the code that `hot.x` lists lie in the core-coupled memory, and where the image copies it from?
//!
//! A pattern that no longer matches would be passed over by the linker without a word: the function would run from flash
//! again, right and slow.

use std::collections::BTreeSet;
use std::fmt;

use crate::drive_board_image::Range;
use crate::elf::{Elf, Segment, Symbol};
use crate::stack_bound::{CallGraph, StackError};

/// The linker script that lists the code.
const SCRIPT: &str = include_str!("../../../hot.x");

/// The section that it lies in.
pub const SECTION: &str = ".hot";

/// What every function of the image is compiled into: this, and its name.
const OF_A_FUNCTION: &str = ".text.";

/// A veneer bears this and the name of the function that it leads to. It lies in the memory of whoever calls.
const VENEER: &str = "__Thumbv7ABSLongThunk_";

/// Where a board has its core-coupled memory and its program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Memory {
    /// Where the code runs.
    pub ccm: Range,
    /// Where it is stored.
    pub flash: Range,
}

impl Memory {
    /// The drive board's (RM0440, sections 2 and 3).
    pub const DRIVE_BOARD: Self = Self {
        ccm: Range { from: 0x1000_0000, end: 0x1000_8000 },
        flash: Range { from: 0x0800_0000, end: 0x0804_0000 },
    };
    /// The emulated board's: where the drive board's chip shows the same memory for the second time.
    pub const EMULATED: Self = Self {
        ccm: Range { from: 0x2001_8000, end: 0x2002_0000 },
        flash: Range { from: 0x0000_0000, end: 0x0004_0000 },
    };
}

/// One line of the list.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Line {
    /// The sections that it takes, with asterisks.
    pub pattern: String,
    /// The functions that the image has of it.
    pub functions: Vec<Symbol>,
}

/// The hot code of an image.
#[derive(Debug, Clone)]
pub struct HotCode {
    /// The list.
    pub lines: Vec<Line>,
    /// Where the code lies; empty when the image has none.
    pub code: Range,
    /// What is stored in the flash, and where.
    pub segments: Vec<Segment>,
    /// What the image fills before it calls any of it.
    pub filled: Range,
    /// Where the image copies it from.
    pub copied_from: u64,
    /// First addresses of everything that an exception or interrupt may call. The fault handlers are among them, and the
    /// memory may be what is at fault.
    pub called_by_exceptions: BTreeSet<u64>,
}

/// What is wrong with it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Fault {
    /// The image has no function of this line.
    NoFunction(String),
    /// A function of the list lies elsewhere.
    Elsewhere(String, u64),
    /// The code runs elsewhere than in the core-coupled memory.
    Misplaced(u64),
    /// The image fills something else than the code.
    Filled(Range),
    /// The image copies from where the code is not stored.
    CopiedFrom(u64),
    /// It is stored outside of the flash, or over something else.
    Stored(u64),
    /// An exception or interrupt may call a part of it.
    CalledByException(u64),
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoFunction(pattern) => write!(f, "hot.x: no function of the image is {pattern}"),
            Self::Elsewhere(name, at) => write!(f, "{name} is to be hot code and lies at {at:#x}"),
            Self::Misplaced(at) => write!(f, "the hot code at {at:#x} is not in the core-coupled memory"),
            Self::Filled(Range { from, end }) => {
                write!(f, "{from:#x} to {end:#x} is filled, which is not the hot code")
            }
            Self::CopiedFrom(at) => write!(f, "the hot code is copied from {at:#x}, where it is not stored"),
            Self::Stored(at) => write!(f, "the hot code is stored at {at:#x}, which is not free flash"),
            Self::CalledByException(at) => write!(f, "an exception may call the hot code at {at:#x}"),
        }
    }
}

impl std::error::Error for Fault {}

impl HotCode {
    /// Reads it from the image.
    ///
    /// # Errors
    /// [`StackError`], since the calls are followed.
    pub fn read(image: &Elf) -> Result<Self, StackError> {
        let mut functions = image.code()?.functions;
        functions.retain(|function| !function.linker_name.starts_with(VENEER));
        let of = |pattern: &str| {
            let taken = |function: &&Symbol| matches(pattern, &format!("{OF_A_FUNCTION}{}", function.linker_name));
            functions.iter().filter(taken).cloned().collect()
        };
        let section = image.sections()?.into_iter().find(|section| section.name == SECTION);
        Ok(Self {
            lines: patterns().map(|pattern| Line { pattern: pattern.to_owned(), functions: of(pattern) }).collect(),
            code: section.map_or(Range { from: 0, end: 0 }, |section| Range {
                from: section.address,
                end: section.address + section.size_bytes,
            }),
            segments: image.segments()?,
            filled: Range { from: image.symbol("_hot_start")?, end: image.symbol("_hot_end")? },
            copied_from: image.symbol("_hot_stored")?,
            called_by_exceptions: called_by_exceptions(&CallGraph::read(image)?),
        })
    }

    /// Everything that is wrong.
    pub fn faults(&self, memory: Memory) -> Vec<Fault> {
        let Self { lines, code, segments, filled, copied_from, called_by_exceptions } = self;
        let mut faults = Vec::new();
        for line in lines {
            if line.functions.is_empty() {
                faults.push(Fault::NoFunction(line.pattern.clone()));
            }
            let elsewhere = line.functions.iter().filter(|function| !code.holds(function.address, function.size_bytes));
            faults.extend(elsewhere.map(|function| Fault::Elsewhere(function.name.clone(), function.address)));
        }
        if !memory.ccm.holds(code.from, self.bytes()) {
            faults.push(Fault::Misplaced(code.from));
        }
        if filled != code {
            faults.push(Fault::Filled(*filled));
        }
        let stored: Vec<&Segment> = segments.iter().filter(|segment| segment.stored_bytes != 0).collect();
        let is_own = |segment: &Segment| segment.address == code.from && segment.stored_at == *copied_from;
        if !stored.iter().any(|segment| is_own(segment)) {
            faults.push(Fault::CopiedFrom(*copied_from));
        }
        let end = copied_from + self.bytes();
        let is_apart = |other: &Segment| other.stored_at >= end || other.stored_at + other.stored_bytes <= *copied_from;
        let is_free = stored.iter().all(|segment| is_own(segment) || is_apart(segment));
        if !(is_free && memory.flash.holds(*copied_from, self.bytes())) {
            faults.push(Fault::Stored(*copied_from));
        }
        faults.extend(called_by_exceptions.range(code.from..code.end).map(|at| Fault::CalledByException(*at)));
        faults
    }

    /// Bytes of the core-coupled memory that it takes, veneers included.
    pub fn bytes(&self) -> u64 {
        self.code.end - self.code.from
    }
}

/// All that the handlers behind the first one, which is the program's own start, may call.
fn called_by_exceptions(graph: &CallGraph) -> BTreeSet<u64> {
    let mut called = BTreeSet::new();
    let mut open: Vec<u64> = graph.handlers.iter().skip(1).copied().collect();
    while let Some(at) = open.pop() {
        if called.insert(at) {
            open.extend(graph.functions.get(&at).into_iter().flat_map(|function| graph.callees(function)));
        }
    }
    called
}

/// The patterns of the script: `*(pattern)`, a line each.
fn patterns() -> impl Iterator<Item = &'static str> {
    SCRIPT.lines().filter_map(|line| line.trim().strip_prefix("*(")?.strip_suffix(')'))
}

/// An asterisk stands for any number of characters, as in a linker script.
fn matches(pattern: &str, name: &str) -> bool {
    match pattern.split_once('*') {
        None => pattern == name,
        Some((begin, rest)) => name
            .strip_prefix(begin)
            .is_some_and(|name| (0..=name.len()).any(|at| name.get(at..).is_some_and(|name| matches(rest, name)))),
    }
}

#[cfg(test)]
mod tests;
