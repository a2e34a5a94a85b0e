//! Cuts the power in the middle of every flash operation of a store, then again in the middle of the recovery.
//!
//! The records of a history are numbered; the run id of a record is its number, and every other field follows from it,
//! so that a mixture of two records is found. What must hold at each power-up:
//! * the record that is read is one that was stored, whole;
//! * it is not older than the newest one whose store had returned, nor than any that an earlier power-up read;
//! * the next store works.

mod scheme;

pub use scheme::{Entries, OnePage, ParameterPages, Scheme, TwoPages, WithoutCommit};

use crate::flash::{MockFlash, TornWord};
use glenoid::identification::Rejected;
use glenoid::identification::machine::MachineDeviation;
use glenoid::record::Record;
use glenoid::rig::Parameters;
use rand::seq::index::sample;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::fmt;
use std::ops::AddAssign;

/// Pages of the flash; the store lies in the last two.
pub const PAGES: usize = 3;
/// The first byte of the store.
pub const STORE_FROM: u32 = crate::flash::PAGE_LEN as u32;
/// The rig of all records.
pub const RIG: u32 = 0xC0FF_EE11;

/// What a campaign found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tally {
    /// Cuts in the middle of a store.
    pub first_cuts: u64,
    /// Cuts in the middle of the recovery from such a cut.
    pub second_cuts: u64,
    /// A record was there before, and none was read.
    pub lost: u64,
    /// What was read was never stored, or was older than it may be.
    pub wrong: u64,
    /// The store after the recovery failed, or did not last.
    pub stuck: u64,
}

impl Tally {
    /// All cuts.
    pub fn cuts(&self) -> u64 {
        self.first_cuts + self.second_cuts
    }

    /// Everything that must not happen.
    pub fn failures(&self) -> u64 {
        self.lost + self.wrong + self.stuck
    }

    /// Adds what came of one cut: however often a record is missed afterwards, it was lost once.
    fn add_one(&mut self, cut: Self) {
        *self += Self { lost: cut.lost.min(1), wrong: cut.wrong.min(1), stuck: cut.stuck.min(1), ..cut };
    }
}

impl AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        self.first_cuts += other.first_cuts;
        self.second_cuts += other.second_cuts;
        self.lost += other.lost;
        self.wrong += other.wrong;
        self.stuck += other.stuck;
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} cuts in a store, {} in the recovery: {} lost, {} wrong, {} next stores failed",
            self.first_cuts, self.second_cuts, self.lost, self.wrong, self.stuck
        )
    }
}

/// The record with this number, 1 or more.
pub fn record(number: u16) -> Record {
    let value = f32::from(number);
    let spread = |k: usize| value + k as f32 / 32.0;
    Record {
        run_id: number,
        boot: number,
        wearer: 2 * number,
        serial: u32::from(number) << 16,
        rig: RIG,
        firmware: [number as u8, 2, 3],
        parameters: Parameters::from_array(std::array::from_fn(spread)),
        covariance_mm2: std::array::from_fn(spread),
        zeros_mm: std::array::from_fn(spread),
        zero_sigmas_mm: std::array::from_fn(spread),
        noise_mm: value,
        deviation_mm: value,
        excitation_rad: value,
        poses: number,
        left_out: number as u8 % 26,
        rejected: std::array::from_fn(|k| Rejected { pose: k as u32, cables: number as u8 }),
        iterations: number as u8,
        termination: 1,
        verification_poses: number as u8,
        verification_deviation_mm: value,
        verification_limit_mm: value,
        motion: None,
        machine: MachineDeviation {
            base_mm: std::array::from_fn(spread),
            ends_mm: std::array::from_fn(spread),
            scale: std::array::from_fn(spread),
        },
    }
}

/// A flash with a history.
#[derive(Clone)]
struct Bench<S> {
    flash: MockFlash,
    scheme: S,
    /// Number of the oldest record that may be read; 0 while none need be there.
    floor: u16,
    /// Number of the newest record that was ever given to a store.
    newest: u16,
}

