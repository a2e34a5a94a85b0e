//! Would the drive board start this image? What its ELF file says of entry, vectors and memory, held against the chip.

use std::fmt;

use crate::elf::{Elf, ElfError, Section, Segment};
use crate::memory::{Memory, Range};

/// The first bank of the flash: the program's (RM0440, section 3).
const PROGRAM: Range = Memory::DRIVE_BOARD.flash;
/// The last six pages of the second bank: the storage's.
const RECORD: Range = Range { from: 0x0807_D000, end: 0x0808_0000 };
/// The core-coupled memory (RM0440, section 2), which runs code (see [`crate::ccm_code`]).
const CCM: Range = Memory::DRIVE_BOARD.ccm;
/// SRAM1 and SRAM2 (RM0440, section 2).
const RAM: Range = Range { from: 0x2000_0000, end: 0x2001_8000 };

/// Most flash that the image may take, of the 256 KiB that the program has (`memory.x`). It was 200 KiB while an image was for a
/// ball alone; one image for every module holds the hinge's estimator and procedure as well.
pub const MOST_FLASH_BYTES: u64 = 248 * 1024;
/// Most RAM that the static variables may take.
pub const MOST_STATIC_BYTES: u64 = 40 * 1024;

/// The vectors that must be the firmware's own, by their place in the table (PM0214, 2.3.4; RM0440, table 97).
const OWN_VECTORS: [(usize, &str); 5] =
    [(1, "Reset"), (2, "NonMaskableInt"), (3, "HardFault"), (15, "SysTick"), (16 + 21, "FDCAN1_IT0")];
/// Vectors of the chip: the core's 16 and 102 interrupts.
const VECTORS: usize = 16 + 102;

/// What the image says of itself.
#[derive(Debug, Clone)]
pub struct Facts {
    /// Where a debugger starts it.
    pub entry: u64,
    /// Its sections.
    pub sections: Vec<Section>,
    /// What is written to the flash, and what is cleared.
    pub segments: Vec<Segment>,
    /// The vector table, word by word.
    pub vectors: Vec<u32>,
    /// Addresses of the handlers that must be the firmware's own: reset, NMI, hard fault, core timer, CAN.
    pub handlers: [u64; OWN_VECTORS.len()],
    /// Where the code lies.
    pub code: Range,
    /// Where the stack lies, without its guard's alignment.
    pub stack: Range,
    /// Where the record lies.
    pub record: Range,
    /// Memory that start-up leaves alone.
    pub left_alone: Range,
    /// Address of the crash record.
    pub crash_record: u64,
}

/// What is wrong with an image.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Fault {
    /// The entry is not the reset handler.
    Entry(u64),
    /// The vector table does not begin where the flash does, or has another length.
    VectorTable,
    /// The first vector is not the end of the RAM.
    StackPointer(u32),
    /// A vector leads to another handler.
    Handler(&'static str),
    /// A vector leads out of the code, or into the wrong instruction set.
    StrayVector(usize),
    /// A segment would be written to, or lie in, memory that is not the program's.
    Misplaced(u64),
    /// Two sections of the RAM overlap.
    Overlap(String),
    /// The storage lies elsewhere than in the chip's last six pages.
    Record,
    /// The crash record would be cleared by start-up.
    CrashRecord(u64),
    /// The image takes more flash than it may.
    Flash(u64),
    /// The static variables take more RAM than they may.
    StaticRam(u64),
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Entry(address) => write!(f, "the entry {address:#x} is not the reset handler"),
            Self::VectorTable => write!(f, "the vector table has another place or length than the chip's"),
            Self::StackPointer(address) => write!(f, "the stack begins at {address:#x}, not at the end of the RAM"),
            Self::Handler(name) => write!(f, "the vector of {name} leads elsewhere"),
            Self::StrayVector(index) => write!(f, "vector {index} leads to no code"),
            Self::Misplaced(address) => write!(f, "the segment at {address:#x} is not where the program's memory is"),
            Self::Overlap(name) => write!(f, "the section {name} overlaps the one before it"),
            Self::Record => write!(f, "the storage is not in the last six pages of the flash"),
            Self::CrashRecord(address) => write!(f, "start-up would clear the crash record at {address:#x}"),
            Self::Flash(bytes) => write!(f, "{bytes} bytes of flash, {MOST_FLASH_BYTES} at most"),
            Self::StaticRam(bytes) => write!(f, "{bytes} bytes of static RAM, {MOST_STATIC_BYTES} at most"),
        }
    }
}

