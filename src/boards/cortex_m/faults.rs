//! The end of the line: a panic or a fault leaves its last words, and the board starts anew.

use core::arch::naked_asm;
use core::fmt::Arguments;
use core::panic::PanicInfo;

use cortex_m::peripheral::SCB;
use cortex_m_rt::{ExceptionFrame, exception};
use glenoid::restart::{CrashRecord, ResetCause};

use super::{retained_ram, stack};

// The board's own part. It names nothing of this module, and this module nothing of it.
unsafe extern "Rust" {
    /// Tells whoever listens at this moment. Called just before the reset, with interrupts off.
    safe fn board_says(words: &CrashRecord);
    /// Whatever this hardware wires to the non-maskable interrupt has struck at this address.
    safe fn board_on_nmi(address: u32);
}

/// CFSR: an access to data was forbidden (ARMv7-M ARM, B3.2.15).
const DATA_VIOLATION: u32 = 1 << 1;
/// CFSR: an interrupt's frame could not be stored. The guard is all that the MPU forbids, so the stack was full.
const STACKING_VIOLATION: u32 = 1 << 4;

/// Leaves the last words and resets the board. `address` is that of the instruction, `line` that of the source; 0 when
/// not known.
pub fn stop(cause: ResetCause, address: u32, line: u16, text: Arguments) -> ! {
    cortex_m::interrupt::disable();
    let words = CrashRecord::new(cause, address, line, text);
    retained_ram::leave(&words);
    board_says(&words);
    SCB::sys_reset()
}

#[panic_handler]
fn on_panic(info: &PanicInfo) -> ! {
    let (file, line) = info.location().map_or(("?", 0), |location| (location.file(), location.line()));
    // no file of this project has that many lines
    stop(ResetCause::Panic, 0, line as u16, format_args!("{file}: {}", info.message()))
}

// SAFETY: never returns, and touches nothing that the interrupted code could have left in pieces.
#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    // SAFETY: reading these registers has no side effect.
    let (cfsr, mmfar, bfar) = unsafe {
        let scb = &*SCB::PTR;
        (scb.cfsr.read(), scb.mmfar.read(), scb.bfar.read())
    };
    let touched_guard = cfsr & DATA_VIOLATION != 0 && stack::is_in_guard(mmfar as usize);
    if cfsr & STACKING_VIOLATION != 0 {
        // the frame was not stored, so what it says of the program counter is not so
        stop(ResetCause::StackOverflow, 0, 0, format_args!("CFSR {cfsr:#x}"))
    } else if touched_guard {
        stop(ResetCause::StackOverflow, frame.pc(), 0, format_args!("CFSR {cfsr:#x}, MMFAR {mmfar:#x}"))
    }
    stop(ResetCause::Fault, frame.pc(), 0, format_args!("CFSR {cfsr:#x}, MMFAR {mmfar:#x}, BFAR {bfar:#x}"))
}

// SAFETY: as above.
#[exception]
unsafe fn DefaultHandler(number: i16) -> ! {
    stop(ResetCause::UnexpectedInterrupt, 0, 0, format_args!("interrupt {number}"))
}

/// The vector of the non-maskable interrupt: hands on where it struck. The frame lies on the main stack, the only one
/// that there is; its seventh word is the program counter (ARMv7-M ARM, B1.5.6).
#[unsafe(naked)]
#[unsafe(no_mangle)]
extern "C" fn NonMaskableInt() {
    naked_asm!("ldr r0, [sp, #24]", "b {handler}", handler = sym on_nmi)
}

extern "C" fn on_nmi(address: u32) {
    board_on_nmi(address);
}
