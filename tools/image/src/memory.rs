//! Ranges of addresses, and where the boards have their memories.

/// From an address to one behind the end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Range {
    /// First address.
    pub from: u64,
    /// First address behind.
    pub end: u64,
}

impl Range {
    /// It lies in it from its first byte to its last.
    pub fn holds(self, from: u64, size_bytes: u64) -> bool {
        from >= self.from && from + size_bytes <= self.end
    }
}

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
