//! The estimator's refusals in the terms of the reports.

use crate::identification::hinge::HingeRefusal;
use crate::procedure::reason::Reason;
use crate::procedure::solve::Detail;

impl From<HingeRefusal> for Detail {
    fn from(refusal: HingeRefusal) -> Self {
        match refusal {
            HingeRefusal::TooFewPoses { .. } => Self::of(Reason::TooFewPoses),
            HingeRefusal::BadLength { pose, cable, .. } => {
                Self { cable, pose: u8::try_from(pose).ok(), ..Self::of(Reason::LengthImpossible) }
            }
            // A rig with so few cables has a drawing.
            HingeRefusal::TooFewCables { .. } => Self::of(Reason::Singular),
            HingeRefusal::TooLittleFlexion { .. } => Self::of(Reason::TooAlike),
            HingeRefusal::TwoAxesFit { distance_mm, .. } => {
                Self { size_mm: Some(distance_mm), ..Self::of(Reason::TwoAxesFit) }
            }
            HingeRefusal::Weak { .. } => Self::of(Reason::Weak),
            HingeRefusal::TooManyOutliers { .. } => Self::of(Reason::TooManyOutliers),
            HingeRefusal::SecondAxis { axis_in_platform, .. } => {
                Self { axis: Some(axis_in_platform), ..Self::of(Reason::SecondAxis) }
            }
            HingeRefusal::NotAHinge { residual_mm } => {
                Self { size_mm: Some(residual_mm), ..Self::of(Reason::NotAHinge) }
            }
        }
    }
}

/// Can more poses turn this refusal into a result? Then the run goes on collecting instead of failing.
pub const fn is_cured_by_more_poses(reason: Reason) -> bool {
    matches!(
        reason,
        Reason::TooFewPoses | Reason::TooAlike | Reason::TwoAxesFit | Reason::Weak | Reason::TooManyOutliers
    )
}
