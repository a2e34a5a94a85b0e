//! `cargo view`: the emulated board, a person at its arm, and a page that shows both.

use std::error::Error;
use std::io;
use std::net::{Ipv4Addr, TcpListener};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use clap::Parser;
use host_tests::command_line;
use host_tests::emulator::{self, Emulator, Options};
use host_tests::firmware::{self, Image};
use host_tests::live::{Order, Patient, Person, PersonKind, SharedBus, build_page, serve_page, serve_slcan};
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
    /// The person: a ball joint, a centre that moves with the arm, or a machine that is not as drawn
    #[arg(long, value_enum, default_value_t = PersonKind::Ball)]
    person: PersonKind,
    /// Seed of the person's poses and centre
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
    let (stop, stopped) = mpsc::channel();
    ctrlc::set_handler(move || {
        let _ = stop.send(());
    })?;
    let listen = |port: u16| {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port));
        listener.map_err(|error| format!("port {port}: {error}; choose another one with --port"))
    };
    let (page_line, can_line) = (listen(arguments.port)?, listen(arguments.can_port.unwrap_or(0))?);
    emulator::ensure_installed(consent)?;
    let folder = build_page(consent)?;
    let image = firmware::build(Image::EMULATED, consent)?;
    let options = Options { record: arguments.record.clone(), monitor: true, ..Options::default() };
    let mut board = Emulator::start(&image, &options)?;
    let bus = SharedBus::new(board.can_address());
    let person = Person {
        kind: arguments.person,
        seed: arguments.seed,
        noise_mm: arguments.noise,
        hold_ms: arguments.hold,
        move_ms: 700,
    };
    let patient = Patient::sit_down(person, board.rig_address(), &bus)?;
    let (page, can, [x, y, z]) = (page_line.local_addr()?, can_line.local_addr()?, patient.truth_mm());
    serve_page(bus.clone(), page_line, folder);
    serve_slcan(bus, can_line);
    println!("page      http://{page}");
    println!("CAN bus   socket://{can} (SLCAN), for any number of clients");
    println!("person    true centre {x:.3} {y:.3} {z:.3} mm; type press, release, silent, sound, reset");
    println!("Ctrl-C ends it.");
    let (words, typed) = mpsc::channel();
    thread::spawn(move || io::stdin().lines().map_while(Result::ok).try_for_each(|line| words.send(line)));
    loop {
        match stopped.recv_timeout(Duration::from_millis(100)) {
            Ok(()) | Err(RecvTimeoutError::Disconnected) => return Ok(ExitCode::SUCCESS),
            Err(RecvTimeoutError::Timeout) => {}
        }
        if let Some(status) = board.exit_status() {
            let words = board.log().join("\n");
            eprintln!("cargo view: the board ended by itself ({status})\n{words}");
            return Ok(ExitCode::FAILURE);
        }
        while let Ok(word) = typed.try_recv() {
            match (word.trim(), Order::parse(&word)) {
                ("", _) => {}
                ("reset", _) => board.reset()?,
                (_, Some(order)) => patient.order(order),
                (word, None) => eprintln!("{word:?}: press, release, silent, sound and reset are known"),
            }
        }
    }
}
