//! The model's time: cycles of the core, and picoseconds.

/// Picoseconds in a second.
pub const PS_A_SECOND: u64 = 1_000_000_000_000;
/// Picoseconds in a millisecond.
pub const PS_A_MS: u64 = PS_A_SECOND / 1_000;
/// Picoseconds in a microsecond.
pub const PS_A_US: u64 = PS_A_SECOND / 1_000_000;

/// The core's clock since power-up. One instruction is one cycle: the model proves bits, order and protocol; how long
/// the chip takes is for `cargo cycles` to estimate.
#[derive(Debug, Clone, Copy)]
pub struct Time {
    /// Cycles of the core so far.
    pub cycles: u64,
    hz: u64,
    since_cycles: u64,
    since_ps: u64,
}

impl Time {
    /// Time begins, at this frequency of the AHB clock.
    pub fn new(hz: u32) -> Self {
        Self { cycles: 0, hz: hz.into(), since_cycles: 0, since_ps: 0 }
    }

    /// The frequency changes now.
    pub fn set_hz(&mut self, hz: u32) {
        (self.since_ps, self.since_cycles, self.hz) = (self.now_ps(), self.cycles, hz.into());
    }

    /// Picoseconds so far.
    pub fn now_ps(&self) -> u64 {
        let cycles = u128::from(self.cycles - self.since_cycles);
        self.since_ps + (cycles * u128::from(PS_A_SECOND) / u128::from(self.hz)) as u64
    }

    /// The first cycle at or behind a time, if the frequency stays.
    pub fn cycle_at(&self, ps: u64) -> u64 {
        let left = u128::from(ps.saturating_sub(self.since_ps));
        let cycles = (left * u128::from(self.hz)).div_ceil(u128::from(PS_A_SECOND));
        self.since_cycles + u64::try_from(cycles).unwrap_or(u64::MAX / 2)
    }
}
