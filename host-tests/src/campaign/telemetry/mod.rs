//! A consumer of telemetry on a crowded bus: the device sends 50 sets a second beside 2 000 foreign frames, the consumer
//! misses frames and hears some twice, the device starts anew now and then, and a client asks for whole reports.
//!
//! Time is the bus's own, in microseconds: six hours of it take a minute.

mod bus;
mod consumer;
mod segment;
mod sent;

use rayon::prelude::*;
use std::fmt;

/// Telemetry's default rate, sets a second.
const RATE_HZ: u64 = 50;
/// Sets in one segment; segments run on all cores.
const SEGMENT_SETS: u64 = 10_000;
/// An answer must be there so soon after the command was handed to the client's controller, µs.
const ANSWER_LIMIT_US: u64 = 50_000;

/// What a campaign has seen.
#[derive(Debug, Clone, Copy, Default)]
pub struct Outcome {
    /// Time on the bus, µs, and how much of it the bus was busy.
    time_us: u64,
    busy_us: u64,
    foreign_frames: u64,
    /// Sets that the device sent.
    pub sent: u64,
    /// Sets that the consumer took: all of them, and those that were mixed, too old, or older than one before.
    pub taken: u64,
    /// No set that the device sent.
    pub mixed: u64,
    /// Taken too late, or after a newer one.
    pub stale: u64,
    lost: u64,
    refused: u64,
    oldest_us: u64,
    /// What a consumer without the protection would have taken for a set: those that were mixed.
    pub mixed_for_the_careless: u64,
    /// Commands, and those whose answer came too late or not at all.
    pub commands: u64,
    /// See `commands`.
    pub late_answers: u64,
    slowest_answer_us: u64,
    restarts: u64,
}

impl Outcome {
    /// Everything that must hold, and the experiment has shown that it could have failed.
    pub fn holds(&self) -> bool {
        let sound = self.mixed + self.stale + self.late_answers == 0;
        sound && self.taken > self.sent / 2 && self.commands > 0 && self.mixed_for_the_careless > 0
    }

    fn add(self, other: Self) -> Self {
        Self {
            time_us: self.time_us + other.time_us,
            busy_us: self.busy_us + other.busy_us,
            foreign_frames: self.foreign_frames + other.foreign_frames,
            sent: self.sent + other.sent,
            taken: self.taken + other.taken,
            mixed: self.mixed + other.mixed,
            stale: self.stale + other.stale,
            lost: self.lost + other.lost,
            refused: self.refused + other.refused,
            oldest_us: self.oldest_us.max(other.oldest_us),
            mixed_for_the_careless: self.mixed_for_the_careless + other.mixed_for_the_careless,
            commands: self.commands + other.commands,
            late_answers: self.late_answers + other.late_answers,
            slowest_answer_us: self.slowest_answer_us.max(other.slowest_answer_us),
            restarts: self.restarts + other.restarts,
        }
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ms = |us: u64| us as f64 / 1e3;
        let seconds = self.time_us as f64 / 1e6;
        writeln!(
            f,
            "{seconds:.0} s on the bus, {:.0} foreign frames a second, load {:.0} %, {} restarts of the device",
            self.foreign_frames as f64 / seconds,
            100.0 * self.busy_us as f64 / self.time_us as f64,
            self.restarts
        )?;
        writeln!(
            f,
            "{} sets sent, {} taken, the oldest {:.1} ms after it was packed; {} lost, {} refused",
            self.sent,
            self.taken,
            ms(self.oldest_us),
            self.lost,
            self.refused
        )?;
        writeln!(
            f,
            "{} mixed and {} stale ones taken (without the protection: {} mixed)",
            self.mixed, self.stale, self.mixed_for_the_careless
        )?;
        write!(
            f,
            "{} commands, the slowest answer after {:.1} ms, {} later than {:.0} ms",
            self.commands,
            ms(self.slowest_answer_us),
            self.late_answers,
            ms(ANSWER_LIMIT_US)
        )
    }
}

/// Runs the bus until the device has sent about so many sets.
///
/// # Errors
/// None in practice: the shoulder's constants are checked like any other rig's.
pub fn run(sets: u64, seed: u64) -> Result<Outcome, String> {
    let scene = segment::Scene::new()?;
    let segments = sets.div_ceil(SEGMENT_SETS);
    let play = |number: u64| {
        let sets = SEGMENT_SETS.min(sets - number * SEGMENT_SETS);
        scene.play(seed.wrapping_add(number), sets * 1_000 / RATE_HZ)
    };
    Ok((0..segments).into_par_iter().map(play).reduce(Outcome::default, Outcome::add))
}
