//! The six counts and the button, a thousand times a second, whatever the main loop does meanwhile.
//!
//! The core's own timer interrupts everything else, the CAN controller included. Its samples are the board's clock: the
//! number of the sample is the time in milliseconds. It also sees when the main loop stands still, and where: the
//! watchdog would only know that.

use core::arch::naked_asm;
use core::cell::Cell;
use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::interrupt::{Mutex, free};
use cortex_m::peripheral::scb::SystemHandler;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{DCB, DWT, SCB, SYST};
use embassy_stm32::pac;
use glenoid::drive_board::clock::PERIODS_A_SAMPLE;
use glenoid::restart::ResetCause;
use glenoid::rig::CABLES;

use super::cortex::faults;
use super::encoders;

/// The main loop stands still when it has taken no sample for so long, ms: a thousand times what any event takes.
pub const STANDSTILL_MS: u32 = 300;

/// Samples of the encoders a millisecond: one for the device, and the others for a control loop.
#[cfg(not(feature = "control-loop"))]
const RATE_KHZ: u32 = 1;
#[cfg(feature = "control-loop")]
use super::control::RATE_KHZ;
const _: () = assert!(PERIODS_A_SAMPLE.is_multiple_of(RATE_KHZ), "the clock has no whole number of cycles a sample");

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
    /// Longest interval between two samples since [`measure_anew`], clock cycles: [`PERIODS_A_SAMPLE`] and what the sampling was held
    /// up.
    pub longest_cycles: u32,
}

static LATEST: Mutex<Cell<Sample>> =
    Mutex::new(Cell::new(Sample { at_ms: 0, counts: [0; CABLES], button_down: false, cycles: 0, longest_cycles: 0 }));

/// The sample that the main loop has taken last.
static TAKEN_MS: AtomicU32 = AtomicU32::new(0);

/// Starts the sampling.
pub fn start(mut timer: SYST, scb: &mut SCB, dcb: &mut DCB, mut counter: DWT) {
    dcb.enable_trace();
    counter.enable_cycle_counter();
    // SAFETY: nothing relies on the priorities to keep others out; what is shared is guarded by `free`.
    unsafe { scb.set_priority(SystemHandler::SysTick, 0) };
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(PERIODS_A_SAMPLE / RATE_KHZ - 1);
    timer.clear_current();
    timer.enable_counter();
    timer.enable_interrupt();
}

/// The latest sample.
pub fn latest() -> Sample {
    free(|cs| LATEST.borrow(cs).get())
}

/// Forgets the longest interval.
pub fn measure_anew() {
    free(|cs| {
        let latest = LATEST.borrow(cs);
        latest.set(Sample { longest_cycles: 0, ..latest.get() });
    });
}

/// The main loop has taken the sample of this time, and is alive.
pub fn note_taken(at_ms: u32) {
    TAKEN_MS.store(at_ms, Ordering::Relaxed);
}

/// The vector of the core's timer: hands on where it struck. The frame lies on the main stack, the only one that there
/// is; its seventh word is the program counter (ARMv7-M ARM, B1.5.6).
#[unsafe(naked)]
#[unsafe(no_mangle)]
extern "C" fn SysTick() {
    naked_asm!("ldr r0, [sp, #24]", "b {handler}", handler = sym on_tick)
}

extern "C" fn on_tick(address: u32) {
    #[cfg(feature = "control-loop")]
    if !serve_control_loop() {
        return;
    }
    sample();
    if latest().at_ms.wrapping_sub(TAKEN_MS.load(Ordering::Relaxed)) > STANDSTILL_MS {
        faults::stop(ResetCause::Watchdog, address, 0, format_args!("the main loop stood still"))
    }
}

/// Calls the control loop with fresh counts; true when it is time for the device's sample.
#[cfg(feature = "control-loop")]
fn serve_control_loop() -> bool {
    static STEPS: AtomicU32 = AtomicU32::new(0);
    let began = DWT::cycle_count();
    let counts = free(|cs| {
        let latest = LATEST.borrow(cs);
        let before = latest.get();
        let counts = encoders::read(before.counts);
        latest.set(Sample { counts, ..before });
        counts
    });
    super::control::step(&counts, began);
    let steps = STEPS.load(Ordering::Relaxed).wrapping_add(1);
    STEPS.store(steps, Ordering::Relaxed);
    steps.is_multiple_of(RATE_KHZ)
}

fn sample() {
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