impl std::error::Error for Fault {}

impl Facts {
    /// Reads them from the image.
    ///
    /// # Errors
    /// [`ElfError`].
    pub fn read(image: &Elf) -> Result<Self, ElfError> {
        let range = |from, end| Ok::<_, ElfError>(Range { from: image.symbol(from)?, end: image.symbol(end)? });
        let mut handlers = [0; OWN_VECTORS.len()];
        for (address, (_, name)) in handlers.iter_mut().zip(OWN_VECTORS) {
            *address = image.function(name)?.address;
        }
        Ok(Self {
            entry: image.entry()?,
            sections: image.sections()?,
            segments: image.segments()?,
            vectors: image.words(".vector_table")?,
            handlers,
            code: range("__stext", "__etext")?,
            stack: range("_stack_end", "_stack_start")?,
            record: range("_record_start", "_record_end")?,
            left_alone: range("__suninit", "__euninit")?,
            crash_record: image.symbol_ending_with("retained_ram::PLACE")?,
        })
    }

    /// Flash that the image takes, bytes.
    pub fn flash_bytes(&self) -> u64 {
        self.segments.iter().map(|segment| segment.stored_bytes).sum()
    }

    /// RAM that the static variables take, bytes.
    pub fn static_bytes(&self) -> u64 {
        self.sections.iter().filter(|section| section.in_ram).map(|section| section.size_bytes).sum()
    }

    /// Everything that is wrong; nothing when the board would start it.
    pub fn faults(&self) -> Vec<Fault> {
        let mut faults = Vec::new();
        let [reset, ..] = self.handlers;
        if self.entry != thumb(reset) {
            faults.push(Fault::Entry(self.entry));
        }
        self.check_vectors(&mut faults);
        self.check_memory(&mut faults);
        if self.record != RECORD {
            faults.push(Fault::Record);
        }
        if !self.left_alone.holds(self.crash_record, 4) {
            faults.push(Fault::CrashRecord(self.crash_record));
        }
        if self.flash_bytes() > MOST_FLASH_BYTES {
            faults.push(Fault::Flash(self.flash_bytes()));
        }
        if self.static_bytes() > MOST_STATIC_BYTES {
            faults.push(Fault::StaticRam(self.static_bytes()));
        }
        faults
    }

    fn check_vectors(&self, faults: &mut Vec<Fault>) {
        let table = self.sections.iter().find(|section| section.name == ".vector_table");
        if table.is_none_or(|table| table.address != PROGRAM.from) || self.vectors.len() != VECTORS {
            faults.push(Fault::VectorTable);
        }
        let mut vectors = self.vectors.iter().copied();
        let stack_pointer = vectors.next().unwrap_or_default();
        if u64::from(stack_pointer) != RAM.end || self.stack.end != RAM.end {
            faults.push(Fault::StackPointer(stack_pointer));
        }
        for ((index, name), handler) in OWN_VECTORS.into_iter().zip(self.handlers) {
            if self.vectors.get(index).is_none_or(|vector| u64::from(*vector) != thumb(handler)) {
                faults.push(Fault::Handler(name));
            }
        }
        for (index, vector) in self.vectors.iter().enumerate().skip(1) {
            let is_code = vector & 1 == 1 && self.code.holds(u64::from(vector & !1), 2);
            // the table has gaps, which the chip never takes
            if *vector != 0 && !is_code {
                faults.push(Fault::StrayVector(index));
            }
        }
    }

    fn check_memory(&self, faults: &mut Vec<Fault>) {
        for segment in &self.segments {
            let stored = PROGRAM.holds(segment.stored_at, segment.stored_bytes) || segment.stored_bytes == 0;
            let memories: &[Range] = if segment.writable { &[RAM] } else { &[PROGRAM, CCM] };
            let placed = memories.iter().any(|memory| memory.holds(segment.address, segment.size_bytes));
            if !(stored && placed) {
                faults.push(Fault::Misplaced(segment.address));
            }
        }
        let mut end = 0;
        for section in self.sections.iter().filter(|section| section.in_ram) {
            if section.address < end {
                faults.push(Fault::Overlap(section.name.clone()));
            }
            end = section.address + section.size_bytes;
        }
        if self.stack.from < end {
            faults.push(Fault::Overlap("stack".to_owned()));
        }
    }
}

/// The address of a function as vectors and entries hold it: bit 0 says Thumb.
const fn thumb(address: u64) -> u64 {
    address | 1
}

#[cfg(test)]
mod tests;
