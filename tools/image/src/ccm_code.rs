//! Does the code that asks for it lie in the core-coupled memory, and where the image copies it from?

use std::collections::BTreeSet;
use std::fmt;

use crate::elf::{Elf, Segment, Symbol};
use crate::memory::{Memory, Range};
use crate::stack_bound::{CallGraph, StackError};

/// The section that it lies in (`ccm.x`).
pub const SECTION: &str = ".ccm_code";

/// A veneer bears this and the name of the function that it leads to. It lies in the memory of whoever calls.
const VENEER: &str = "__Thumbv7ABSLongThunk_";

/// The code in the core-coupled memory of an image.
#[derive(Debug, Clone)]
pub struct CcmCode {
    /// Its functions.
    pub functions: Vec<Symbol>,
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
    /// No function asks for the memory: the library was compiled without its feature.
    Empty,
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
            Self::Empty => write!(f, "no function asks for the core-coupled memory"),
            Self::Misplaced(at) => write!(f, "the code at {at:#x} is not in the core-coupled memory"),
            Self::Filled(Range { from, end }) => write!(f, "{from:#x} to {end:#x} is filled, which is not the code"),
            Self::CopiedFrom(at) => write!(f, "the code is copied from {at:#x}, where it is not stored"),
            Self::Stored(at) => write!(f, "the code is stored at {at:#x}, which is not free flash"),
            Self::CalledByException(at) => write!(f, "an exception may call the code at {at:#x}"),
        }
    }
}

impl std::error::Error for Fault {}

impl CcmCode {
    /// Reads it from the image.
    ///
    /// # Errors
    /// [`StackError`], since the calls are followed.
    pub fn read(image: &Elf) -> Result<Self, StackError> {
        let section = image.sections()?.into_iter().find(|section| section.name == SECTION);
        let code = section.map_or(Range { from: 0, end: 0 }, |section| Range {
            from: section.address,
            end: section.address + section.size_bytes,
        });
        let mut functions = image.code()?.functions;
        functions.retain(|function| {
            code.holds(function.address, function.size_bytes) && !function.linker_name.starts_with(VENEER)
        });
        Ok(Self {
            functions,
            code,
            segments: image.segments()?,
            filled: Range { from: image.symbol("_ccm_code_start")?, end: image.symbol("_ccm_code_end")? },
            copied_from: image.symbol("_ccm_code_stored")?,
            called_by_exceptions: called_by_exceptions(&CallGraph::read(image)?),
        })
    }

    /// Everything that is wrong.
    pub fn faults(&self, memory: Memory) -> Vec<Fault> {
        let Self { functions, code, segments, filled, copied_from, called_by_exceptions } = self;
        let mut faults = Vec::new();
        if functions.is_empty() {
            faults.push(Fault::Empty);
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

#[cfg(test)]
mod tests;
