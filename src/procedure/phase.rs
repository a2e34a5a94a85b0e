//! One phase or two: where a shoulder blade was held first, the joint centre in the platform is known from that.

use crate::identification::JointChoice;
use crate::identification::gates::MIN_POSES;
use crate::identification::joint::{HeldCentre, MIN_HELD_POSES};

/// Poses of a held phase that are enough.
const ENOUGH_HELD_POSES: u8 = 20;
/// Poses of a moving centre that are enough: fewer than 18 are refused, with 30 the path is known to 1 to 2 mm.
const ENOUGH_MOVING_POSES: u8 = 30;

/// The phase in which poses are collected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Phase {
    /// There is one only: a ball, unless the poses say otherwise.
    Only,
    /// The first of two: the shoulder blade is held.
    Held,
    /// The second of two, with what the first has found.
    Free(HeldCentre<f32>),
}

impl Phase {
    /// Poses that the solver wants at least.
    pub const fn min_poses(self) -> usize {
        match self {
            Self::Held => MIN_HELD_POSES,
            Self::Only | Self::Free(_) => MIN_POSES,
        }
    }

    /// Poses that are enough, where `of_ball` are for a ball. `moves`: the solver has refused a ball.
    pub const fn enough_poses(self, of_ball: u8, moves: bool) -> u8 {
        match self {
            Self::Held => ENOUGH_HELD_POSES,
            Self::Only if !moves => of_ball,
            Self::Only | Self::Free(_) => ENOUGH_MOVING_POSES,
        }
    }

    /// What the solver is to find.
    pub const fn joint(self) -> (JointChoice, Option<HeldCentre<f32>>) {
        match self {
            Self::Only => (JointChoice::Auto, None),
            Self::Held => (JointChoice::Held, None),
            Self::Free(held) => (JointChoice::Auto, Some(held)),
        }
    }
}
