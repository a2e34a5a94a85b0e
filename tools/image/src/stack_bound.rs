//! How deep the stack of an image can get at the very most, from the image alone.
//!
//! ```text
//! ELF ──► instructions ──► call graph ──► bound of each root ──► beside the room that there is
//!         what moves the    who calls      main, exceptions,
//!         stack pointer     whom           interrupts
//! ```
//!
//! Everything errs to the safe side. A function's frame is the sum of all that it ever takes off the stack pointer. A
//! call through a pointer may reach every function whose address stands anywhere in the image. A jump out of a function
//! counts as a call, and so does the linker's veneer before a function in another memory. What cannot be bounded, such
//! as a stack pointer computed at run time, is refused by name.
//!
//! One thing is assumed and not read off: functions that call each other in a circle go round at most
//! [`MOST_ROUNDS`] times. In the images these are the functions that write text, and the parts of a text are nested
//! at most that deep.
//!
//! The end of a program, last words and a reset, is counted apart: it lets in no interrupt before it does anything, which
//! is read off its instructions, and never comes back. So it stands on the stack at most [`MOST_ENDINGS`] times, and not
//! once on top of every root.

mod call_graph;
mod constants;
mod depth;
mod instructions;
mod veneer;

pub use call_graph::{CallGraph, Function};
pub use depth::{Bound, MOST_ROUNDS, Root};
pub use instructions::{Instruction, decode};

use crate::elf::{Elf, ElfError};
use std::fmt;

/// Bytes that an exception puts on the stack by itself: eight registers, eighteen of the floating-point unit, one word
/// of alignment (ARMv7-M ARM, B1.5.6 and B1.5.7).
pub const EXCEPTION_FRAME_BYTES: u64 = (8 + 18 + 1) * 4;

/// The program's end, begun by the main program or a handler that can be masked; a hard fault within it; and a
/// non-maskable interrupt within that. With interrupts masked nothing else is taken, and of these two neither is taken
/// twice (ARMv7-M ARM, B1.5.4 and B1.5.15).
pub const MOST_ENDINGS: u64 = 3;

/// Length of the guard below the stack and its alignment, as the boards set it.
const GUARD_BYTES: u64 = 4096;

/// Why there is no bound.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum StackError {
    /// The image cannot be read.
    Image(ElfError),
    /// The function computes its stack pointer at run time, at this address.
    Computed(String, u64),
    /// The function calls or jumps to an address where no function begins.
    Nowhere(String, u64),
    /// No function begins where the vector table says so.
    NoHandler(u64),
    /// The function with which the program ends is not there, or interrupts come in while it runs.
    NoEnding,
}

impl fmt::Display for StackError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Image(error) => error.fmt(f),
            Self::Computed(name, at) => write!(f, "{name} computes its stack pointer at run time, at {at:#x}"),
            Self::Nowhere(name, to) => write!(f, "{name} goes to {to:#x}, where no function is"),
            Self::NoEnding => f.write_str("the program has no end that masks the interrupts first"),
            Self::NoHandler(at) => write!(f, "the vector table names {at:#x}, where no function is"),
        }
    }
}

impl std::error::Error for StackError {}

impl From<ElfError> for StackError {
    fn from(error: ElfError) -> Self {
        Self::Image(error)
    }
}

/// The stack of an image: what each root can take, and how much there is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StackUse {
    /// The main program first, then every exception and interrupt that the vector table names.
    pub roots: Vec<Bound>,
    /// What the end of the program takes.
    pub ending_bytes: u64,
    /// The deepest way through it, as of a root.
    pub ending_way: Vec<(String, u64)>,
    /// What lies between the guard and the end of the RAM.
    pub room_bytes: u64,
}

impl StackUse {
    /// Reads it off the image.
    ///
    /// # Errors
    /// [`StackError`].
    pub fn of(image: &Elf) -> Result<Self, StackError> {
        let graph = CallGraph::read(image)?;
        let top = image.symbol("_stack_start")?;
        let guard = image.symbol("_stack_end")?.next_multiple_of(GUARD_BYTES);
        let ending = graph.ending().ok_or(StackError::NoEnding)?;
        let roots = depth::bounds(&graph.without_callees_of(ending))?;
        let (ending_bytes, ending_way) = depth::depth(&graph, ending);
        Ok(Self { roots, ending_bytes, ending_way, room_bytes: top.saturating_sub(guard + GUARD_BYTES) })
    }

    /// All roots at once, each on top of the others: no order of priorities can make it more. Then the end of the
    /// program, and its faults.
    pub fn most_bytes(&self) -> u64 {
        self.roots.iter().map(|root| root.bytes).sum::<u64>() + MOST_ENDINGS * self.ending_bytes
    }

    /// A third of the room is never used.
    pub fn leaves_a_third(&self) -> bool {
        3 * self.most_bytes() <= 2 * self.room_bytes
    }
}
