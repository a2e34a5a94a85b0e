//! Why nothing was loaded, and why nothing was stored.

/// Why there is no record to start with. The device then starts without a centre.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum LoadError {
    /// No record was ever completed. Not a fault: so it is on a new board.
    Nothing = 1,
    /// The flash could not be read.
    Unreadable = 2,
    /// A record was completed, and its CRC is wrong now.
    Damaged = 3,
    /// It was written by older firmware, in a layout that this firmware does not read.
    OlderVersion = 4,
    /// It was written by newer firmware.
    FromTheFuture = 5,
    /// It was found on another rig.
    OtherRig = 6,
    /// Its CRC is right, and its numbers cannot be those of a calibration.
    Unfit = 7,
    /// The flash is divided otherwise than the board's firmware expects. Said by the board, which then never asks.
    FlashLayout = 8,
}

impl LoadError {
    /// The number that stands for this error. Never renumbered.
    pub const fn code(self) -> u8 {
        self as u8
    }
}

impl core::fmt::Display for LoadError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Nothing => "no record was ever completed",
            Self::Unreadable => "the flash cannot be read",
            Self::Damaged => "the record's CRC is wrong",
            Self::OlderVersion => "the record is of an older version",
            Self::FromTheFuture => "the record was written by newer firmware",
            Self::OtherRig => "the record is of another rig",
            Self::Unfit => "the record's numbers cannot be those of a calibration",
            Self::FlashLayout => "the flash is divided otherwise than expected",
        })
    }
}

impl core::error::Error for LoadError {}

/// Why a record was not stored. The one that was there before still is, unless said otherwise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum StoreError {
    /// The numbers cannot be those of a calibration.
    Unfit = 16,
    /// The flash refused to erase: it is write-protected, or not set up as this board expects.
    EraseRefused = 17,
    /// The flash says that it has erased, and the page is not blank: it is worn.
    EraseIncomplete = 18,
    /// The flash refused to write: it is write-protected, or not set up as this board expects.
    WriteRefused = 19,
    /// What was read back is not what was written: the page is worn. The next power-up may find either record.
    ReadBackDiffers = 20,
    /// The flash is divided otherwise than the board's firmware expects. Said by the board, which then never tries.
    FlashLayout = 21,
}

impl StoreError {
    /// The number that stands for this error. Never renumbered; distinct from those of [`LoadError`].
    pub const fn code(self) -> u8 {
        self as u8
    }
}

impl core::fmt::Display for StoreError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Unfit => "the numbers cannot be those of a calibration",
            Self::EraseRefused => "the flash refuses to erase",
            Self::EraseIncomplete => "the flash is worn: an erased page is not blank",
            Self::WriteRefused => "the flash refuses to write",
            Self::ReadBackDiffers => "the flash is worn: it reads back other data than were written",
            Self::FlashLayout => "the flash is divided otherwise than expected",
        })
    }
}

impl core::error::Error for StoreError {}
