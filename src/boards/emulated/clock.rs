//! The board's clock: SysTick counts milliseconds.

use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::exception;

/// Core clock of the mps2-an386 (QEMU `mps2.c`, `SYSCLK_FRQ`).
const CORE_CLOCK_HZ: u32 = 25_000_000;

static NOW_MS: AtomicU32 = AtomicU32::new(0);

/// Starts the tick.
pub fn start(mut systick: SYST) {
    systick.set_clock_source(SystClkSource::Core);
    systick.set_reload(CORE_CLOCK_HZ / 1_000 - 1);
    systick.clear_current();
    systick.enable_counter();
    systick.enable_interrupt();
}

/// Milliseconds since power-up, wrapping after 49.7 days.
pub fn now_ms() -> u32 {
    NOW_MS.load(Ordering::Relaxed)
}

#[exception]
fn SysTick() {
    NOW_MS.fetch_add(1, Ordering::Relaxed);
}
