//! The board's clock: milliseconds from a free-running timer.
//!
//! SysTick only wakes the core once a millisecond. Counting its interrupts would lose time: they do not queue up, and an
//! emulator on a busy host serves several of them late, as one.

use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::exception;

use super::cmsdk::TimerRegisters;

/// Core clock of the mps2-an386 (QEMU `mps2.c`, `SYSCLK_FRQ`); SysTick and timer count it.
const CORE_CLOCK_HZ: u32 = 25_000_000;
/// Counts of the timer in a millisecond.
const COUNTS_A_MS: u32 = CORE_CLOCK_HZ / 1_000;

/// Time since power-up. It must be read at least every 171 s, when the timer has gone round once.
pub struct Clock {
    timer: TimerRegisters,
    last_value: u32,
    now_ms: u32,
    /// Counts since `now_ms` began.
    remainder: u32,
}

impl Clock {
    /// Starts the timer and the tick that wakes the core.
    pub fn start(mut systick: SYST) -> Self {
        systick.set_clock_source(SystClkSource::Core);
        systick.set_reload(COUNTS_A_MS - 1);
        systick.clear_current();
        systick.enable_counter();
        systick.enable_interrupt();
        let timer = TimerRegisters::TIMER0;
        timer.run_freely();
        Self { timer, last_value: timer.value(), now_ms: 0, remainder: 0 }
    }

    /// Milliseconds since power-up, wrapping after 49.7 days.
    pub fn now_ms(&mut self) -> u32 {
        let value = self.timer.value();
        // the timer counts down
        let elapsed = self.last_value.wrapping_sub(value);
        self.last_value = value;
        // both remainders are below a millisecond, so their sum is below two
        let remainder = self.remainder + elapsed % COUNTS_A_MS;
        let passed_ms = elapsed / COUNTS_A_MS + remainder / COUNTS_A_MS;
        self.remainder = remainder % COUNTS_A_MS;
        self.now_ms = self.now_ms.wrapping_add(passed_ms);
        self.now_ms
    }
}

#[exception]
fn SysTick() {
    // to be woken is all that is wanted
}
