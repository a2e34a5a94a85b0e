//! Models of the joint: a ball, whose centre is fixed, or a centre that moves with the arm, as in living shoulders.

mod arm_frame;
mod held;
mod motion;
mod moving_centre;
mod scatter;
mod shown_motion;

pub use arm_frame::{ArmFrame, FEATURES, Features, SHOWN_FEATURES};
pub use held::{HeldCentre, MIN_HELD_POSES};
pub use motion::{ArmMotion, MIN_MOVING_POSES, MissingMotion};
pub use moving_centre::{FREE_OF_JOINT, MAX_JOINT, MovingCentre, persistence};
pub use scatter::Scatter;
pub use shown_motion::{MOTION_PARTS, ShownMotion};

use super::marginal_information::MarginalInformation;
use super::parameters::{CentreFeatures, Equations, MAX_FEATURES};
use crate::kinematics::rotation::{rotation_of, turned};
use crate::kinematics::{AttitudeSolver, CableLengths, CableSet, Geometry, JointCentre, LengthJacobian};
use crate::scalar::Real;
use nalgebra::{Matrix3, Matrix6, UnitQuaternion, Vector3};

/// Scatter of held poses along an axis beyond which the shoulder blade was not held, mm. With a tenth of the blade's
/// motion left it is 0.36 to 0.85 mm, with half of it 0.8 to 2.5 mm.
const MAX_HELD_SCATTER_MM: f64 = 1.0;

/// The model of the joint that is being estimated.
#[derive(Clone, Debug, PartialEq)]
pub enum Joint<T> {
    /// A ball: O is fixed.
    Ball,
    /// A ball whose centre scatters: the shoulder blade is held, but never quite.
    Held(Scatter<T>),
    /// O(R) = O0 + A φ(R), and a scatter of its own.
    Moving(MovingCentre<T>),
}

impl<T: Real> Joint<T> {
    /// Parameters beside O and C.
    pub fn count(&self) -> usize {
        match self {
            Self::Ball | Self::Held(_) => 0,
            Self::Moving(_) => MAX_JOINT,
        }
    }

    /// Parameters that the poses determine: of A all but one combination and the trefoils' columns, which are mostly what their
    /// prior says.
    pub fn free_parameters(&self) -> i32 {
        match self {
            Self::Ball | Self::Held(_) => 0,
            Self::Moving(_) => FREE_OF_JOINT as i32 - 1,
        }
    }

    /// The joint centre in both bodies in a pose with this rotation ({P} to {B}).
    pub fn centre_at(&self, centre: &JointCentre<T>, rotation: &Matrix3<T>) -> JointCentre<T> {
        match self {
            Self::Ball | Self::Held(_) => *centre,
            Self::Moving(moving) => {
                JointCentre { in_base_mm: centre.in_base_mm + moving.displacement_mm(rotation), ..*centre }
            }
        }
    }

    /// The Jacobian of a pose's lengths about this joint. For a moving centre its motion with the rotation is included.
    #[cfg_attr(feature = "ccm", unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
    pub fn jacobian(
        &self,
        geometry: &Geometry<T>,
        centre: &JointCentre<T>,
        rotation: &Matrix3<T>,
        lengths: &CableLengths<T>,
    ) -> LengthJacobian<T> {
        let Self::Moving(moving) = self else { return LengthJacobian::new(geometry, centre, rotation, lengths) };
        let (displacement_mm, turning) = moving.displacement_mm_and_turning(rotation);
        let there = JointCentre { in_base_mm: centre.in_base_mm + displacement_mm, ..*centre };
        let mut jacobian = LengthJacobian::new(geometry, &there, rotation, lengths);
        jacobian.include_motion(&turning);
        jacobian
    }

    /// The rotation that fits best about this joint, from one nearby; `None` when none is found.
    pub fn track(
        &self,
        geometry: &Geometry<T>,
        centre: &JointCentre<T>,
        start: UnitQuaternion<T>,
        lengths: &CableLengths<T>,
    ) -> Option<UnitQuaternion<T>> {
        let there = self.centre_at(centre, &rotation_of(&start));
        let mut attitude = AttitudeSolver { geometry, centre: &there }.track(start, lengths, CableSet::ALL)?.attitude;
        if let Self::Moving(_) = self {
            // The centre moves with the rotation: two more Gauss-Newton steps with that included.
            for _ in 0..2 {
                let jacobian = self.jacobian(geometry, centre, &rotation_of(&attitude), lengths);
                attitude = turned(&attitude, &MarginalInformation::new(&jacobian).ok()?.turn);
            }
        }
        Some(attitude)
    }

