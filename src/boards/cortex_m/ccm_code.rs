//! The code that runs from the core-coupled memory: what is called once a pose or once a sample and asks for it at the
//! function (`ccm.x`).
//!
//! The flash holds it, and nothing but [`load`] brings it to where it is called. A call from one memory to the other is
//! too far for a branch instruction, so that the linker puts a veneer of three instructions between.
//!
//! The flash corrects a bit that has changed, this memory does not notice it; [`Comparison`] does.

use core::ptr;

use cortex_m::asm;
use glenoid::restart::ResetCause;

use super::faults;

unsafe extern "C" {
    /// Where the code is stored (`ccm.x`).
    static _ccm_code_stored: u32;
    /// Where it runs.
    static _ccm_code_start: u32;
    /// The first address behind.
    static _ccm_code_end: u32;
}

const WORD_LEN: usize = size_of::<u32>();

/// Words that are compared at a time: a few microseconds' work. The whole code takes some 200 times.
const WORDS_AT_A_TIME: usize = 16;

/// Copies the code to where it runs. Call it first of all in `main`: before any function of the library, and before
/// interrupts are on.
///
/// Not before `main`: Rust must not run until the static variables are in place.
pub fn load() {
    for (stored, runs) in words_from(0) {
        // SAFETY: `ccm.x` keeps both places for this, aligned and as long as each other; nothing of what is written has
        // run yet.
        unsafe {
            let word = ptr::read_volatile(ptr::with_exposed_provenance::<u32>(stored));
            ptr::write_volatile(ptr::with_exposed_provenance_mut(runs), word);
        }
    }
    // all is written before the next instruction is fetched (ARMv7-M ARM, A3.7.3)
    asm::dsb();
    asm::isb();
}

/// The copy held against what is stored, over and over.
pub struct Comparison {
    /// Words of this round that were alike.
    done: usize,
}

impl Comparison {
    /// Nothing is compared yet.
    pub const fn new() -> Self {
        Self { done: 0 }
    }

    /// Compares the next few words. Call it whenever there is nothing else to do; it restarts the board, which copies the
    /// code anew, when a word has changed.
    pub fn go_on(&mut self) {
        let mut left = words_from(self.done);
        for (stored, runs) in left.by_ref().take(WORDS_AT_A_TIME) {
            // SAFETY: as for `load`, and nobody writes.
            let [stored, word] = unsafe {
                [stored, runs].map(|address| ptr::read_volatile(ptr::with_exposed_provenance::<u32>(address)))
            };
            if word != stored {
                faults::stop(
                    ResetCause::MemoryError,
                    runs as u32,
                    0,
                    format_args!("the code copied to RAM changed there"),
                )
            }
        }
        self.done = if left.next().is_some() { self.done + WORDS_AT_A_TIME } else { 0 };
    }
}

/// Every word of the code but the first `left_out`: where it is stored, and where it runs.
fn words_from(left_out: usize) -> impl Iterator<Item = (usize, usize)> {
    let left_out = left_out * WORD_LEN;
    let stored = (&raw const _ccm_code_stored).addr() + left_out;
    let runs = (&raw const _ccm_code_start).addr() + left_out..(&raw const _ccm_code_end).addr();
    (stored..).step_by(WORD_LEN).zip(runs.step_by(WORD_LEN))
}
