//! The end of the line: a panic or a fault is printed, and the emulator exits with failure.

use core::fmt::Arguments;
use core::panic::PanicInfo;

use cortex_m::peripheral::SCB;
use cortex_m_rt::{ExceptionFrame, exception};
use cortex_m_semihosting::debug::{self, EXIT_FAILURE};

use super::{log, stack};

/// CFSR: an access to data was forbidden (ARMv7-M ARM, B3.2.15).
const DATA_VIOLATION: u32 = 1 << 1;
/// CFSR: an interrupt's frame could not be stored. The guard is all that the MPU forbids, so the stack was full.
const STACKING_VIOLATION: u32 = 1 << 4;

/// Writes its last words and ends the emulator with a failure.
pub fn stop(last_words: Arguments) -> ! {
    cortex_m::interrupt::disable();
    log::write_last_words(last_words);
    debug::exit(EXIT_FAILURE);
    loop {
        cortex_m::asm::bkpt();
    }
}

#[panic_handler]
fn on_panic(info: &PanicInfo) -> ! {
    stop(format_args!("{info}"))
}

// SAFETY: never returns, and touches nothing that the interrupted code could have left in pieces.
#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    // SAFETY: reading these registers has no side effect.
    let (cfsr, mmfar) = unsafe { ((*SCB::PTR).cfsr.read(), (*SCB::PTR).mmfar.read()) };
    let touched_guard = cfsr & DATA_VIOLATION != 0 && stack::is_in_guard(mmfar as usize);
    if touched_guard || cfsr & STACKING_VIOLATION != 0 {
        stop(format_args!("fault: stack overflow, CFSR {cfsr:#x}, MMFAR {mmfar:#x}"))
    }
    let pc = frame.pc();
    stop(format_args!("fault: CFSR {cfsr:#x}, PC {pc:#x}, MMFAR {mmfar:#x}"))
}

// SAFETY: as above.
#[exception]
unsafe fn DefaultHandler(number: i16) -> ! {
    stop(format_args!("fault: unexpected interrupt {number}"))
}
