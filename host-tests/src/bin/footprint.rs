//! `cargo footprint`: flash and static RAM of the emulated board's image, section by section.

use std::error::Error;
use std::process::ExitCode;

use clap::Parser;
use host_tests::elf::{Elf, Section};
use host_tests::firmware::{self, Image};
use host_tests::packages::Consent;

/// Build the firmware image and print what it takes of the drive board's memory.
#[derive(Parser)]
#[command(name = "cargo footprint", bin_name = "cargo footprint")]
struct Arguments {
    /// Install what is missing without asking
    #[arg(long)]
    yes: bool,
}

/// Flash of the STM32G474RE (RM0440, section 2; `memory.x`).
const FLASH_BYTES: u64 = 512 * 1024;
/// SRAM1 and SRAM2 of the STM32G474RE (as above).
const RAM_BYTES: u64 = 96 * 1024;

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("cargo footprint: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let consent = if arguments.yes { Consent::Given } else { Consent::Ask };
    let image = Elf::read(&firmware::build(Image::EMULATED, consent)?)?;
    let sections = image.sections()?;
    println!("{:<16} {:>10} {:>8} {:>8}", "section", "address", "flash", "RAM");
    for section in &sections {
        let share = |there: bool| if there { section.size_bytes.to_string() } else { String::new() };
        let address = format!("{:#010x}", section.address);
        println!("{:<16} {address} {:>8} {:>8}", section.name, share(section.in_flash), share(section.in_ram));
    }
    let flash = total(&sections, |section| section.in_flash);
    let ram = total(&sections, |section| section.in_ram);
    println!("{:<27} {flash:>8} {ram:>8}", "in all, bytes");
    println!("{:<27} {:>8} {:>8}", "of the drive board's", FLASH_BYTES, RAM_BYTES);
    let stack = image.symbol("_stack_start")? - image.symbol("_stack_end")?;
    println!("left for the stack          {stack:>17}");
    Ok(())
}

fn total(sections: &[Section], counts: impl Fn(&Section) -> bool) -> u64 {
    sections.iter().filter(|section| counts(section)).map(|section| section.size_bytes).sum()
}
