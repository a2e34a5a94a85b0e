//! The code that runs from the core-coupled memory: what is called once a pose or once a sample, as `hot.x` lists it.
//!
//! The flash holds it, and nothing but [`load`] brings it to where it is called. A call from one memory to the other is
//! too far for a branch instruction, so that the linker puts a veneer of three instructions between.

use core::ptr;

use cortex_m::asm;

unsafe extern "C" {
    /// Where the code is stored (`hot.x`).
    static _hot_stored: u32;
    /// Where it runs.
    static _hot_start: u32;
    /// The first address behind.
    static _hot_end: u32;
}

/// Copies the code to where it runs. Call it first of all in `main`: before any function of the library, and before
/// interrupts are on.
///
/// Not before `main`: Rust must not run until the static variables are in place.
pub fn load() {
    let stored = (&raw const _hot_stored).addr();
    let runs = (&raw const _hot_start).addr()..(&raw const _hot_end).addr();
    for (from, to) in (stored..).step_by(size_of::<u32>()).zip(runs.step_by(size_of::<u32>())) {
        // SAFETY: `hot.x` keeps both places for this, aligned and as long as each other; nothing of what is written has
        // run yet.
        unsafe {
            let word = ptr::read_volatile(ptr::with_exposed_provenance::<u32>(from));
            ptr::write_volatile(ptr::with_exposed_provenance_mut(to), word);
        }
    }
    // all is written before the next instruction is fetched (ARMv7-M ARM, A3.7.3)
    asm::dsb();
    asm::isb();
}
