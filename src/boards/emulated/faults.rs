//! The end of the line: a panic or a fault is printed, and the emulator exits with failure.

use core::panic::PanicInfo;

use cortex_m::peripheral::SCB;
use cortex_m_rt::{ExceptionFrame, exception};
use cortex_m_semihosting::debug::{self, EXIT_FAILURE};

use super::{log, stack};

/// CFSR: the stacking of an exception, or a data access, was forbidden (ARMv7-M ARM, B3.2.15).
const CFSR_MEMORY: u32 = 0b1001_0010;

/// Ends the emulator with a failure.
pub fn stop() -> ! {
    debug::exit(EXIT_FAILURE);
    loop {
        cortex_m::asm::bkpt();
    }
}

#[panic_handler]
fn on_panic(info: &PanicInfo) -> ! {
    cortex_m::interrupt::disable();
    log::write_last_words(format_args!("{info}"));
    stop()
}

// SAFETY: never returns, and touches nothing that the interrupted code could have left in pieces.
#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    // SAFETY: reading these registers has no side effect.
    let (cfsr, mmfar) = unsafe { ((*SCB::PTR).cfsr.read(), (*SCB::PTR).mmfar.read()) };
    if cfsr & CFSR_MEMORY != 0 && stack::is_in_guard(mmfar as usize) {
        log::write_last_words(format_args!("fault: stack overflow, CFSR {cfsr:#x}, MMFAR {mmfar:#x}"));
    } else {
        let pc = frame.pc();
        log::write_last_words(format_args!("fault: CFSR {cfsr:#x}, PC {pc:#x}, MMFAR {mmfar:#x}"));
    }
    stop()
}

// SAFETY: as above.
#[exception]
unsafe fn DefaultHandler(number: i16) -> ! {
    log::write_last_words(format_args!("fault: unexpected interrupt {number}"));
    stop()
}
