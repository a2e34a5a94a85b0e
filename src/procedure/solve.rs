//! What the procedure asks of the identification: the centre, a forecast of its error bar, and words for a refusal.

use super::reason::Reason;
use crate::identification::Refusal;

/// A refusal in the terms of the reports.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Detail {
    /// Why.
    pub reason: Reason,
    /// The pose meant, from 0.
    pub pose: Option<u8>,
    /// The cable meant, 1 to 6; 0 for none.
    pub cable: u8,
    /// The size of what is wrong, mm.
    pub size_mm: Option<f32>,
    /// The axis or direction meant, in {B}.
    pub axis: Option<[f32; 3]>,
}

impl Detail {
    /// A reason about nothing in particular.
    pub const fn of(reason: Reason) -> Self {
        Self { reason, pose: None, cable: 0, size_mm: None, axis: None }
    }
}

impl From<Refusal> for Detail {
    fn from(refusal: Refusal) -> Self {
        match refusal {
            Refusal::TooFewPoses { .. } => Self::of(Reason::TooFewPoses),
            Refusal::BadLength { pose, cable, .. } => {
                Self { pose: Some(pose), cable, ..Self::of(Reason::LengthImpossible) }
            }
            Refusal::NotClosing { pose, .. } | Refusal::PlatformDoesNotClose { pose } => {
                Self { pose: Some(pose), ..Self::of(Reason::PoseDoesNotClose) }
            }
            Refusal::Singular => Self::of(Reason::Singular),
            Refusal::IterationCap => Self::of(Reason::NotConverged),
            Refusal::OneAxis { axis, .. } => Self { axis: Some(axis), ..Self::of(Reason::OneAxis) },
            Refusal::TooAlike { .. } => Self::of(Reason::TooAlike),
            Refusal::Weak { direction, sigma_mm } => {
                Self { axis: Some(direction), size_mm: Some(sigma_mm), ..Self::of(Reason::Weak) }
            }
            Refusal::TooManyOutliers { .. } => Self::of(Reason::TooManyOutliers),
            Refusal::NotABall { wander_mm } => Self { size_mm: Some(wander_mm), ..Self::of(Reason::NotABall) },
        }
    }
}

/// Can more poses turn this refusal into a result? Then the run goes on collecting instead of failing.
pub const fn is_cured_by_more_poses(reason: Reason) -> bool {
    matches!(
        reason,
        Reason::TooFewPoses
            | Reason::OneAxis
            | Reason::TooAlike
            | Reason::Weak
            | Reason::Singular
            | Reason::NotConverged
            | Reason::TooManyOutliers
    )
}
