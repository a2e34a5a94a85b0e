//! RAM that a reset leaves alone: the last words, and the mark that the board has run since the supply came on.

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use core::ptr;

use glenoid::restart::{Area, CrashRecord, ResetCause, Restart};

/// Written once the board runs. RAM that has just come on holds it with a chance of one in four thousand million.
const HAS_RUN: u32 = 0x5275_6E21;

#[repr(C)]
struct Kept {
    has_run: u32,
    crash_record: Area,
}

/// The place of [`Kept`]: RAM holds a value whatever happens, but the program has given it none.
struct Place(UnsafeCell<MaybeUninit<Kept>>);

// SAFETY: one core; `take` runs once before any interrupt is on, `leave` only when nothing else runs ever again.
unsafe impl Sync for Place {}

/// Neither cleared nor filled at start-up (cortex-m-rt's linker script).
// SAFETY: the section exists for this.
#[unsafe(link_section = ".uninit.kept")]
static PLACE: Place = Place(UnsafeCell::new(MaybeUninit::uninit()));

/// Reads what was kept, and clears it: last words belong to one restart only. Call it once, before interrupts are on.
///
/// `by_hardware` says why the board started as far as the hardware knows; a board whose hardware says nothing passes
/// None.
pub fn take(by_hardware: Option<ResetCause>) -> Restart {
    let kept = PLACE.0.get().cast::<Kept>();
    // SAFETY: any bits are a valid `Kept`, and RAM holds some bits, which volatile accesses take as they are; nobody
    // else accesses the place, see above.
    let (has_run, area) = unsafe {
        let found =
            (ptr::read_volatile(&raw const (*kept).has_run), ptr::read_volatile(&raw const (*kept).crash_record));
        ptr::write_volatile(kept, Kept { has_run: HAS_RUN, crash_record: Default::default() });
        found
    };
    let by_memory = if has_run == HAS_RUN { ResetCause::Pin } else { ResetCause::PowerOn };
    Restart::new(by_hardware.unwrap_or(by_memory), &area)
}

/// Leaves the last words for the next start.
pub fn leave(words: &CrashRecord) {
    let kept = PLACE.0.get().cast::<Kept>();
    // SAFETY: called with interrupts off by code that never returns to what was interrupted.
    unsafe { ptr::write_volatile(&raw mut (*kept).crash_record, words.seal()) };
}
