//! Cable length to encoder counts, on drums whose home lengths are not quite what the firmware believes.

use glenoid::rig::{CABLES, Correction, Drum};
use std::f64::consts::TAU;

/// Six drums with their encoders.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Encoder {
    mm_per_count: f64,
    true_home_mm: [f64; CABLES],
    zero_errors_mm: [f64; CABLES],
    home_mm: [f64; CABLES],
    scale: [f64; CABLES],
    offset_mm: [f64; CABLES],
}

impl Encoder {
    /// Encoders on the drums that the firmware knows, except that each cable is longer by its zero error, mm, at
    /// count zero than the firmware believes.
    pub fn new(drum: &Drum<f64>, zero_errors_mm: [f64; CABLES]) -> Self {
        Self {
            mm_per_count: TAU * drum.radius_mm / drum.counts_per_turn,
            true_home_mm: std::array::from_fn(|k| drum.home_length_mm[k] + zero_errors_mm[k]),
            zero_errors_mm,
            home_mm: drum.home_length_mm,
            scale: [1.0; CABLES],
            offset_mm: [0.0; CABLES],
        }
    }

    /// The same on drums and with offsets of their own: reading = home + scale (L - home) + offset, less the zero error.
    #[must_use]
    pub fn with(self, correction: &Correction<f64>) -> Self {
        Self { scale: correction.scale, offset_mm: correction.offset_mm, ..self }
    }

    /// What each length reads too much at home, mm.
    pub fn offsets_mm(&self) -> [f64; CABLES] {
        std::array::from_fn(|k| self.offset_mm[k] - self.zero_errors_mm[k])
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
        std::array::from_fn(|k| {
            // Of an ideal drum nothing: its counts are the same to the digit.
            let beyond_mm = (self.scale[k] - 1.0) * (lengths_mm[k] - self.home_mm[k]) + self.offset_mm[k];
            libm::round((lengths_mm[k] - self.true_home_mm[k] + beyond_mm) / self.mm_per_count) as i32
        })
    }
}
