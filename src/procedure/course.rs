//! How the poses of a run about a shoulder are collected, and what would help them most.

use super::guidance::Guidance;
use super::phase::Phase;

/// What a run about a shoulder has beside what every run has.
#[derive(Debug, Clone, Copy)]
pub(super) struct Course {
    /// Poses are captured while the arm moves slowly as well.
    pub in_motion: bool,
    /// The only phase, or which of two.
    pub phase: Phase,
    /// What would help the set most.
    pub advice: Guidance,
}

impl Course {
    /// Of a run that begins.
    pub const fn new(in_motion: bool, held_first: bool) -> Self {
        let (phase, advice) =
            if held_first { (Phase::Held, Guidance::HoldBlade) } else { (Phase::Only, Guidance::MoveOn) };
        Self { in_motion, phase, advice }
    }
}
