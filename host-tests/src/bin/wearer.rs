//! `wearer`: plays the person at the arm of an emulated board (`cargo emulate`) until it is stopped: moves the arm to a
//! random pose, holds it still, and on to the next.

use clap::Parser;
use glenoid::rig::{ASSUMED_BASE_RADIUS_MM, Rig};
use host_tests::command_line;
use host_tests::wearer::{Pose, Wearer, WearerSettings};
use std::error::Error;
use std::io::Write;
use std::net::TcpStream;
use std::process::ExitCode;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Time between two samples of the encoders, ms.
const PERIOD_MS: u32 = 10;

/// Play the person at the arm of an emulated board
#[derive(Parser)]
struct Options {
    /// Port of the rig link
    #[arg(long, default_value_t = 5602)]
    rig_port: u16,
    /// Seed of the random poses and of the true centre
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Largest error of a cable length, mm
    #[arg(long, default_value_t = 0.1)]
    noise: f64,
    /// Duration of a movement, ms
    #[arg(long = "move", default_value_t = 400)]
    move_ms: u32,
    /// How long a pose is held, ms
    #[arg(long = "hold", default_value_t = 600)]
    hold_ms: u32,
}

fn main() -> ExitCode {
    match play(&Options::parse_from(command_line::arguments())) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("wearer: {error}");
            ExitCode::FAILURE
        }
    }
}

fn play(options: &Options) -> Result<(), Box<dyn Error>> {
    let settings = WearerSettings { seed: options.seed, noise_mm: options.noise, ..WearerSettings::default() };
    let mut wearer = Wearer::new(Rig::shoulder(ASSUMED_BASE_RADIUS_MM).map_err(|error| error.text())?, settings);
    let [x, y, z, ..] = wearer.truth().to_array();
    println!("true centre: {x:.3} {y:.3} {z:.3} mm");
    let mut link = Link { stream: TcpStream::connect(("127.0.0.1", options.rig_port))?, next: Instant::now() };
    let mut at: Pose = wearer.home();
    loop {
        for _ in 0..options.hold_ms / PERIOD_MS {
            link.sample(&at.counts)?;
        }
        let pose = wearer.next_pose();
        for counts in wearer.motion(&at, &pose, options.move_ms, PERIOD_MS) {
            link.sample(&counts)?;
        }
        at = pose;
    }
}

struct Link {
    stream: TcpStream,
    next: Instant,
}

impl Link {
    /// Sends one sample when its time has come.
    fn sample(&mut self, counts: &[i32; 6]) -> Result<(), std::io::Error> {
        sleep(self.next.saturating_duration_since(Instant::now()));
        self.next += Duration::from_millis(u64::from(PERIOD_MS));
        let [c1, c2, c3, c4, c5, c6] = counts;
        self.stream.write_all(format!("e {c1} {c2} {c3} {c4} {c5} {c6}\n").as_bytes())
    }
}
