//! `cargo panic-free`: proves that nothing in the library can panic on the board.

use std::collections::BTreeSet;
use std::error::Error;
use std::process::ExitCode;

use clap::Parser;
use firmware_image::elf::Elf;
use firmware_image::stack_bound::CallGraph;
use host_tests::command_line;
use host_tests::firmware::{self, FirmwareError, Image};
use host_tests::packages::Consent;

/// Link the whole library, built as the firmware is, into an image whose panic handler refers to something that does not
/// exist: it links only if no way to a panic is left. If it does not, name the functions that could panic and exit 1.
#[derive(Parser)]
#[command(name = "cargo panic-free", bin_name = "cargo panic-free")]
struct Arguments {
    /// Install what is missing without asking
    #[arg(long)]
    yes: bool,
}

/// Makes `build.rs` link the image all the same.
const LINK_ANYWAY: &str = "GLENOID_LINK_ANYWAY";

/// Parts of the library that must be in the image: one that had been optimised away would prove nothing.
const PARTS: [&str; 8] = ["can", "device", "identification", "kinematics", "procedure", "record", "restart", "slcan"];

fn main() -> ExitCode {
    match run(&command_line::parse::<Arguments>()) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("cargo panic-free: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<bool, Box<dyn Error>> {
    let consent = if arguments.yes { Consent::Given } else { Consent::Ask };
    let toolchain = firmware::choose_toolchain(consent)?;
    match firmware::build_with_environment(toolchain, Image::PANIC_FREE, &[(LINK_ANYWAY, None)]) {
        Ok(image) => {
            let graph = CallGraph::read(&Elf::read(&image)?)?;
            let parts: BTreeSet<&str> =
                graph.functions.values().flat_map(|function| parts_in(&function.name)).collect();
            if let Some(missing) = PARTS.iter().find(|part| !parts.contains(*part)) {
                return Err(format!("the image holds nothing of glenoid::{missing}, so it proves nothing").into());
            }
            println!("{} functions, and no way to a panic", graph.functions.len());
            Ok(true)
        }
        Err(FirmwareError::BuildFailed(_)) => {
            let image = firmware::build_with_environment(toolchain, Image::PANIC_FREE, &[(LINK_ANYWAY, Some("1"))])?;
            println!("these can panic:");
            for function in panicking(&CallGraph::read(&Elf::read(&image)?)?) {
                println!("  {function}");
            }
            Ok(false)
        }
        Err(error) => Err(error.into()),
    }
}

/// The modules of the library that a function's name speaks of.
fn parts_in(name: &str) -> impl Iterator<Item = &str> {
    name.split("glenoid::").skip(1).filter_map(|rest| rest.split("::").next())
}

/// Functions that are not part of the panicking itself, and call one that is.
fn panicking(graph: &CallGraph) -> Vec<&str> {
    let panics = |name: &str| {
        let failing = ["panicking", "panic_already", "index_fail", "unwrap_failed", "expect_failed"];
        name.starts_with("core::") && failing.iter().any(|part| name.contains(part))
    };
    let outside = graph.functions.values().filter(|function| !panics(&function.name));
    let calls = outside.filter(|function| function.calls.iter().any(|to| panics(&graph.functions[to].name)));
    calls.map(|function| function.name.as_str()).collect()
}
