//! What the person at the arm should do next, in words that need no mathematics.

use crate::kinematics::rotation::rotation_vector;
use crate::scalar::Real;
use nalgebra::{Matrix3, Vector3};

/// The advice. The numbers go over CAN and are never renumbered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Guidance {
    /// Nothing is to be done.
    Nothing = 0,
    /// Go on to another pose and hold it.
    MoveOn = 1,
    /// Move further away from the poses so far.
    MoveFurther = 2,
    /// Tilt the arm more.
    TiltMore = 3,
    /// Turn the arm about its own length.
    TurnAboutLength = 4,
    /// Tilt the arm in another plane.
    AnotherPlane = 5,
    /// Tighten the cable that is named.
    TightenCable = 6,
    /// Check the encoders.
    CheckEncoders = 7,
    /// Wait: the device computes.
    Wait = 8,
    /// Decide: accept or reject.
    Decide = 9,
    /// See why the run ended, and acknowledge it.
    Acknowledge = 10,
    /// First phase: hold the shoulder blade, and go on to another pose.
    HoldBlade = 11,
    /// Second phase: let the shoulder blade go, and go on to another pose.
    ReleaseBlade = 12,
    /// Bend the joint further than in the poses so far.
    BendFurther = 13,
}

impl Guidance {
    /// All advice, in the order of the numbers.
    pub const ALL: [Self; 14] = [
        Self::Nothing,
        Self::MoveOn,
        Self::MoveFurther,
        Self::TiltMore,
        Self::TurnAboutLength,
        Self::AnotherPlane,
        Self::TightenCable,
        Self::CheckEncoders,
        Self::Wait,
        Self::Decide,
        Self::Acknowledge,
        Self::HoldBlade,
        Self::ReleaseBlade,
        Self::BendFurther,
    ];

    /// The number on the wire.
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// The advice with this number.
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|advice| advice.code() == code)
    }

    /// The advice in words.
    pub const fn text(self) -> &'static str {
        match self {
            Self::Nothing => "nothing to do",
            Self::MoveOn => "move to another pose and hold it",
            Self::MoveFurther => "move further before holding the arm",
            Self::TiltMore => "tilt the arm more",
            Self::TurnAboutLength => "turn the arm about its own length",
            Self::AnotherPlane => "tilt the arm in another plane",
            Self::TightenCable => "tighten the cable",
            Self::CheckEncoders => "check the encoders",
            Self::Wait => "wait",
            Self::Decide => "accept or reject the new centre",
            Self::Acknowledge => "see the reason, then acknowledge",
            Self::HoldBlade => "hold the shoulder blade still, move the arm to another pose and hold it",
            Self::ReleaseBlade => "let the shoulder blade go, move the arm to another pose and hold it",
            Self::BendFurther => "bend the joint further before holding it",
        }
    }
}

/// Standard deviation of the tilts, in the plane in which the arm was tilted most, below which more tilt helps most:
/// 10 degrees, half of what random poses up to 45 degrees have. Tilting to 55 instead of 20 degrees halves the error
/// bar. Rad.
const TILT_RAD: f32 = 0.17;
/// The same in the plane in which it was tilted least, rad. Poses in one plane leave the centre free along an axis; four
/// more in other planes sharpen it from 0.73 to 0.06 mm.
const OTHER_PLANE_RAD: f32 = 0.12;
/// The same for turning about the arm's length, rad. It helps only who tilts in one plane: from 0.73 to 0.10 mm.
const TORSION_RAD: f32 = 0.07;
/// So many poses after the advice to tilt in another plane, it is taken that the arm cannot.
const PATIENCE: u8 = 4;
/// Standard deviation of the turning about the arm's length below which more of it helps a moving centre most, rad (10
/// degrees): half of what random poses up to ±30 degrees have.
const TORSION_OF_MOVING_RAD: f32 = 0.17;

/// How widely the captured poses are spread over the three ways in which the arm can turn.
///
/// Each pose's rotation vector relative to the first pose, in {B}; sums of them and of their products. {B}'s z axis
/// lies along the arm at home.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    first: Option<Matrix3<f32>>,
    poses: u16,
    sum: Vector3<f32>,
    products: Matrix3<f32>,
    /// Poses since [`Guidance::AnotherPlane`] was first advised in vain.
    in_one_plane: u8,
}

impl Default for Spread {
    fn default() -> Self {
        Self { first: None, poses: 0, sum: Vector3::zeros(), products: Matrix3::zeros(), in_one_plane: 0 }
    }
}

impl Spread {
    /// Adds the rotation ({P} to {B}) of a captured pose.
    pub fn add(&mut self, rotation: &Matrix3<f32>) {
        let first = *self.first.get_or_insert(*rotation);
        let vector = rotation_vector(&first, rotation);
        self.sum += vector;
        self.products += vector * vector.transpose();
        self.poses = self.poses.saturating_add(1);
        let in_one_plane = matches!(self.advice(), Guidance::AnotherPlane | Guidance::TurnAboutLength);
        self.in_one_plane = if in_one_plane { self.in_one_plane.saturating_add(1) } else { 0 };
    }

    /// What would help most where the centre moves with the arm: turning about its length more than elsewhere.
    pub fn advice_for_moving(&self) -> Guidance {
        let little = TORSION_OF_MOVING_RAD * TORSION_OF_MOVING_RAD;
        match self.advice() {
            Guidance::MoveOn if self.poses > 0 && self.covariance().m33 < little => Guidance::TurnAboutLength,
            advice => advice,
        }
    }

    /// Covariance of the rotation vectors, rad².
    fn covariance(&self) -> Matrix3<f32> {
        let share = 1.0 / f32::from(self.poses);
        let mean = self.sum * share;
        self.products * share - mean * mean.transpose()
    }

    /// What would help most.
    pub fn advice(&self) -> Guidance {
        if self.poses == 0 {
            return Guidance::MoveOn;
        }
        let covariance = self.covariance();
        // Eigenvalues of the horizontal 2x2 block: variance of the tilt in its widest and its narrowest plane.
        let (a, b, c) = (covariance.m11, covariance.m22, covariance.m12);
        let middle = (a + b) * 0.5;
        let radius = ((a - b) * (a - b) * 0.25 + c * c).root();
        let is_below = |variance: f32, limit_rad: f32| variance < limit_rad * limit_rad;
        if is_below(middle + radius, TILT_RAD) {
            Guidance::TiltMore
        } else if is_below(middle - radius, OTHER_PLANE_RAD) && is_below(covariance.m33, TORSION_RAD) {
            if self.in_one_plane < PATIENCE { Guidance::AnotherPlane } else { Guidance::TurnAboutLength }
        } else {
            Guidance::MoveOn
        }
    }
}
