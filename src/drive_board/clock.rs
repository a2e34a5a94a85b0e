//! The board's clocks, as frequencies.

/// The core, the buses, the timers and the CAN controller all run at this clock: a crystal of 24 MHz, divided by 6,
/// multiplied by 85, divided by 2 (RM0440, 7.2.4; it is also the most that the chip allows).
pub const CORE_HZ: u32 = 170_000_000;

/// Samples of the encoders in a second.
pub const SAMPLES_HZ: u32 = 1_000;

/// Clock periods from one sample to the next.
pub const PERIODS_A_SAMPLE: u32 = CORE_HZ / SAMPLES_HZ;

/// Bit rate of the CAN bus.
pub const CAN_BIT_HZ: u32 = 500_000;
