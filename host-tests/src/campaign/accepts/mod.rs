//! Random sequences of events against the device: two clients, a button, faults, restarts, a flash that refuses. The centre
//! in use is always the one that was accepted last, by one whom it was shown.
//!
//! The limits are short so that a sequence that makes sense reaches every state within some dozens of steps.

mod clients;
mod steps;
mod world;

use crate::wearer::{Wearer, WearerSettings};
use glenoid::can::Opcode;
use glenoid::device::{Config, Device};
use glenoid::procedure::transition::next;
use glenoid::procedure::{Limits, Settings, StateName, Trigger};
use glenoid::rig::{ASSUMED_BASE_RADIUS_MM, Drum, Rig, RigError};
use rayon::prelude::*;
use std::fmt;
use std::ops::Range;
use steps::Counts;
use world::{Tally, World};

/// Steps in one sequence.
const STEPS: u64 = 40;

/// What a campaign has seen. One that saw a wrong value in use has panicked, and named the sequence.
#[derive(Debug, Clone, Default)]
pub struct Outcome {
    /// Sequences that were played.
    pub sequences: u64,
    tally: Tally,
}

impl Outcome {
    /// Centres put in use: by a command, by the button.
    pub fn accepted(&self) -> [u64; 2] {
        [self.tally.accepted_by_command, self.tally.accepted_by_button]
    }

    /// Changes of state that the table knows and that no sequence has seen: nonsense alone would prove nothing.
    pub fn unseen(&self) -> Vec<(StateName, StateName)> {
        let all = StateName::ALL.into_iter().flat_map(|from| {
            let to = Trigger::ALL.into_iter().filter_map(move |trigger| next(from, trigger));
            to.filter(move |to| *to != from).map(move |to| (from, to))
        });
        all.filter(|change| !self.tally.changes.contains(change)).collect()
    }

    fn add(mut self, other: Self) -> Self {
        self.sequences += other.sequences;
        self.tally.changes.extend(other.tally.changes);
        self.tally.accepted_by_command += other.tally.accepted_by_command;
        self.tally.accepted_by_button += other.tally.accepted_by_button;
        self.tally.restarts += other.tally.restarts;
        self.tally.stores_failed += other.tally.stores_failed;
        self
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ([by_command, by_button], Tally { restarts, stores_failed, .. }) = (self.accepted(), &self.tally);
        write!(
            f,
            "{} sequences of {STEPS} steps: {by_command} centres accepted by a client, {by_button} by the button, \
             {restarts} restarts, {stores_failed} stores refused; 0 values in use that nobody had chosen",
            self.sequences
        )
    }
}

/// Plays sequences by their numbers; one alone is played again by its own.
///
/// # Errors
/// None in practice: the shoulder's constants are checked like any other rig's.
///
/// # Panics
/// With the sequence's number, when a value is in use that nobody has chosen, or the device breaks another promise.
pub fn run(sequences: Range<u64>) -> Result<Outcome, String> {
    let rig = rig().map_err(|error| error.text())?;
    let config =
        Config { limits: Limits::new(&rig, settings()).map_err(|error| error.to_string())?, ..Config::for_rig(rig) };
    let device = Device::new(&config);
    let poses = poses().map_err(|error| error.text())?;
    let play = |number| {
        let outcome = std::panic::catch_unwind(|| {
            let mut world = World::new(&device, number);
            (0..STEPS).for_each(|_| world.step(&poses));
            world.command(Opcode::Abort as u8, 0, 0);
            assert_eq!(world.state(), StateName::Idle, "after an abort");
            Outcome { sequences: 1, tally: world.tally }
        });
        outcome.unwrap_or_else(|_| panic!("sequence {number}"))
    };
    Ok(sequences.into_par_iter().map(play).reduce(Outcome::default, Outcome::add))
}

/// The shoulder with drums so fast that the arm can leap from pose to pose.
fn rig() -> Result<Rig<f32>, RigError> {
    let shoulder = Rig::<f32>::shoulder(ASSUMED_BASE_RADIUS_MM as f32)?;
    let drum = Drum { fastest_mm_per_s: 30_000.0, ..*shoulder.drum() };
    Rig::new(*shoulder.base_mm(), *shoulder.edges_mm(), drum, shoulder.length_noise_mm(), *shoulder.nominal())
}

/// Poses of one wearer, and a few of another: those contradict the first.
fn poses() -> Result<Vec<Counts>, RigError> {
    let mut poses = Vec::new();
    for (seed, count) in [(1, 24), (2, 6)] {
        let settings = WearerSettings { seed, noise_mm: 0.1, ..Default::default() };
        let mut wearer = Wearer::new(Rig::shoulder(ASSUMED_BASE_RADIUS_MM)?, settings);
        poses.extend((0..count).map(|_| wearer.next_pose().counts));
    }
    Ok(poses)
}

fn settings() -> Settings {
    Settings {
        hold_ms: 20,
        min_samples: 2,
        // poses are far apart in time here, not in space
        sample_jitter_ms: 2_000,
        enough_poses: 4,
        enough_poses_with_zeros: 4,
        target_sigma_mm: 0.5,
        verification_poses: 1,
        verification_deviation_mm: 5.0,
        max_attempts: 2,
        collecting_timeout_ms: 20_000,
        verifying_timeout_ms: 20_000,
        review_timeout_ms: 20_000,
        ..Settings::default()
    }
}
