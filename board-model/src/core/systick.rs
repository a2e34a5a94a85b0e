//! The core's timer (ARMv7-M ARM, B3.3).

const ENABLE: u32 = 1;
const INTERRUPT: u32 = 1 << 1;
const CORE_CLOCK: u32 = 1 << 2;
const COUNTED: u32 = 1 << 16;
const BITS: u32 = 0x00FF_FFFF;

/// The timer. It counts down from the reload value, and wraps one cycle behind zero.
#[derive(Debug, Clone, Default)]
pub struct SysTick {
    control: u32,
    reload: u32,
    /// The cycle in which it wraps next, while it runs.
    wraps_at: Option<u64>,
    counted: bool,
}

impl SysTick {
    /// Reads from 0xE000E010 on.
    pub fn read(&mut self, offset: u32, cycle: u64) -> u32 {
        match offset {
            0x0 => {
                let counted = if std::mem::take(&mut self.counted) { COUNTED } else { 0 };
                self.control | counted
            }
            0x4 => self.reload,
            0x8 => self.wraps_at.map_or(0, |at| (at.saturating_sub(cycle + 1)) as u32 & BITS),
            _ => 0,
        }
    }

    /// Writes from 0xE000E010 on.
    pub fn write(&mut self, offset: u32, value: u32, cycle: u64) {
        match offset {
            0x0 => {
                let was_on = self.is_on();
                self.control = value & (ENABLE | INTERRUPT | CORE_CLOCK);
                if self.is_on() != was_on {
                    self.wraps_at = self.is_on().then(|| cycle + self.period());
                }
            }
            0x4 => self.reload = value & BITS,
            0x8 => {
                self.counted = false;
                if self.is_on() {
                    self.wraps_at = Some(cycle + self.period());
                }
            }
            _ => {}
        }
    }

    /// It runs from the core's clock.
    pub fn is_on(&self) -> bool {
        self.control & (ENABLE | CORE_CLOCK) == ENABLE | CORE_CLOCK
    }

    /// Cycles from one wrap to the next.
    pub fn period(&self) -> u64 {
        u64::from(self.reload) + 1
    }

    /// The cycle in which something happens next.
    pub fn next(&self) -> Option<u64> {
        self.wraps_at
    }

    /// Lets time pass; true if the interrupt is due.
    pub fn advance(&mut self, cycle: u64) -> bool {
        let Some(at) = self.wraps_at else { return false };
        if cycle < at {
            return false;
        }
        self.counted = true;
        self.wraps_at = Some(at + (cycle - at) / self.period() * self.period() + self.period());
        self.control & INTERRUPT != 0
    }
}
