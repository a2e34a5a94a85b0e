//! `cargo footprint`: what the images take of the drive board's memory, and whether the drive board would start its own.

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

use clap::Parser;
use firmware_image::ccm_code::{self, CcmCode};
use firmware_image::drive_board_image::{Facts, MOST_FLASH_BYTES, MOST_STATIC_BYTES};
use firmware_image::elf::{Elf, Section};
use firmware_image::memory::Memory;
use glenoid::rig::{ASSUMED_BASE_RADIUS_MM, Rig};
use host_tests::command_line;
use host_tests::emulator::{self, Emulator, Options};
use host_tests::firmware::{self, Image};
use host_tests::packages::Consent;
use host_tests::rehearse::{Display, EmulatedBoard, Session};
use host_tests::wearer::{Wearer, WearerSettings};

/// Flash of the STM32G474RE (RM0440, section 2; `memory.x`).
const FLASH_BYTES: u64 = 512 * 1024;
/// SRAM1 and SRAM2 of the STM32G474RE (as above).
const RAM_BYTES: u64 = 96 * 1024;
/// Poses to verify with; how many there are changes nothing about the memory.
const VERIFICATION_POSES: u8 = 3;
/// The core-coupled memory of the STM32G474RE (as above).
const CCM_BYTES: u64 = 32 * 1024;
/// The board writes its log when it has nothing else to do; on a busy host it may stand still for seconds.
const LOG_LIMIT: Duration = Duration::from_secs(60);

/// Build both firmware images and print their flash and static RAM by section, which must keep within their limits;
/// check the drive board's own (entry, vectors, memory, sizes) and both images' code in the core-coupled memory (`ccm.x`); then
/// let the emulated board work through a calibration and print what the solver takes and how far the stack reached.
#[derive(Parser)]
#[command(name = "cargo footprint", bin_name = "cargo footprint")]
struct Arguments {
    /// Poses of the calibration, about a second each
    #[arg(long, value_name = "M", default_value_t = 12, value_parser = clap::value_parser!(u8).range(3..=120))]
    poses: u8,
    /// Print the sections only; nothing is run
    #[arg(long)]
    sections: bool,
    /// Install what is missing without asking
    #[arg(long)]
    yes: bool,
}

fn main() -> ExitCode {
    match run(&command_line::parse::<Arguments>()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("cargo footprint: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let consent = if arguments.yes { Consent::Given } else { Consent::Ask };
    let toolchain = firmware::choose_toolchain(consent)?;
    println!("the drive board (nucleo-g474re)");
    let drive_board = Elf::read(&firmware::build_with(toolchain, Image::NUCLEO_G474RE)?)?;
    print_sections(&drive_board)?;
    check(&Facts::read(&drive_board)?)?;
    check_ccm_code(&CcmCode::read(&drive_board)?, Memory::DRIVE_BOARD)?;
    println!("\nthe emulated board");
    let image = firmware::build_with(toolchain, Image::EMULATED)?;
    let emulated = Elf::read(&image)?;
    print_sections(&emulated)?;
    check_ccm_code(&CcmCode::read(&emulated)?, Memory::EMULATED)?;
    if arguments.sections {
        return Ok(());
    }
    emulator::ensure_installed(consent)?;
    print_work(&image, arguments.poses)
}

fn print_sections(image: &Elf) -> Result<(), Box<dyn Error>> {
    let sections = image.sections()?;
    let is_ccm = |section: &Section| section.name == ccm_code::SECTION;
    println!("{:<16} {:>10} {:>8} {:>8} {:>8}", "section", "address", "flash", "RAM", "CCM");
    for section in &sections {
        let share = |there: bool| if there { section.size_bytes.to_string() } else { String::new() };
        let [flash, ram, ccm] = [share(section.in_flash), share(section.in_ram), share(is_ccm(section))];
        let line = format!("{:<16} {:#010x} {flash:>8} {ram:>8} {ccm:>8}", section.name, section.address);
        println!("{}", line.trim_end());
    }
    let flash = total(&sections, |section| section.in_flash);
    let ram = total(&sections, |section| section.in_ram);
    let ccm = total(&sections, is_ccm);
    println!("{:<27} {flash:>8} {ram:>8} {ccm:>8}", "in all, bytes");
    println!("{:<27} {MOST_FLASH_BYTES:>8} {MOST_STATIC_BYTES:>8} {CCM_BYTES:>8}", "at most");
    println!("{:<27} {FLASH_BYTES:>8} {RAM_BYTES:>8} {CCM_BYTES:>8}", "of the drive board's");
    if flash > MOST_FLASH_BYTES || ram > MOST_STATIC_BYTES {
        return Err("the image is too large".into());
    }
    Ok(())
}

/// Says that the drive board would start the image.
fn check(facts: &Facts) -> Result<(), String> {
    let faults = facts.faults();
    if !faults.is_empty() {
        let faults: Vec<String> = faults.iter().map(ToString::to_string).collect();
        return Err(format!("the drive board's image is unsound: {}", faults.join("; ")));
    }
    println!("entry, {} vectors, memory and record as the chip wants them", facts.vectors.len());
    Ok(())
}

/// Says that the code in the core-coupled memory lies where it should, and what it is.
fn check_ccm_code(code: &CcmCode, memory: Memory) -> Result<(), String> {
    let faults: Vec<String> = code.faults(memory).iter().map(ToString::to_string).collect();
    if !faults.is_empty() {
        return Err(format!("the core-coupled memory does not hold what it should: {}", faults.join("; ")));
    }
    println!("functions in the core-coupled memory: {}", code.functions.len());
    for function in &code.functions {
        println!("{:>8}  {}", function.size_bytes, function.name);
    }
    Ok(())
}

fn total(sections: &[Section], counts: impl Fn(&Section) -> bool) -> u64 {
    sections.iter().filter(|section| counts(section)).map(|section| section.size_bytes).sum()
}

/// Runs a calibration on the board and repeats what the board says about its own memory.
fn print_work(image: &Path, poses: u8) -> Result<(), Box<dyn Error>> {
    let rig = Rig::shoulder(ASSUMED_BASE_RADIUS_MM).map_err(|error| error.text())?;
    let mut board = EmulatedBoard::connect(Emulator::start(image, &Options::default())?)?;
    let mut wearer = Wearer::new(rig, WearerSettings { noise_mm: 0.1, ..WearerSettings::default() });
    let display = Display::choose(false);
    Session::new(&mut board, &mut wearer, rig.drum().fastest_mm_per_s, &display).calibrate(
        poses,
        VERIFICATION_POSES,
        0,
    )?;
    println!();
    for line in ["board: ready", "memory:", "stack:"] {
        let line = board.wait_for_log(line, LOG_LIMIT)?;
        println!("{}", line.split_once("] ").map_or(line.as_str(), |(_, text)| text));
    }
    Ok(())
}
