//! A rule of the chip that the firmware broke.

use std::fmt;

/// Which rule, by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Rule {
    /// A peripheral was touched while its clock was off.
    ClockOff,
    /// A peripheral was touched before its clock had been on for two cycles.
    ClockTooNew,
    /// There is no register at this address.
    NoRegister,
    /// A reserved bit was changed.
    ReservedBit,
    /// A register that only reads was written.
    ReadOnly,
    /// A key register was given something that is no key, or in the wrong order.
    WrongKey,
    /// A register was written that is protected at this time.
    Protected,
    /// The PLL was changed while it ran.
    PllRunning,
    /// A clock was selected that does not run.
    ClockNotReady,
    /// The core runs above 150 MHz without the range 1 boost mode.
    NoBoost,
    /// A clock is faster than the chip bears.
    TooFast,
    /// The flash is read with fewer wait states than its clock needs.
    WaitStates,
    /// The system clock passed 80 MHz while the AHB clock was whole, or this was made whole within a microsecond.
    AhbStep,
    /// A word of the flash was programmed that is not erased.
    NotErased,
    /// The flash was written other than by whole double words.
    FlashAccess,
    /// The flash was worked on while it was busy, or the program's own bank was.
    FlashBusy,
    /// The flash was read through a data cache that knows an older content.
    StaleCache,
    /// A pin or a timer was used that is not set up for it.
    NotSetUp,
    /// An element of the message RAM was used that nobody had written.
    StaleMemory,
    /// The core did what the architecture leaves open.
    Architecture,
}

/// One breach.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Breach {
    /// The rule.
    pub rule: Rule,
    /// What was done.
    pub what: String,
    /// The program counter.
    pub pc: u32,
}

impl fmt::Display for Breach {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}: {}, at {:#010x}", self.rule, self.what, self.pc)
    }
}

/// All breaches of a run. A loop breaks one rule often: each is kept once for each place.
#[derive(Debug, Clone, Default)]
pub struct Breaches {
    /// Where the program stands.
    pub pc: u32,
    found: Vec<Breach>,
}

impl Breaches {
    /// Notes one.
    pub fn add(&mut self, rule: Rule, what: impl Into<String>) {
        let breach = Breach { rule, what: what.into(), pc: self.pc };
        if !self.found.contains(&breach) {
            self.found.push(breach);
        }
    }

    /// Those found.
    pub fn all(&self) -> &[Breach] {
        &self.found
    }

    /// Forgets them.
    pub fn take(&mut self) -> Vec<Breach> {
        std::mem::take(&mut self.found)
    }
}
