//! The chip's registers, read from two descriptions that were made apart from each other: the one that the firmware's
//! driver writes through (`stm32-metapac`) and ST's own (`stm32g4`, made from ST's SVD file).
//!
//! The model takes reset values and defined bits from the second one. [`compare`] holds the first one against it.

pub mod compare;
pub mod driver;
pub mod known;
pub mod lists;
pub mod touched;
pub mod vendor;

use std::collections::{BTreeMap, BTreeSet};

/// The peripherals that the image touches: name, address, and the vendor's name of the register block.
pub const PERIPHERALS: [Peripheral; 16] = [
    Peripheral { name: "TIM1", from: 0x4001_2C00, block: "tim1" },
    Peripheral { name: "TIM2", from: 0x4000_0000, block: "tim2" },
    Peripheral { name: "TIM3", from: 0x4000_0400, block: "tim3" },
    Peripheral { name: "TIM4", from: 0x4000_0800, block: "tim3" },
    Peripheral { name: "TIM5", from: 0x4000_0C00, block: "tim2" },
    Peripheral { name: "TIM8", from: 0x4001_3400, block: "tim1" },
    Peripheral { name: "IWDG", from: 0x4000_3000, block: "iwdg" },
    Peripheral { name: "FDCAN1", from: 0x4000_6400, block: "fdcan" },
    Peripheral { name: "PWR", from: 0x4000_7000, block: "pwr" },
    Peripheral { name: "SYSCFG", from: 0x4001_0000, block: "syscfg" },
    Peripheral { name: "RCC", from: 0x4002_1000, block: "rcc" },
    Peripheral { name: "FLASH", from: 0x4002_2000, block: "flash" },
    Peripheral { name: "GPIOA", from: 0x4800_0000, block: "gpioa" },
    Peripheral { name: "GPIOB", from: 0x4800_0400, block: "gpiob" },
    Peripheral { name: "GPIOC", from: 0x4800_0800, block: "gpioc" },
    Peripheral { name: "DBGMCU", from: 0xE004_2000, block: "dbgmcu" },
];

/// A peripheral of the chip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Peripheral {
    /// Its name in the reference manual.
    pub name: &'static str,
    /// Address of its first register.
    pub from: u32,
    /// Name of its register block in the vendor's description.
    pub block: &'static str,
}

/// Bits of a register that belong together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Bits {
    /// The lowest of them.
    pub from: u32,
    /// How many.
    pub width: u32,
}

/// What lies at one address. Two registers can share it (a timer's capture and compare modes): these are joined.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Register {
    /// Its name; of several, the first.
    pub name: String,
    /// Fields, with their names in capitals.
    pub fields: BTreeMap<Bits, BTreeSet<String>>,
    /// The value after a reset, where the description has it.
    pub reset: Option<u32>,
}

impl Register {
    /// All bits that a field has.
    pub fn defined(&self) -> u32 {
        self.fields.keys().fold(0, |bits, field| bits | mask(*field))
    }
}

/// A field's bits as a mask.
pub fn mask(bits: Bits) -> u32 {
    (((1_u64 << bits.width) - 1) << bits.from) as u32
}

/// The registers of a peripheral by their distance from its address.
pub type Block = BTreeMap<u32, Register>;