    /// Variance of the scatter of a pose's own centre along each axis, mm².
    pub fn scatter_mm2(&self) -> T {
        match self {
            Self::Ball => T::zero(),
            Self::Held(scatter) => scatter.variance_mm2(),
            Self::Moving(moving) => moving.scatter.variance_mm2(),
        }
    }

    /// By how much the covariance of the fit is widened for what the model does not explain; 1 for a ball.
    pub fn variance_factor(&self) -> T {
        match self {
            Self::Ball | Self::Held(_) => T::one(),
            Self::Moving(moving) => moving.variance_factor(),
        }
    }

    /// Variance along each axis that the model does not explain, mm²; 0 for a ball.
    pub fn lack_of_fit_mm2(&self) -> T {
        match self {
            Self::Ball | Self::Held(_) => T::zero(),
            Self::Moving(moving) => moving.lack_of_fit_mm2(),
        }
    }

    /// Covariance of the centre in {B} for an arm that may lie askew to the platform's normal, mm², in a pose with this rotation:
    /// across the arm. The same rotation brings a joint centre in the platform that is off by as much, so no length shows it. 0
    /// for a ball.
    pub fn askew_covariance_mm2(&self, rotation: &Matrix3<T>) -> Matrix3<T> {
        let variance = self.askew_mm2();
        rotation * Matrix3::from_diagonal(&Vector3::new(variance, variance, T::zero())) * rotation.transpose()
    }

    /// The same of O at the arm's mean direction and C together, mm²: both move, and the lengths stay.
    pub fn askew_covariance_of_centre_mm2(&self) -> Matrix6<T> {
        let mut covariance = Matrix6::zeros();
        if let Self::Moving(moving) = self {
            let mean = moving.frame.mean();
            let variance = moving.askew_mm2();
            let in_platform = Matrix3::from_diagonal(&Vector3::new(variance, variance, T::zero()));
            let mixed = mean * in_platform;
            covariance.fixed_view_mut::<3, 3>(0, 0).copy_from(&(mixed * mean.transpose()));
            covariance.fixed_view_mut::<3, 3>(0, 3).copy_from(&mixed);
            covariance.fixed_view_mut::<3, 3>(3, 0).copy_from(&mixed.transpose());
            covariance.fixed_view_mut::<3, 3>(3, 3).copy_from(&in_platform);
        }
        covariance
    }

    /// Variance of that along each axis across the arm, mm².
    pub fn askew_mm2(&self) -> T {
        match self {
            Self::Ball | Self::Held(_) => T::zero(),
            Self::Moving(moving) => moving.askew_mm2(),
        }
    }

    /// The shoulder blade was held: the poses scatter as little as those of a blade that is.
    pub fn is_held_still(&self) -> bool {
        matches!(self, Self::Held(scatter) if scatter.sigma_mm() <= T::of(MAX_HELD_SCATTER_MM))
    }

    /// The scatter, where the model has one.
    pub fn scatter_mut(&mut self) -> Option<&mut Scatter<T>> {
        match self {
            Self::Ball => None,
            Self::Held(scatter) => Some(scatter),
            Self::Moving(moving) => Some(&mut moving.scatter),
        }
    }

    /// Features of a pose's rotation; none for a ball.
    pub fn features(&self, rotation: &Matrix3<T>) -> CentreFeatures<T> {
        const { assert!(FEATURES <= MAX_FEATURES) };
        match self {
            Self::Ball | Self::Held(_) => CentreFeatures::new(),
            Self::Moving(moving) => CentreFeatures::from_slice(&moving.frame.features(rotation)).unwrap_or_default(),
        }
    }

    /// Adds the prior, times the noise's variance, mm². The first parameter is unknown `first`.
    pub fn add_prior(&self, equations: &mut Equations<T>, first: usize, variance_mm2: T) {
        if let Self::Moving(moving) = self {
            moving.add_prior(equations, first, variance_mm2);
        }
    }

    /// Moves the parameters by a step.
    pub fn apply(&mut self, step: &[T]) {
        if let Self::Moving(moving) = self {
            moving.apply(step);
        }
    }
}
