//! Which exception is taken, and when (ARMv7-M ARM, B1.5 and B3.4).

/// Interrupts that the model has room for; the chip has 102.
const LINES: usize = 128;
/// The chip implements the upper four bits of a priority.
const PRIORITY_BITS: u8 = 0xF0;

/// Numbers of the core's own exceptions.
pub mod exception {
    /// Non-maskable interrupt.
    pub const NMI: usize = 2;
    /// Hard fault.
    pub const HARD_FAULT: usize = 3;
    /// SVC.
    pub const SV_CALL: usize = 11;
    /// PendSV.
    pub const PEND_SV: usize = 14;
    /// The core's timer.
    pub const SYS_TICK: usize = 15;
    /// The first interrupt of the chip.
    pub const FIRST_INTERRUPT: usize = 16;
}
use exception::{FIRST_INTERRUPT, HARD_FAULT, NMI};

/// What holds exceptions back.
#[derive(Debug, Clone, Copy, Default)]
pub struct Masks {
    /// PRIMASK is set.
    pub primask: bool,
    /// FAULTMASK is set.
    pub faultmask: bool,
    /// BASEPRI; 0 holds nothing back.
    pub basepri: u8,
}

/// The controller.
#[derive(Debug, Clone)]
pub struct Nvic {
    enabled: [bool; LINES],
    pending: [bool; FIRST_INTERRUPT + LINES],
    priority: [u8; FIRST_INTERRUPT + LINES],
    /// Exceptions that run or were interrupted, the innermost last.
    pub active: Vec<usize>,
}

impl Default for Nvic {
    fn default() -> Self {
        Self {
            enabled: [false; LINES],
            pending: [false; FIRST_INTERRUPT + LINES],
            priority: [0; FIRST_INTERRUPT + LINES],
            active: Vec::new(),
        }
    }
}

impl Nvic {
    /// Makes an exception pending.
    pub fn pend(&mut self, number: usize) {
        self.pending[number] = true;
    }

    /// Makes an interrupt of the chip pending.
    pub fn pend_line(&mut self, line: usize) {
        self.pending[FIRST_INTERRUPT + line] = true;
    }

    /// Takes an exception's pending state away.
    pub fn unpend(&mut self, number: usize) {
        self.pending[number] = false;
    }

    /// The exception waits to be taken.
    pub fn is_pending(&self, number: usize) -> bool {
        self.pending[number]
    }

    /// The interrupt of the chip is enabled.
    pub fn is_enabled(&self, line: usize) -> bool {
        self.enabled[line]
    }

    /// Priority of an exception: lower is more urgent.
    pub fn priority_of(&self, number: usize) -> i16 {
        match number {
            NMI => -2,
            HARD_FAULT => -1,
            _ => i16::from(self.priority[number] & PRIORITY_BITS),
        }
    }

    /// Sets the priority of an exception; the lower four bits are not there.
    pub fn set_priority(&mut self, number: usize, priority: u8) {
        self.priority[number] = priority & PRIORITY_BITS;
    }

    /// What runs: 0 for no exception.
    pub fn current(&self) -> usize {
        self.active.last().copied().unwrap_or(0)
    }

    /// The exception to take now, if any.
    pub fn next(&self, masks: Masks) -> Option<usize> {
        let wanted = self.most_urgent()?;
        let mut threshold = self.active.iter().map(|number| self.priority_of(*number)).min().unwrap_or(256);
        if masks.basepri & PRIORITY_BITS != 0 {
            threshold = threshold.min(i16::from(masks.basepri & PRIORITY_BITS));
        }
        if masks.primask {
            threshold = threshold.min(0);
        }
        if masks.faultmask {
            threshold = threshold.min(-1);
        }
        (self.priority_of(wanted) < threshold).then_some(wanted)
    }

    /// An exception would wake the core: it would be taken but for PRIMASK (ARMv7-M ARM, B1.5.19).
    pub fn wakes(&self, masks: Masks) -> bool {
        self.next(Masks { primask: false, ..masks }).is_some()
    }

    /// The pending exception that would be taken first: of equally urgent ones that of the lower number.
    fn most_urgent(&self) -> Option<usize> {
        let counts = |number: usize| {
            self.pending[number] && (number < FIRST_INTERRUPT || self.enabled[number - FIRST_INTERRUPT])
        };
        (1..self.pending.len()).filter(|number| counts(*number)).min_by_key(|number| self.priority_of(*number))
    }

    /// The exception begins.
    pub fn enter(&mut self, number: usize) {
        self.pending[number] = false;
        self.active.push(number);
    }

    /// The innermost exception has returned.
    pub fn leave(&mut self) {
        self.active.pop();
    }

    /// Reads from 0xE000E100 on.
    pub fn read(&self, offset: u32) -> u32 {
        match offset {
            0x000..0x080 => self.word(offset & 0x7F, |line| self.enabled[line]),
            0x080..0x100 => self.word(offset & 0x7F, |line| self.enabled[line]),
            0x100..0x200 => self.word(offset & 0x7F, |line| self.pending[FIRST_INTERRUPT + line]),
            0x200..0x280 => self.word(offset & 0x7F, |line| self.active.contains(&(FIRST_INTERRUPT + line))),
            0x300..0x380 => (0..4).fold(0, |word, byte| {
                word | u32::from(self.priority[FIRST_INTERRUPT + (offset - 0x300 + byte) as usize]) << (8 * byte)
            }),
            _ => 0,
        }
    }

    /// Writes `size` bytes from 0xE000E100 on.
    pub fn write(&mut self, offset: u32, size: u32, value: u32) {
        // lines that the chip does not have stay as they are
        let line_of = move |bit: usize| (offset & 0x7F) as usize * 8 + bit;
        let lines = || (0..32).filter(move |bit| value >> bit & 1 == 1).map(line_of).filter(|line| *line < LINES);
        match offset {
            0x000..0x080 => lines().for_each(|line| self.enabled[line] = true),
            0x080..0x100 => lines().for_each(|line| self.enabled[line] = false),
            0x100..0x180 => lines().for_each(|line| self.pending[FIRST_INTERRUPT + line] = true),
            0x180..0x200 => lines().for_each(|line| self.pending[FIRST_INTERRUPT + line] = false),
            0x300..0x380 => (0..size).for_each(|byte| {
                let number = FIRST_INTERRUPT + (offset - 0x300 + byte) as usize;
                self.set_priority(number, (value >> (8 * byte)) as u8);
            }),
            _ => {}
        }
    }

    fn word(&self, byte: u32, is_set: impl Fn(usize) -> bool) -> u32 {
        let first = byte as usize * 8;
        (0..32).filter(|bit| first + bit < LINES && is_set(first + bit)).fold(0, |word, bit| word | 1 << bit)
    }
}
