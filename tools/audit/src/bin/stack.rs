//! `cargo stack`: how deep the stack of each image can get at the very most, and how much room there is.

use std::error::Error;
use std::process::ExitCode;

use clap::Parser;
use firmware_image::elf::Elf;
use firmware_image::stack_bound::{MOST_ENDINGS, MOST_ROUNDS, Root, StackUse};
use host_tests::command_line;
use host_tests::firmware::{self, Image};
use host_tests::packages::Consent;

/// Build the firmware images and print the deepest way of the stack from each root, read off the instructions. Exits 1
/// when less than a third of the room would be left.
#[derive(Parser)]
#[command(name = "cargo stack", bin_name = "cargo stack")]
struct Arguments {
    /// Print the deepest way of each root, function by function
    #[arg(long)]
    ways: bool,
    /// Install what is missing without asking
    #[arg(long)]
    yes: bool,
}

fn main() -> ExitCode {
    match run(&command_line::parse::<Arguments>()) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("cargo stack: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<bool, Box<dyn Error>> {
    let consent = if arguments.yes { Consent::Given } else { Consent::Ask };
    let toolchain = firmware::choose_toolchain(consent)?;
    let mut sound = true;
    for image in Image::BOARDS {
        let elf = Elf::read(&firmware::build_with(toolchain, image)?)?;
        let stack = StackUse::of(&elf).map_err(|error| format!("{}: {error}", image.name()))?;
        println!("{}", image.name());
        print(&stack, arguments.ways);
        sound &= stack.leaves_a_third();
    }
    println!("\nFunctions that call each other in a circle are taken to go round at most {MOST_ROUNDS} times.");
    Ok(sound)
}

fn print(stack: &StackUse, ways: bool) {
    for bound in &stack.roots {
        let kind = if bound.root == Root::Main { "main program" } else { "exception" };
        println!("{:>8}  {kind:<13} {}", bound.bytes, bound.name);
        print_way(&bound.way, ways);
    }
    println!("{:>8}  the program's end, {MOST_ENDINGS} times at most", stack.ending_bytes);
    print_way(&stack.ending_way, ways);
    let (most, room) = (stack.most_bytes(), stack.room_bytes);
    println!("{most:>8}  all of them at once, the very most");
    println!("{room:>8}  room above the guard");
    let percent = (room as f64 - most as f64) / room as f64 * 100.0;
    let verdict = if stack.leaves_a_third() { "at least a third, as it must be" } else { "LESS than a third" };
    println!("{percent:>7.0}%  of it never used: {verdict}\n");
}

fn print_way(way: &[(String, u64)], ways: bool) {
    for (name, bytes) in way.iter().filter(|_| ways) {
        println!("{bytes:>21}  {name}");
    }
}
