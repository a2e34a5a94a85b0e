//! The whole arm: the shoulder's ball, the elbow's hinge and the wrist's ball as one chain, from all cable lengths to the
//! hand in the shoulder's base, with covariance.
//!
//! ```text
//! hand ──wrist's lengths──> wrist base ──mount──> forearm ──elbow's──> upper arm ──mount──> cuff ──shoulder's──> {B}
//! ```
//!
//! Every module is identified by itself, so that their errors are independent: each carries a point with its covariance
//! into the next body, and adds its own.

mod mount;

pub use mount::Mount;

use super::carried_point::CarriedPoint;
use super::estimator::Estimator;
use super::hinge::{HingeEstimator, MAX_CABLES};
use super::machine::Machine;
use super::pose::Pose;
use crate::linear_algebra::non_negative_root;
use crate::scalar::Real;
use nalgebra::Vector3;

/// A module of the arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Module {
    /// The ball between trunk and upper arm.
    Shoulder,
    /// The hinge between upper arm and forearm.
    Elbow,
    /// The ball between forearm and hand.
    Wrist,
}

/// A ball that is identified: an estimator at its end, and its machine.
#[derive(Clone, Copy, Debug)]
pub struct Ball<'a, T: Real> {
    /// The estimator.
    pub estimator: &'a Estimator<T>,
    /// The machine.
    pub machine: &'a Machine<T>,
}

/// The arm's joints as identified, and how the modules stand on the limbs between them.
#[derive(Clone, Copy, Debug)]
pub struct Arm<'a, T: Real> {
    /// The shoulder.
    pub shoulder: Ball<'a, T>,
    /// The elbow's base in the shoulder's platform.
    pub upper_arm: Mount<T>,
    /// The elbow, at its end.
    pub elbow: &'a HingeEstimator<T>,
    /// The wrist's base in the elbow's platform.
    pub forearm: Mount<T>,
    /// The wrist.
    pub wrist: Ball<'a, T>,
}

/// All lengths of the arm in one posture.
#[derive(Clone, Copy, Debug)]
pub struct ArmPose<T: Real> {
    /// The shoulder's.
    pub shoulder: Pose<T>,
    /// The elbow's, mm.
    pub elbow_mm: [T; MAX_CABLES],
    /// The wrist's.
    pub wrist: Pose<T>,
}

/// Poses that the modules' sets might have further.
#[derive(Clone, Copy, Debug)]
pub struct FurtherPoses<'a, T: Real> {
    /// The shoulder's, placed.
    pub shoulder: &'a [Pose<T>],
    /// The elbow's: their angles from the hinge's own zero, rad.
    pub elbow_rad: &'a [T],
    /// The wrist's, placed.
    pub wrist: &'a [Pose<T>],
}

impl<T: Real> Default for FurtherPoses<'_, T> {
    fn default() -> Self {
        Self { shoulder: &[], elbow_rad: &[], wrist: &[] }
    }
}

/// Where the arm is, in the shoulder's base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmPosition<T> {
    /// The elbow: the axis' point next to the middle of the elbow's base points.
    pub elbow: CarriedPoint<T>,
    /// The wrist's centre.
    pub wrist: CarriedPoint<T>,
    /// The hand.
    pub hand: CarriedPoint<T>,
    /// What each module adds to the hand's σ, root of the summed variances, mm: shoulder, elbow, wrist; and both mounts.
    pub by_module_mm: [T; 4],
}

/// The lengths of the limbs, each with its 1σ, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segments<T> {
    /// From the shoulder's centre to the elbow's axis.
    pub upper_arm_mm: (T, T),
    /// From the elbow's axis to the wrist's centre.
    pub forearm_mm: (T, T),
}

