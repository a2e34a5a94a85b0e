//! The six counts and the button, a thousand times a second, whatever the main loop does meanwhile.
//!
//! The core's own timer interrupts everything else, the CAN controller included. Its samples are the board's clock: the
//! number of the sample is the time in milliseconds.

use core::cell::Cell;

use cortex_m::interrupt::{Mutex, free};
use cortex_m::peripheral::scb::SystemHandler;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{DCB, DWT, SCB, SYST};
use cortex_m_rt::exception;
use embassy_stm32::pac;
use glenoid::drive_board::clock::PERIODS_A_SAMPLE;
use glenoid::rig::CABLES;

use super::encoders;

/// Pin of the button in its port.
const BUTTON_PIN: usize = 13;

/// One sample.
#[derive(Clone, Copy)]
pub struct Sample {
    /// Milliseconds since the sampling began; wraps after 49.7 days.
    pub at_ms: u32,
    /// The counts, extended to 32 bits.
    pub counts: [i32; CABLES],
    /// The button's contact is closed.
    pub button_down: bool,
    /// Clock cycles at this sample, to tell the interval to the next.
    cycles: u32,
    /// Longest interval between two samples so far, clock cycles: [`PERIODS_A_SAMPLE`] and what the sampling was held
    /// up.
    pub longest_cycles: u32,
}

static LATEST: Mutex<Cell<Sample>> =
    Mutex::new(Cell::new(Sample { at_ms: 0, counts: [0; CABLES], button_down: false, cycles: 0, longest_cycles: 0 }));

/// Starts the sampling.
pub fn start(mut timer: SYST, scb: &mut SCB, dcb: &mut DCB, mut counter: DWT) {
    dcb.enable_trace();
    counter.enable_cycle_counter();
    // SAFETY: nothing relies on the priorities to keep others out; what is shared is guarded by `free`.
    unsafe { scb.set_priority(SystemHandler::SysTick, 0) };
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(PERIODS_A_SAMPLE - 1);
    timer.clear_current();
    timer.enable_counter();
    timer.enable_interrupt();
}

/// The latest sample.
pub fn latest() -> Sample {
    free(|cs| LATEST.borrow(cs).get())
}

#[exception]
fn SysTick() {
    free(|cs| {
        let latest = LATEST.borrow(cs);
        let before = latest.get();
        let cycles = DWT::cycle_count();
        // there is no interval before the first sample
        let interval = if before.at_ms == 0 { 0 } else { cycles.wrapping_sub(before.cycles) };
        latest.set(Sample {
            at_ms: before.at_ms.wrapping_add(1),
            counts: encoders::read(before.counts),
            button_down: pac::GPIOC.idr().read().idr(BUTTON_PIN) == pac::gpio::vals::Idr::HIGH,
            cycles,
            longest_cycles: before.longest_cycles.max(interval),
        });
    });
}
