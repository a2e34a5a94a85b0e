//! The stack: a guard below it and a mark of how far it ever reached.

use core::ptr;

use cortex_m::interrupt::free;
use cortex_m::peripheral::MPU;
use cortex_m::register::msp;

unsafe extern "C" {
    /// First address above the stack (cortex-m-rt's linker script).
    static _stack_start: u32;
    /// First address above the static variables; the stack must not reach it.
    static _stack_end: u32;
}

/// Length of the guard, and its alignment: the MPU asks for a power of two at a multiple of itself. A function with
/// a larger frame could step over it unseen, so it is larger than any frame of this firmware.
const GUARD_LEN: usize = 4096;

/// What unused stack looks like.
const PAINT: u32 = 0xA5A5_5A5A;

/// Left unpainted below the caller: the painting loop's own frame.
const OWN_FRAME_LEN: usize = 128;

/// How much stack there is and how much of it was used, in bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Usage {
    /// The most that was used since the stack was last painted.
    pub used_bytes: usize,
    /// All that there is above the guard.
    pub size_bytes: usize,
}

/// Address of the guard. Without it an overflow would run into the static variables, and past the end of RAM the
/// emulator swallows writes without a fault.
pub fn guard_address() -> usize {
    (&raw const _stack_end).addr().next_multiple_of(GUARD_LEN)
}

/// The address lies in the guard.
pub fn is_in_guard(address: usize) -> bool {
    (guard_address()..guard_address() + GUARD_LEN).contains(&address)
}

/// Forbids every access to the guard. The fault handlers run with the MPU off, so they can still print.
pub fn protect(mpu: &MPU) {
    const REGION_VALID: u32 = 1 << 4;
    const EXECUTE_NEVER: u32 = 1 << 28;
    // the field holds the power of two less one; the access permission bits stay 0: no access
    const SIZE: u32 = (GUARD_LEN.trailing_zeros() - 1) << 1;
    const REGION_ENABLE: u32 = 1;
    const MPU_ENABLE: u32 = 1;
    const DEFAULT_MAP_ELSEWHERE: u32 = 1 << 2;
    // SAFETY: region 0 takes only the guard away, which no object of this program lies in.
    unsafe {
        mpu.rbar.write(guard_address() as u32 | REGION_VALID);
        mpu.rasr.write(EXECUTE_NEVER | SIZE | REGION_ENABLE);
        mpu.ctrl.write(MPU_ENABLE | DEFAULT_MAP_ELSEWHERE);
    }
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}

/// Paints the stack that is not in use at this moment. A frame of its own, of known length: what is painted lies below it.
#[inline(never)]
pub fn paint() {
    // an interrupt would put its frame where the paint goes
    free(|_| {
        let top = msp::read() as usize - OWN_FRAME_LEN;
        for address in (lowest()..top).step_by(size_of::<u32>()) {
            // SAFETY: the words lie above the guard and below every live frame.
            unsafe { ptr::write_volatile(ptr::with_exposed_provenance_mut(address), PAINT) };
        }
    });
}

/// Measures the stack by what is left of the paint. Reads up to the whole stack: not for the hot path.
pub fn usage() -> Usage {
    let top = (&raw const _stack_start).addr();
    let mut untouched = lowest();
    // SAFETY: the words lie within the stack's memory, which is readable above the guard.
    while untouched < top && unsafe { ptr::read_volatile(ptr::with_exposed_provenance::<u32>(untouched)) } == PAINT {
        untouched += size_of::<u32>();
    }
    Usage { used_bytes: top - untouched, size_bytes: top - lowest() }
}

/// Lowest address that the stack may use.
fn lowest() -> usize {
    guard_address() + GUARD_LEN
}
