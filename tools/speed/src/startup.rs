//! What the core needs beside `main`: vectors, the end after a panic or a fault, and the image's argument.

use core::panic::PanicInfo;

use cortex_m_rt::{ExceptionFrame, exception};
use cortex_m_semihosting::debug::{self, EXIT_FAILURE};
use cortex_m_semihosting::{nr, syscall1};

use super::report;

/// No interrupt is ever enabled here; cortex-m-rt's script wants the section all the same.
// SAFETY: cortex-m-rt's linker script places this section and checks this name; the type is that of a vector.
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
pub static __INTERRUPTS: [extern "C" fn() -> !; 1] = [stop];

extern "C" fn stop() -> ! {
    debug::exit(EXIT_FAILURE);
    loop {
        cortex_m::asm::bkpt();
    }
}

#[panic_handler]
fn on_panic(info: &PanicInfo) -> ! {
    report::panic(info);
    stop()
}

// SAFETY: never returns, and touches nothing.
#[exception]
unsafe fn HardFault(_: &ExceptionFrame) -> ! {
    stop()
}

/// Does the emulator's argument for this image contain the word?
pub fn argument_is(word: &str) -> bool {
    /// SYS_GET_CMDLINE (ARM DUI 0203J, "Semihosting", 5.4.19): the buffer, and its length going in and coming out.
    #[repr(C)]
    struct Block {
        buffer: *mut u8,
        length: usize,
    }
    let mut buffer = [0_u8; 64];
    let mut block = Block { buffer: buffer.as_mut_ptr(), length: buffer.len() };
    // SAFETY: the block and the buffer outlive the call, and the host writes no more than `length` bytes.
    let answer = unsafe { syscall1(nr::GET_CMDLINE, (&raw mut block).expose_provenance()) };
    answer == 0 && buffer.split(|byte| !byte.is_ascii_alphanumeric()).any(|found| found == word.as_bytes())
}
