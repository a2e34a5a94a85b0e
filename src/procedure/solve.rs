//! The estimator as the procedure sees it: one slice of work at a time, and a refusal in the terms of the reports.

use super::reason::Reason;
use crate::identification::estimator::Workspace;
use crate::identification::joint::{HeldCentre, Joint, MissingMotion, ShownMotion};
use crate::identification::{Estimator, EstimatorSettings, Identified, JointChoice, Machine, Pose, Progress, Refusal};
use crate::rig::Rig;

/// The estimator at work, and how much it has worked.
#[derive(Debug, Clone)]
pub struct Work {
    estimator: Estimator<f32>,
    slices: u32,
}

/// Passes over the poses that a sound set takes: two or three, the last one to see that it settled.
const USUAL_PASSES: u32 = 4;

impl Work {
    /// An estimator at its beginning.
    // Inlined so that it is built where it stays: 18 KB more of the stack otherwise (`cargo stack`).
    #[inline(always)]
    pub fn new(machine: &Machine<f32>, rig: &Rig<f32>) -> Self {
        Self { estimator: Estimator::new(machine, rig.nominal(), EstimatorSettings::for_rig(rig)), slices: 0 }
    }

    /// Back to the beginning, in place, for a model of the joint and with what a held phase has found.
    pub fn restart(&mut self, machine: &Machine<f32>, joint: JointChoice, held: Option<HeldCentre<f32>>) {
        self.estimator.restart_for(machine, joint, held);
        self.slices = 0;
    }

    /// How the centre moves by the last fit; `None` for a ball.
    ///
    /// # Errors
    /// [`Reason::MotionImplausible`].
    #[cfg_attr(feature = "ccm", unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
    pub fn motion(&self) -> Result<Option<ShownMotion>, Reason> {
        let Joint::Moving(moving) = self.estimator.joint() else { return Ok(None) };
        let [across_mm, all_mm] = self.estimator.path_sigmas_mm();
        ShownMotion::new(moving, across_mm, all_mm).map(Some).ok_or(Reason::MotionImplausible)
    }

    /// One slice of work.
    pub fn advance(&mut self, machine: &Machine<f32>, poses: &mut [Pose<f32>]) -> Progress<&Identified<f32>> {
        // A pose with many parameters takes several slices, and counts once.
        let is_new = !self.estimator.workspace().scratch.has_pose();
        self.slices = self.slices.saturating_add(is_new.into());
        self.estimator.advance(machine, poses)
    }

    /// The estimator, whose last fit judges the second set.
    pub const fn estimator(&self) -> &Estimator<f32> {
        &self.estimator
    }

    /// The same, to go on with a verification.
    pub fn estimator_mut(&mut self) -> &mut Estimator<f32> {
        &mut self.estimator
    }

    /// What it computes in, while it has nothing to do.
    pub fn workspace(&mut self) -> Workspace<'_, f32> {
        self.estimator.workspace()
    }

    /// How much of the work is done, 0 to below 1. How many passes there will be is not known before the end, so this
    /// grows more and more slowly and never reaches 1.
    pub fn share_done(&self, poses: usize) -> f32 {
        let (done, usual) = (self.slices as f32, (USUAL_PASSES * (poses as u32 + 1)) as f32);
        done / (done + usual * 0.5)
    }
}

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

    /// A reason about one pose of a set; no set of a run has more poses than a byte counts.
    fn about_pose(reason: Reason, pose: u32) -> Self {
        Self { pose: u8::try_from(pose).ok(), ..Self::of(reason) }
    }
}

impl From<Refusal> for Detail {
    fn from(refusal: Refusal) -> Self {
        match refusal {
            Refusal::TooFewPoses { .. } => Self::of(Reason::TooFewPoses),
            Refusal::BadLength { pose, cable, .. } => {
                Self { cable, ..Self::about_pose(Reason::LengthImpossible, pose) }
            }
            Refusal::NotClosing { pose, .. } | Refusal::PlatformDoesNotClose { pose } => {
                Self::about_pose(Reason::PoseDoesNotClose, pose)
            }
            Refusal::Singular => Self::of(Reason::Singular),
            Refusal::IterationCap => Self::of(Reason::NotConverged),
            Refusal::OneAxis { axis, .. } => Self { axis: Some(axis), ..Self::of(Reason::OneAxis) },
            Refusal::TooAlike { .. } => Self::of(Reason::TooAlike),
            Refusal::Weak { direction, sigma_mm } => {
                Self { axis: Some(direction), size_mm: Some(sigma_mm), ..Self::of(Reason::Weak) }
            }
            Refusal::NotRedundant { pose } => Self::about_pose(Reason::Weak, pose),
            Refusal::OffsetNotDetermined { cable, sigma_mm } => {
                Self { cable, size_mm: Some(sigma_mm), ..Self::of(Reason::ZeroNotDetermined) }
            }
            Refusal::TooFewForMovingCentre { .. } => Self::of(Reason::FewPosesForMovingCentre),
            Refusal::MissingMotion { missing: MissingMotion::Tilt, .. } => Self::of(Reason::TiltMissing),
            Refusal::MissingMotion { missing: MissingMotion::SecondPlane, direction, .. } => {
                Self { axis: Some(direction), ..Self::of(Reason::SecondPlaneMissing) }
            }
            Refusal::MissingMotion { missing: MissingMotion::Torsion, .. } => Self::of(Reason::TorsionMissing),
            Refusal::SlippedMidway { pose, size_mm, is_cuff } => {
                let reason = if is_cuff { Reason::CuffSlippedMidway } else { Reason::BaseSlippedMidway };
                Self { size_mm: Some(size_mm), ..Self::about_pose(reason, pose) }
            }
            Refusal::NotExplained { residual_mm } => {
                Self { size_mm: Some(residual_mm), ..Self::of(Reason::JointNotExplained) }
            }
            Refusal::NotHeld { scatter_mm } => Self { size_mm: Some(scatter_mm), ..Self::of(Reason::BladeNotHeld) },
            Refusal::HeldOfAnotherWearing { distance_mm } => {
                Self { size_mm: Some(distance_mm), ..Self::of(Reason::HeldOfAnotherWearing) }
            }
            Refusal::MachineNotAsStated => Self::of(Reason::MachineNotAsStated),
            Refusal::TooManyOutliers { .. } => Self::of(Reason::TooManyOutliers),
            Refusal::CentreNotFixed { migration_mm } => {
                Self { size_mm: Some(migration_mm), ..Self::of(Reason::NotABall) }
            }
        }
    }
}

/// Is this what the solver says of poses whose centre moves?
pub const fn is_refused_as_ball(reason: Reason) -> bool {
    matches!(
        reason,
        Reason::NotABall
            | Reason::TooManyOutliers
            | Reason::FewPosesForMovingCentre
            | Reason::TiltMissing
            | Reason::SecondPlaneMissing
            | Reason::TorsionMissing
    )
}

/// Can more poses turn this refusal into a result? Then the run goes on collecting instead of failing.
pub const fn is_cured_by_more_poses(reason: Reason) -> bool {
    matches!(
        reason,
        Reason::TooFewPoses
            | Reason::OneAxis
            | Reason::TooAlike
            | Reason::Weak
            | Reason::ZeroNotDetermined
            | Reason::Singular
            | Reason::NotConverged
            | Reason::TooManyOutliers
            | Reason::NotABall
            | Reason::FewPosesForMovingCentre
            | Reason::TiltMissing
            | Reason::SecondPlaneMissing
            | Reason::TorsionMissing
    )
}
