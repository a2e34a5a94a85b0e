//! Cable length to encoder counts, on drums whose home lengths are not quite what the firmware believes.

use glenoid::rig::{CABLES, Drum};
use std::f64::consts::TAU;

/// Six drums with their encoders.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Encoder {
    mm_per_count: f64,
    true_home_mm: [f64; CABLES],
    zero_errors_mm: [f64; CABLES],
}

impl Encoder {
    /// Encoders on the drums that the firmware knows, except that each cable is longer by its zero error, mm, at
    /// count zero than the firmware believes.
    pub fn new(drum: &Drum<f64>, zero_errors_mm: [f64; CABLES]) -> Self {
        Self {
            mm_per_count: TAU * drum.radius_mm / drum.counts_per_turn,
            true_home_mm: std::array::from_fn(|k| drum.home_length_mm[k] + zero_errors_mm[k]),
            zero_errors_mm,
        }
    }

    /// Length of cable that one count stands for, mm.
    pub fn mm_per_count(&self) -> f64 {
        self.mm_per_count
    }

    /// Excess of each cable's length at count zero over the firmware's belief, mm.
    pub fn zero_errors_mm(&self) -> &[f64; CABLES] {
        &self.zero_errors_mm
    }

    /// The counts at six lengths, mm: rounded to the nearest count, so within half a count of the truth.
    pub fn counts(&self, lengths_mm: [f64; CABLES]) -> [i32; CABLES] {
        std::array::from_fn(|k| libm::round((lengths_mm[k] - self.true_home_mm[k]) / self.mm_per_count) as i32)
    }
}
