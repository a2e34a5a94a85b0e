//! How deep the stack gets under a call: it is painted, and what is left of the paint is looked for.

use core::hint::black_box;
use core::ptr;

use cortex_m::register::msp;

unsafe extern "C" {
    /// First address above the static variables; the stack must not reach it.
    static _stack_end: u32;
}

/// What unused stack looks like.
const PAINT: u32 = 0xA5A5_5A5A;

/// Bytes of stack that `run` takes, its return address included. No interrupt is on in this image.
#[inline(never)]
pub fn used_by(run: &mut dyn FnMut()) -> usize {
    let bottom = (&raw const _stack_end).addr();
    // Everything of this function itself lies at or above its stack pointer, so all below it is free.
    let top = msp::read() as usize;
    for address in (bottom..top).step_by(size_of::<u32>()) {
        // SAFETY: words between the static variables and the stack pointer.
        unsafe { ptr::write_volatile(ptr::with_exposed_provenance_mut(address), PAINT) };
    }
    black_box(run)();
    let mut untouched = bottom;
    // SAFETY: as above.
    while untouched < top && unsafe { ptr::read_volatile(ptr::with_exposed_provenance::<u32>(untouched)) } == PAINT {
        untouched += size_of::<u32>();
    }
    top - untouched
}
