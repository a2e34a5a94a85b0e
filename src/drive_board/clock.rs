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

/// PWR_CR5, bit 8. Set, as after a reset, the core's voltage is that of the normal range 1 mode, which bears
/// 150 MHz; cleared, that of the boost mode, which bears 170 MHz.
pub const R1MODE: u32 = 1 << 8;

/// Clock periods at half the core's clock that pass before it is made whole: the manual asks for 1 us at least, these
/// are 2 us.
pub const BOOST_SETTLING_PERIODS: u32 = CORE_HZ / 2 / 500_000;
