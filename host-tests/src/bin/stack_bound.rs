//! `cargo stack-bound`: how deep the drive board's stack can get, from its machine code.

use std::error::Error;
use std::process::ExitCode;

use clap::Parser;
use host_tests::elf::Elf;
use host_tests::firmware::{self, Image};
use host_tests::packages::Consent;
use host_tests::stack_bound::{Bound, Bounds, image};

/// What the core stores when an interrupt comes, with the floating-point registers and the gap that may align it (ARMv7-M
/// ARM, B1.5.6).
const INTERRUPT_FRAME_BYTES: i64 = 26 * 4 + 4;
/// Length of the guard below the stack, and its alignment (`src/boards/cortex_m/stack.rs`).
const GUARD_BYTES: u64 = 4096;

/// The roots, each of which may interrupt those before it. The last two end the firmware, or note a bad word of the record.
const ROOTS: [&str; 5] = ["main", "FDCAN1_IT0", "SysTick", "NonMaskableInt", "HardFault"];

/// Build the drive board's image and bound its stack: main, and every interrupt on top of it. Exits with an error when a
/// third of the room would not be left over.
#[derive(Parser)]
#[command(name = "cargo stack-bound", bin_name = "cargo stack-bound")]
struct Arguments {
    /// Print the deepest way of each root
    #[arg(long)]
    ways: bool,
    /// Install what is missing without asking
    #[arg(long)]
    yes: bool,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("cargo stack-bound: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let consent = if arguments.yes { Consent::Given } else { Consent::Ask };
    let elf = Elf::read(&firmware::build(Image::NUCLEO_G474RE, consent)?)?;
    let mut bounds = image::read(&elf)?;
    let mut total = 0;
    println!("{:<16} {:>8} {:>8}", "root", "bytes", "in all");
    for root in ROOTS {
        let bound = bounds.of(elf.function(root)?.address)?;
        // main is not interrupted into
        let frame = if root == "main" { 0 } else { INTERRUPT_FRAME_BYTES };
        total += bound.bytes + frame;
        println!("{root:<16} {:>8} {total:>8}", bound.bytes + frame);
        if arguments.ways {
            print_way(&bounds, &bound);
        }
    }
    let floor = elf.symbol("_stack_end")?.next_multiple_of(GUARD_BYTES) + GUARD_BYTES;
    let room = i64::try_from(elf.symbol("_stack_start")?.saturating_sub(floor))?;
    println!("{:<16} {room:>17}", "of the room");
    if total * 3 > room * 2 {
        return Err(format!("{total} bytes of {room}: less than a third is left over").into());
    }
    Ok(())
}

fn print_way(bounds: &Bounds, bound: &Bound) {
    for address in &bound.way {
        println!("    {}", bounds.name(*address));
    }
}
