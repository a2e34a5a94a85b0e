//! `cargo emulate`: boots the emulated drive board and leaves it running for any SLCAN client.

use std::error::Error;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use host_tests::command_line;
use host_tests::emulator::Options;
use host_tests::identify::input_error::InputError;
use host_tests::live::{Patient, Person, PersonKind, Running, machine, serve_slcan};
use host_tests::packages::Consent;

/// Boot the emulated drive board and leave it running; its log goes to the error output. Ctrl-C ends it.
#[derive(Parser)]
#[command(name = "cargo emulate", bin_name = "cargo emulate")]
struct Arguments {
    /// TCP port of the CAN bus as SLCAN, on this machine alone; 0: a free one
    #[arg(long, value_name = "PORT", default_value_t = 5601)]
    can_port: u16,
    /// TCP port of the rig link: encoder counts and button as lines of text; 0: a free one
    #[arg(long, value_name = "PORT", default_value_t = 5602)]
    rig_port: u16,
    /// File that stands for the flash of the centre in use, made where there is none; without it, the board begins
    /// without a centre and keeps none
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Let a virtual person sit at the arm, who moves when the board asks for another pose
    #[arg(long)]
    wearer: bool,
    /// That person: a ball joint (in an elbow's machine: an elbow), a centre that moves with the arm, a machine that is not
    /// as drawn, or an elbow that never bends
    #[arg(long, value_enum, default_value_t = PersonKind::Ball)]
    person: PersonKind,
    /// The machine that the person sits in, as `cargo identify` reads it; the board is told by parameters
    /// (`python -m glenoid parameters load RIG.toml`)
    #[arg(long, value_name = "RIG.toml", requires = "wearer")]
    rig: Option<PathBuf>,
    /// Seed of that person's poses and joint
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// How long that person holds a pose, ms
    #[arg(long, value_name = "MS", default_value_t = 700)]
    hold: u32,
    /// How long that person's movement from pose to pose takes, ms
    #[arg(long = "move", value_name = "MS", default_value_t = 500)]
    travel: u32,
    /// Install what is missing without asking
    #[arg(long)]
    yes: bool,
}

fn main() -> ExitCode {
    match run(&command_line::parse::<Arguments>()) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("cargo emulate: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<ExitCode, Box<dyn Error>> {
    let consent = if arguments.yes { Consent::Given } else { Consent::Ask };
    let seated = arguments.wearer.then(|| Ok((arguments.person(), machine(arguments.rig.as_deref())?)));
    let seated = seated.transpose().map_err(|error: InputError| error.to_string())?;
    let shared = TcpListener::bind((Ipv4Addr::LOCALHOST, arguments.can_port))?;
    let options = Options {
        rig_port: (arguments.rig_port != 0).then_some(arguments.rig_port),
        record: arguments.record.clone(),
        show_log: true,
        monitor: true,
        ..Options::default()
    };
    let running = Running::start(&options, seated, consent)?;
    let can = shared.local_addr()?;
    serve_slcan(running.bus.clone(), shared);
    introduce(can, running.rig_address(), running.patient.as_ref());
    running.until_the_end("cargo emulate")
}

impl Arguments {
    fn person(&self) -> Person {
        Person { kind: self.person, seed: self.seed, noise_mm: 0.1, hold_ms: self.hold, move_ms: self.travel }
    }
}

/// Says how to reach the board.
fn introduce(can: SocketAddr, rig: SocketAddr, patient: Option<&Patient>) {
    println!("CAN bus (SLCAN)  {can}, for any number of clients");
    println!("  calibrate:     python -m glenoid calibrate -i slcan -c socket://{can}");
    println!(
        r#"  python-can:    can.Bus(interface="slcan", channel="socket://{can}", bitrate=500000, sleep_after_open=0)"#
    );
    println!("  or:            python -m can.logger -i slcan -c socket://{can} -b 500000");
    match patient {
        Some(patient) => {
            println!("person           moves when the board asks for another pose; {}", patient.truth());
            println!(
                "  type           press, release (the button), silent, sound (the encoders), pull 3 (a cable), where (is the joint now?), reset (the board)"
            );
        }
        None => {
            println!("rig link         {rig}, for one client");
            println!("  for example:   e 0 0 0 0 0 0   (six encoder counts)   b 1   b 0   (button down, up)");
            println!("  nobody moves the arm: with --wearer a virtual person does");
            println!("  type           reset (the board)");
        }
    }
    println!("Ctrl-C ends the board.");
}
