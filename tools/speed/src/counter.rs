//! Counting: TIMER0 of the mps2-an386 between two marks.
//!
//! Source: ARM DDI 0479, "Cortex-M System Design Kit", section 4.4 (CMSDK APB timer). It counts down at the core clock
//! of 25 MHz, one tick in 40 ns. Under QEMU's `-icount shift=6` every instruction takes 64 ns of virtual time, so the
//! ticks tell the number of instructions to less than one.

use core::arch::asm;
use core::ptr;

const TIMER0: usize = 0x4000_0000;
const CTRL: usize = TIMER0;
const VALUE: usize = TIMER0 + 0x4;
const RELOAD: usize = TIMER0 + 0x8;
const CTRL_ENABLE: u32 = 1;

/// Starts the timer at its full range: 171 s, then it would wrap.
pub fn start() {
    // SAFETY: word registers of a timer of this device that nothing else uses.
    unsafe {
        ptr::write_volatile(ptr::with_exposed_provenance_mut(RELOAD), u32::MAX);
        ptr::write_volatile(ptr::with_exposed_provenance_mut(VALUE), u32::MAX);
        ptr::write_volatile(ptr::with_exposed_provenance_mut(CTRL), CTRL_ENABLE);
    }
}

/// Ticks of 40 ns that `run` takes, and what it gives. The call of the second mark is in it: an empty `run` tells how
/// much that is.
#[inline(always)]
pub fn ticks_of<R>(run: impl FnOnce() -> R) -> (u32, R) {
    let before = count_begins();
    let result = run();
    let after = count_ends();
    (before.wrapping_sub(after), result)
}

/// The mark before. The emulator's trace finds it by its name.
#[unsafe(no_mangle)]
#[inline(never)]
extern "C" fn count_begins() -> u32 {
    let value = read();
    // SAFETY: no instruction at all; the compiler moves no memory access across it.
    unsafe { asm!("", options(nostack)) };
    value
}

/// The mark behind.
#[unsafe(no_mangle)]
#[inline(never)]
extern "C" fn count_ends() -> u32 {
    // SAFETY: as above.
    unsafe { asm!("", options(nostack)) };
    read()
}

/// Called before a count of one of three kinds: the emulator's trace tells the kinds apart by these names.
pub const KINDS: [extern "C" fn(); 3] = [kind_tick, kind_sample, kind_frame];

#[unsafe(no_mangle)]
#[inline(never)]
extern "C" fn kind_tick() {
    // SAFETY: no instruction but one that does nothing; it keeps the three from being made one.
    unsafe { asm!("nop", options(nostack)) };
}

#[unsafe(no_mangle)]
#[inline(never)]
extern "C" fn kind_sample() {
    // SAFETY: as above.
    unsafe { asm!("nop", "nop", options(nostack)) };
}

#[unsafe(no_mangle)]
#[inline(never)]
extern "C" fn kind_frame() {
    // SAFETY: as above.
    unsafe { asm!("nop", "nop", "nop", options(nostack)) };
}

#[inline(always)]
fn read() -> u32 {
    // SAFETY: a word register of this device.
    unsafe { ptr::read_volatile(ptr::with_exposed_provenance(VALUE)) }
}

/// A loop of two million instructions (`subs`, `bne`): what the count is checked with.
#[inline(never)]
pub fn two_million_instructions() {
    // SAFETY: counts one register down to zero.
    unsafe {
        asm!(
            "2:",
            "subs {0}, {0}, #1",
            "bne 2b",
            inout(reg) 1_000_000_u32 => _,
            options(nomem, nostack),
        );
    }
}
