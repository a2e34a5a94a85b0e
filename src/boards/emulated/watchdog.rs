//! The watchdog: bites when the main loop stands still.
//!
//! Source: ARM DDI 0479, chapter 4, "APB watchdog"; address from ARM DAI 0386. Its interrupt is the core's NMI, so
//! that the first time round the firmware can still say where it stood; the second time round the watchdog resets the
//! board by itself.

use super::cmsdk::WatchdogRegisters;

/// Clock of the peripherals, which it counts down with.
const CLOCK_HZ: u32 = 25_000_000;
/// Longest time without food, s. The emulator's clock goes on while a busy host lets the emulated core wait.
const PATIENCE_S: u32 = 8;

/// A running watchdog.
pub struct Watchdog(WatchdogRegisters);

impl Watchdog {
    /// Starts it.
    pub fn start() -> Self {
        let registers = WatchdogRegisters::WATCHDOG;
        registers.start(CLOCK_HZ * PATIENCE_S);
        Self(registers)
    }

    /// All is well.
    pub fn feed(&mut self) {
        self.0.restart();
    }
}