impl<S: Scheme> Bench<S> {
    /// A store with a few records behind it.
    fn new(torn: TornWord, seed: u64, history: u16) -> Self {
        let flash = MockFlash::new(PAGES, torn, seed);
        let mut bench = Self { flash, scheme: S::default(), floor: 0, newest: 0 };
        for _ in 0..history {
            bench.store();
        }
        bench
    }

    /// Stores the next record. Called with the power failing in it, it does not return in reality.
    fn store(&mut self) -> bool {
        self.newest += 1;
        let stored = self.scheme.store(&mut self.flash, &record(self.newest)) && !self.flash.is_off();
        if stored {
            self.floor = self.newest;
        }
        stored
    }

    fn load(&mut self, tally: &mut Tally) {
        let found = self.scheme.load(&mut self.flash, RIG);
        match found {
            // whatever came of it, nobody learned of it
            _ if self.flash.is_off() => {}
            None if self.floor != 0 => tally.lost += 1,
            None => {}
            Some(read) => {
                let number = read.run_id;
                if (self.floor..=self.newest).contains(&number) && read == record(number) {
                    self.floor = number;
                } else {
                    tally.wrong += 1;
                }
            }
        }
    }

    /// The power comes back, twice; then a store must work.
    fn recover(&mut self) -> Tally {
        let mut tally = Tally::default();
        self.flash.power_up();
        self.load(&mut tally);
        self.load(&mut tally);
        let stored = self.store();
        tally.stuck += u64::from(!stored);
        self.load(&mut tally);
        tally
    }

    /// Operations of the flash that `work` takes.
    fn operations(&self, work: impl FnOnce(&mut Self)) -> u32 {
        let mut trial = self.clone();
        let before = trial.flash.operations();
        work(&mut trial);
        trial.flash.operations() - before
    }

    fn fork(&self, seed: u64) -> Self {
        Self { flash: self.flash.fork(seed), ..self.clone() }
    }
}

/// Cuts every operation of one store, and [`Scheme::SECOND_CUTS`] of the recovery from each of these cuts.
pub fn cut_everywhere<S: Scheme>(torn: TornWord, seed: u64) -> Tally {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let history = random.random_range(0..4);
    let before = Bench::<S>::new(torn, seed, history);
    let mut tally = Tally::default();
    for first in 0..before.operations(|bench| assert!(bench.store())) {
        let mut cut = before.fork(random.random());
        cut.flash.cut_after(first);
        cut.store();
        cut.flash.power_up();
        tally.first_cuts += 1;
        tally.add_one(cut.clone().recover());

        let operations = cut.operations(|bench| {
            bench.load(&mut Tally::default());
            bench.store();
        });
        let seconds = sample(&mut random, operations as usize, S::SECOND_CUTS.min(operations as usize));
        for second in seconds {
            let mut cut_again = cut.fork(random.random());
            cut_again.flash.cut_after(second as u32);
            let mut trial = Tally::default();
            cut_again.load(&mut trial);
            if !cut_again.flash.is_off() {
                cut_again.store();
            }
            // what is torn may read otherwise than when the operations were counted, and need fewer of them
            trial.second_cuts = u64::from(cut_again.flash.is_off());
            trial += cut_again.recover();
            tally.add_one(trial);
        }
    }
    tally
}

/// A long life: `stores` stores one after the other, each cut somewhere or not at all, and every power-up in between cut
/// somewhere or not at all.
pub fn random_life<S: Scheme>(torn: TornWord, seed: u64, stores: u32) -> Tally {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut bench = Bench::<S>::new(torn, seed, 0);
    let mut tally = Tally::default();
    let operations = Bench::<S>::new(torn, seed, 1).operations(|bench| assert!(bench.store()));
    for _ in 0..stores {
        if random.random_bool(0.8) {
            bench.flash.cut_after(random.random_range(0..operations));
        }
        bench.store();
        tally.first_cuts += u64::from(bench.flash.is_off());
        while bench.flash.is_off() {
            bench.flash.power_up();
            if random.random_bool(0.5) {
                bench.flash.cut_after(random.random_range(0..3));
            }
            bench.load(&mut tally);
            tally.second_cuts += u64::from(bench.flash.is_off());
        }
        bench.flash.power_up();
        if random.random_bool(0.1) {
            tally += bench.clone().recover();
        }
    }
    tally
}
