//! `cargo emulate`: boots the emulated drive board and leaves it running for any SLCAN client.

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

use clap::Parser;
use host_tests::command_line;
use host_tests::emulator::{self, Emulator, Options};
use host_tests::firmware::{self, Image};
use host_tests::packages::Consent;

/// Boot the emulated drive board and leave it running; its log goes to the error output. Ctrl-C ends it.
#[derive(Parser)]
#[command(name = "cargo emulate", bin_name = "cargo emulate")]
struct Arguments {
    /// TCP port of the CAN bus as SLCAN, on this machine alone
    #[arg(long, value_name = "PORT", default_value_t = 5601)]
    can_port: u16,
    /// TCP port of the rig link: encoder counts and button as lines of text
    #[arg(long, value_name = "PORT", default_value_t = 5602)]
    rig_port: u16,
    /// File that stands for the flash of the centre in use, made where there is none; without it, the board begins
    /// without a centre and keeps none
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Install what is missing without asking
    #[arg(long)]
    yes: bool,
}

fn main() -> ExitCode {
    match run(&Arguments::parse_from(command_line::arguments())) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("cargo emulate: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<ExitCode, Box<dyn Error>> {
    let consent = if arguments.yes { Consent::Given } else { Consent::Ask };
    let (stop, stopped) = mpsc::channel();
    // a second Ctrl-C finds nobody listening, and need not
    ctrlc::set_handler(move || {
        let _ = stop.send(());
    })?;
    emulator::ensure_installed(consent)?;
    let image = firmware::build(Image::EMULATED, consent)?;
    let options = Options {
        can_port: Some(arguments.can_port),
        rig_port: Some(arguments.rig_port),
        record: arguments.record.clone(),
        show_log: true,
        ..Options::default()
    };
    let mut board = Emulator::start(&image, &options)?;
    let (can, rig) = (board.can_address(), board.rig_address());
    println!("CAN bus (SLCAN)  {can}");
    println!(
        r#"  python-can:    can.Bus(interface="slcan", channel="socket://{can}", bitrate=500000, sleep_after_open=0)"#
    );
    println!("  or:            python -m can.logger -i slcan -c socket://{can} -b 500000");
    println!("rig link         {rig}");
    println!("  for example:   e 0 0 0 0 0 0   (six encoder counts)   b 1   b 0   (button down, up)");
    println!("Ctrl-C ends the board.");
    loop {
        match stopped.recv_timeout(Duration::from_millis(200)) {
            Ok(()) | Err(RecvTimeoutError::Disconnected) => return Ok(ExitCode::SUCCESS),
            Err(RecvTimeoutError::Timeout) => {}
        }
        if let Some(status) = board.exit_status() {
            eprintln!("cargo emulate: the board ended by itself ({status})");
            return Ok(ExitCode::FAILURE);
        }
    }
}
