//! What a run hands out: pose by pose, the new centre, the end.

use super::guidance::Guidance;
use super::reason::Reason;
use super::solve::Detail;
use super::state::PoseSet;
use crate::identification::Identified;
use crate::identification::joint::ShownMotion;

/// A centre that passed identification and the second set. It becomes the live centre when it is accepted.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// The run that found it.
    pub run_id: u16,
    /// The boot in which it ran, modulo 2^16. Boot and run together never repeat.
    pub boot: u16,
    /// Whose arm it was made for; 0 = not said.
    pub wearer: u16,
    /// The centre, the radii, their covariance and how they were found. Of a moving centre: at the mean direction of the
    /// arm.
    pub identified: Identified<f32>,
    /// How the centre moves with the arm; `None` for a ball.
    pub motion: Option<ShownMotion>,
    /// What the second set said.
    pub verification: Verification,
}

/// What a second set of poses says about a centre that they did not identify (the paper's step 4, section III).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Verification {
    /// δE over the second set (Eq. 17), mm.
    pub deviation_mm: f32,
    /// The limit that it was held against, mm.
    pub limit_mm: f32,
    /// Poses in the second set.
    pub poses: u8,
}

/// What became of one pose.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PoseNotice {
    /// The set.
    pub set: PoseSet,
    /// Index in the set, from 0; for a refused pose the index that it would have had.
    pub index: u8,
    /// [`Reason::Fine`] when it was taken, else why not.
    pub reason: Reason,
    /// The cable meant by the reason, 1 to 6; 0 for none.
    pub cable: u8,
    /// Predicted σ of the centre in its worst direction with the first set so far, mm; None while the poses do not
    /// determine it.
    pub sigma_mm: Option<f32>,
    /// Angle to the nearest pose captured before, rad; None for the first.
    pub distance_rad: Option<f32>,
    /// What to do next.
    pub guidance: Guidance,
}

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Ending {
    /// The run.
    pub run_id: u16,
    /// Accepted, rejected, aborted, or why it failed, and what that is about.
    pub detail: Detail,
}
