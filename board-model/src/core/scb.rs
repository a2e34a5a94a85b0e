//! The system control block, the cycle counter and the floating-point registers of the private peripheral bus.

use super::nvic::{Nvic, exception};
use crate::breach::{Breaches, Rule};

/// Bits of CFSR that this model sets (ARMv7-M ARM, B3.2.15).
pub mod cfsr {
    /// An access to data was forbidden.
    pub const DACCVIOL: u32 = 1 << 1;
    /// Fetching an instruction was forbidden.
    pub const IACCVIOL: u32 = 1;
    /// An exception's frame could not be stored.
    pub const MSTKERR: u32 = 1 << 4;
    /// MMFAR holds the address.
    pub const MMARVALID: u32 = 1 << 7;
    /// No memory at the address of an instruction.
    pub const IBUSERR: u32 = 1 << 8;
    /// No memory at the address of an access.
    pub const PRECISERR: u32 = 1 << 9;
    /// BFAR holds the address.
    pub const BFARVALID: u32 = 1 << 15;
    /// No such instruction.
    pub const UNDEFINSTR: u32 = 1 << 16;
}

/// The key that a write to AIRCR must carry.
const VECTKEY: u32 = 0x05FA;
const SYSRESETREQ: u32 = 1 << 2;

/// The registers.
#[derive(Debug, Clone, Default)]
pub struct Scb {
    /// Where the vectors are.
    pub vtor: u32,
    /// Access to the floating-point unit.
    pub cpacr: u32,
    /// What went wrong.
    pub cfsr: u32,
    /// Whether a fault was escalated.
    pub hfsr: u32,
    /// Address of a forbidden access.
    pub mmfar: u32,
    /// Address of an access to nothing.
    pub bfar: u32,
    /// Trace is on: the cycle counter can be.
    demcr: u32,
    counter_on: bool,
    counter_from: u64,
    others: std::collections::BTreeMap<u32, u32>,
}

impl Scb {
    /// Reads from 0xE000E000 on, what no other block has; or from the counter's registers.
    pub fn read(&self, address: u32, cycle: u64, nvic: &Nvic) -> u32 {
        match address {
            0xE000_ED00 => 0x410F_C241,
            0xE000_ED04 => {
                let pending = if nvic.is_pending(exception::SYS_TICK) { 1 << 26 } else { 0 };
                pending | nvic.current() as u32
            }
            0xE000_ED08 => self.vtor,
            0xE000_ED0C => 0xFA05_0000,
            0xE000_ED18..0xE000_ED24 => (0..4).fold(0, |word, byte| {
                let number = (address - 0xE000_ED18 + byte) as usize + 4;
                word | (nvic.priority_of(number).max(0) as u32) << (8 * byte)
            }),
            0xE000_ED28 => self.cfsr,
            0xE000_ED2C => self.hfsr,
            0xE000_ED34 => self.mmfar,
            0xE000_ED38 => self.bfar,
            0xE000_ED88 => self.cpacr,
            0xE000_EDFC => self.demcr,
            0xE000_1000 => 0x4000_0000 | u32::from(self.counter_on),
            0xE000_1004 if self.counter_on => (cycle - self.counter_from) as u32,
            _ => self.others.get(&address).copied().unwrap_or(0),
        }
    }

    /// Writes `size` bytes; true if a reset is asked for.
    pub fn write(
        &mut self,
        address: u32,
        (size, value): (u32, u32),
        cycle: u64,
        nvic: &mut Nvic,
        breaches: &mut Breaches,
    ) -> bool {
        match address {
            0xE000_ED04 => {
                if value & 1 << 28 != 0 {
                    nvic.pend(exception::PEND_SV);
                }
                if value & 1 << 26 != 0 {
                    nvic.pend(exception::SYS_TICK);
                }
                if value & 1 << 25 != 0 {
                    nvic.unpend(exception::SYS_TICK);
                }
            }
            0xE000_ED08 => self.vtor = value & !0x7F,
            0xE000_ED0C if value >> 16 == VECTKEY => return value & SYSRESETREQ != 0,
            0xE000_ED0C => breaches.add(Rule::WrongKey, format!("AIRCR: {value:#x}")),
            0xE000_ED18..0xE000_ED24 => (0..size).for_each(|byte| {
                let number = (address - 0xE000_ED18 + byte) as usize + 4;
                nvic.set_priority(number, (value >> (8 * byte)) as u8);
            }),
            0xE000_ED28 => self.cfsr &= !value,
            0xE000_ED2C => self.hfsr &= !value,
            0xE000_ED88 => self.cpacr = value,
            0xE000_EDFC => self.demcr = value,
            0xE000_1000 => {
                if value & 1 != 0 && self.demcr & 1 << 24 == 0 {
                    breaches.add(Rule::Protected, "DWT: the cycle counter while DEMCR.TRCENA is 0");
                }
                if value & 1 != 0 && !self.counter_on {
                    self.counter_from = cycle;
                }
                self.counter_on = value & 1 != 0;
            }
            0xE000_1004 => self.counter_from = cycle.wrapping_sub(value.into()),
            _ => drop(self.others.insert(address, value)),
        }
        false
    }
}
