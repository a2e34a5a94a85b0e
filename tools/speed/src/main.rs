//! The speed image: every path of the library on one problem, on the emulated board's core, counted in timer ticks.
//!
//! Run by `cargo cycles`, which turns ticks into instructions and this image's lines into a table. Each path prints
//!
//! ```text
//! path NAME PRECISION counts=N ticks=SUM worst=MOST state=BYTES stack=BYTES steps=N error=NANOMETRES
//! ```
//!
//! where `counts` is how often the path was counted (each pose by itself, or the whole run at once), `state` what it
//! keeps in static memory beside the poses, `stack` how deep its stack gets, and `error` how far the identified centre
//! is from the true one. The word `f32` as the image's argument leaves double precision out.
#![no_std]
#![no_main]

#[cfg(not(target_os = "none"))]
compile_error!("this image is for the Cortex-M4F: use `cargo cycles`, or --target thumbv7em-none-eabihf");

mod counter;
mod held;
mod measure;
mod paths;
mod problem;
mod report;
mod stack;
mod startup;

use core::hint::black_box;

use cortex_m_semihosting::debug::{self, EXIT_FAILURE, EXIT_SUCCESS};

use measure::Number;
use paths::Bench;
use problem::Problem;

#[cortex_m_rt::entry]
fn main() -> ! {
    counter::start();
    let sound = measure_all() == Some(true);
    debug::exit(if sound { EXIT_SUCCESS } else { EXIT_FAILURE });
    loop {
        cortex_m::asm::bkpt();
    }
}

/// False when a path did not end as it should, `None` when the problem cannot be built.
fn measure_all() -> Option<bool> {
    report::calibration("empty", measure::empty());
    report::calibration("loop", counter::ticks_of(counter::two_million_instructions).0);
    let single = measure_in::<f32>(true)?;
    // Called in any case, so that images that hold less differ by nothing but the paths.
    let all = !startup::argument_is("f32");
    let double = measure_in::<f64>(all)?;
    // Last: it is not traced.
    let device = measure_device(all)?;
    report::end();
    Some(single && double && device)
}

/// The whole device.
#[inline(never)]
fn measure_device(wanted: bool) -> Option<bool> {
    let problem = Problem::new().ok()?;
    Some(!wanted || paths::run_device(black_box(&problem)))
}

/// All paths in one precision. What they keep between their calls lies in this function's frame, above the stack that
/// is measured; both precisions at once would not fit the board's memory.
#[inline(never)]
fn measure_in<T: Number>(wanted: bool) -> Option<bool> {
    let mut bench = Bench::<T>::new(Problem::new().ok()?);
    let bench = black_box(&mut bench);
    Some(!wanted || paths::run(bench))
}
