//! What a module's run has found, whichever joint it is about.

use crate::identification::Identified;
use crate::identification::joint::ShownMotion;
use crate::procedure::elbow::{ElbowCandidate, FoundHinge};
use crate::procedure::outcome::{Candidate, Verification};

/// A joint that passed identification and the second set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FoundJoint<'a> {
    /// A ball, or a centre that moves with the arm.
    Ball(&'a Candidate),
    /// A hinge.
    Hinge(&'a ElbowCandidate),
}

/// What it is, verified or not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum JointValue<'a> {
    /// The centre, and how it moves with the arm; `None` for a ball.
    Ball(&'a Identified<f32>, Option<&'a ShownMotion>),
    /// The hinge.
    Hinge(&'a FoundHinge),
}

impl<'a> FoundJoint<'a> {
    /// The run that found it.
    pub const fn run_id(&self) -> u16 {
        match self {
            Self::Ball(found) => found.run_id,
            Self::Hinge(found) => found.run_id,
        }
    }

    /// The boot in which it ran, modulo 2^16.
    pub const fn boot(&self) -> u16 {
        match self {
            Self::Ball(found) => found.boot,
            Self::Hinge(found) => found.boot,
        }
    }

    /// Whose arm it was made for; 0 = not said.
    pub const fn wearer(&self) -> u16 {
        match self {
            Self::Ball(found) => found.wearer,
            Self::Hinge(found) => found.wearer,
        }
    }

    /// What the second set said.
    pub const fn verification(&self) -> &'a Verification {
        match self {
            Self::Ball(found) => &found.verification,
            Self::Hinge(found) => &found.verification,
        }
    }

    /// What it is.
    pub const fn value(&self) -> JointValue<'a> {
        match self {
            Self::Ball(found) => JointValue::Ball(&found.identified, found.motion.as_ref()),
            Self::Hinge(found) => JointValue::Hinge(&found.found),
        }
    }
}
