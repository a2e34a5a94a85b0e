//! `cargo view`: the emulated board, a person at its arm, and a page that shows both.

use std::error::Error;
use std::net::{Ipv4Addr, TcpListener};
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use host_tests::command_line;
use host_tests::emulator::Options;
use host_tests::live::{Patient, Person, PersonKind, Running, build_page, machine, serve_page, serve_slcan};
use host_tests::packages::Consent;

/// Boot the emulated board with a virtual person at its arm, and show both on a page. Ctrl-C ends it.
#[derive(Parser)]
#[command(name = "cargo view", bin_name = "cargo view")]
struct Arguments {
    /// Port of the page, on this machine alone
    #[arg(long, default_value_t = 8080)]
    port: u16,
    /// TCP port of the CAN bus as SLCAN, for other clients; without it, a free one
    #[arg(long, value_name = "PORT")]
    can_port: Option<u16>,
    /// The person: a ball joint (in an elbow's machine: an elbow), a centre that moves with the arm, a machine that is not
    /// as drawn, or an elbow that never bends
    #[arg(long, value_enum, default_value_t = PersonKind::Ball)]
    person: PersonKind,
    /// The machine that the person sits in, as `cargo identify` reads it; the board is told by parameters
    /// (`python -m glenoid parameters load RIG.toml`)
    #[arg(long, value_name = "RIG.toml")]
    rig: Option<PathBuf>,
    /// Seed of the person's poses and joint
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Largest error of a cable length, mm
    #[arg(long, value_name = "MM", default_value_t = 0.1)]
    noise: f64,
    /// How long the person holds a pose, ms
    #[arg(long, value_name = "MS", default_value_t = 900)]
    hold: u32,
    /// File that stands for the flash of the centre in use
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Install what is missing without asking
    #[arg(long)]
    yes: bool,
}

fn main() -> ExitCode {
    match run(&command_line::parse::<Arguments>()) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("cargo view: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<ExitCode, Box<dyn Error>> {
    let consent = if arguments.yes { Consent::Given } else { Consent::Ask };
    // before anything is built or installed for it
    let machine = machine(arguments.rig.as_deref()).map_err(|error| error.to_string())?;
    let listen = |port: u16| {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port));
        listener.map_err(|error| format!("port {port}: {error}; choose another one with --port"))
    };
    let (page_line, can_line) = (listen(arguments.port)?, listen(arguments.can_port.unwrap_or(0))?);
    let folder = build_page(consent)?;
    let options = Options { record: arguments.record.clone(), monitor: true, ..Options::default() };
    let person = Person {
        kind: arguments.person,
        seed: arguments.seed,
        noise_mm: arguments.noise,
        hold_ms: arguments.hold,
        move_ms: 700,
    };
    let running = Running::start(&options, Some((person, machine)), consent)?;
    let (page, can) = (page_line.local_addr()?, can_line.local_addr()?);
    serve_page(running.bus.clone(), page_line, folder);
    serve_slcan(running.bus.clone(), can_line);
    println!("page      http://{page}");
    println!("CAN bus   socket://{can} (SLCAN), for any number of clients");
    if let Some(truth) = running.patient.as_ref().map(Patient::truth) {
        println!("person    {truth}; type press, release, silent, sound, pull 3, where, reset");
    }
    println!("Ctrl-C ends it.");
    running.until_the_end("cargo view")
}