impl<T: Real> Arm<'_, T> {
    /// Where the elbow, the wrist and the hand are. `hand_mm`: the hand in the wrist's platform.
    ///
    /// # Errors
    /// The module whose lengths fit no pose.
    pub fn position(&self, pose: &ArmPose<T>, hand_mm: &Vector3<T>) -> Result<ArmPosition<T>, Module> {
        let way @ [.., in_base] = self.way_of_hand(pose, hand_mm, &FurtherPoses::default())?;
        let wrist = self.forearm.carry(&self.wrist.centre());
        let wrist = self.elbow.carry(&pose.elbow_mm, &wrist).ok_or(Module::Elbow)?;
        let wrist = self.shoulder.carry(&pose.shoulder, &self.upper_arm.carry(&wrist)).ok_or(Module::Shoulder)?;
        let elbow = self.upper_arm.carry(&self.elbow.axis_point());
        let elbow = self.shoulder.carry(&pose.shoulder, &elbow).ok_or(Module::Shoulder)?;

        // A rotation leaves the summed variances as they are.
        let [hand, on_wrist_base, on_forearm, on_elbow_base, on_upper_arm, _] =
            way.map(|point| point.covariance_mm2.trace());
        let mounts = on_forearm - on_wrist_base + on_upper_arm - on_elbow_base;
        let shoulder = in_base.covariance_mm2.trace() - on_upper_arm;
        let by_module_mm = [shoulder, on_elbow_base - on_forearm, on_wrist_base - hand, mounts].map(non_negative_root);
        Ok(ArmPosition { elbow, wrist, hand: in_base, by_module_mm })
    }

    /// The hand with the covariance that it would have with further poses in the modules' sets. Their lengths need not be known:
    /// what a pose adds to what is known of a module depends on where it is alone.
    ///
    /// # Errors
    /// The module whose lengths fit no pose, or whose further poses determine no rotation.
    pub fn hand_with(
        &self,
        pose: &ArmPose<T>,
        hand_mm: &Vector3<T>,
        further: &FurtherPoses<'_, T>,
    ) -> Result<CarriedPoint<T>, Module> {
        self.way_of_hand(pose, hand_mm, further).map(|[.., in_base]| in_base)
    }

    /// The hand in the wrist's platform and base, in the elbow's, in the shoulder's.
    fn way_of_hand(
        &self,
        pose: &ArmPose<T>,
        hand_mm: &Vector3<T>,
        further: &FurtherPoses<'_, T>,
    ) -> Result<[CarriedPoint<T>; 6], Module> {
        let hand = CarriedPoint::exact(*hand_mm);
        let on_wrist_base = self.wrist.carry_with(&pose.wrist, &hand, further.wrist).ok_or(Module::Wrist)?;
        let on_forearm = self.forearm.carry(&on_wrist_base);
        let on_elbow_base =
            self.elbow.carry_with(&pose.elbow_mm, &on_forearm, further.elbow_rad).ok_or(Module::Elbow)?;
        let on_upper_arm = self.upper_arm.carry(&on_elbow_base);
        let in_base =
            self.shoulder.carry_with(&pose.shoulder, &on_upper_arm, further.shoulder).ok_or(Module::Shoulder)?;
        Ok([hand, on_wrist_base, on_forearm, on_elbow_base, on_upper_arm, in_base])
    }

    /// The lengths of the limbs: what a therapist can compare with a tape.
    pub fn segments(&self) -> Segments<T> {
        let shoulder = self.upper_arm.carry_back(&self.shoulder.centre_in_platform());
        let wrist = self.forearm.carry(&self.wrist.centre());
        Segments {
            upper_arm_mm: self.elbow.distance_to_axis_mm(&shoulder, false),
            forearm_mm: self.elbow.distance_to_axis_mm(&wrist, true),
        }
    }
}

impl<T: Real> Ball<'_, T> {
    fn carry(&self, pose: &Pose<T>, point: &CarriedPoint<T>) -> Option<CarriedPoint<T>> {
        self.estimator.carry(self.machine, pose, point)
    }

    fn carry_with(&self, pose: &Pose<T>, point: &CarriedPoint<T>, further: &[Pose<T>]) -> Option<CarriedPoint<T>> {
        self.estimator.carry_with(self.machine, pose, point, further)
    }

    /// The centre in the base.
    fn centre(&self) -> CarriedPoint<T> {
        self.estimator.centre_point()
    }

    /// The centre in the platform.
    fn centre_in_platform(&self) -> CarriedPoint<T> {
        let centre = self.estimator.centre_in_platform();
        CarriedPoint { at_mm: centre.in_platform_mm, covariance_mm2: centre.covariance_mm2 }
    }
}
