//! The gates between a converged fit and a result: pure functions, each refuses for one reason.

use super::excitation::Excitation;
use super::pose::{Pose, PoseState};
use super::refusal::Refusal;
use super::settings::EstimatorSettings;
use super::uncertainty::worst_direction_of_point;
use crate::kinematics::LengthFault;
use crate::kinematics::cable_length::cable_number;
use crate::scalar::Real;
use nalgebra::{Matrix3, Vector3};

/// Minimum number of poses. Three determine the centre without redundancy: each of them can be wrong in one direction
/// without the others contradicting it, so such a set is refused by [`Refusal::NotRedundant`].
pub const MIN_POSES: usize = 3;

/// Minimum number of poses that remain when others are left out: a smaller set can agree by chance with a wrong pose in
/// it.
pub const MIN_POSES_AFTER_REJECTION: usize = 5;

/// Share of the squared excitation above which one pose dominates it.
const DOMINANT_SHARE: f64 = 0.5;

/// Mean over median of the squared distances of the poses' own centres, up to which the centre itself counts as not
/// fixed. A normal scatter in three dimensions has 1.27; a few outliers give much more.
const MIGRATION_RATIO: f64 = 4.0;

/// Refuses fewer than [`MIN_POSES`] poses with a rotation.
///
/// # Errors
/// [`Refusal::BadLength`] or [`Refusal::PlatformDoesNotClose`] for the first that has none.
pub fn require_placed<T: Real>(poses: &[Pose<T>]) -> Result<(), Refusal> {
    if poses.iter().filter(|pose| pose.is_placed()).count() >= MIN_POSES {
        return Ok(());
    }
    let first = poses.iter().enumerate().find(|(_, pose)| !pose.is_placed());
    Err(match first {
        Some((index, pose)) if pose.state == PoseState::Broken => {
            let cable = cable_number(pose.suspect_cables.trailing_zeros() as usize);
            Refusal::BadLength { pose: index as u32, cable, fault: LengthFault::BreaksTriangle }
        }
        first => Refusal::PlatformDoesNotClose { pose: first.map_or(0, |(index, _)| index as u32) },
    })
}

/// Sums over the poses: how far each moves the axis that all of them move least.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisMotion<T> {
    /// Poses that move it by more than half of the root mean square of all.
    moving: usize,
    /// Poses added.
    all: usize,
    /// Σ of the squared lengths by which the poses move it (a unit vector).
    squares: T,
    /// The largest of them, and the pose that it is of, from 0.
    largest: T,
    largest_pose: usize,
}

impl<T: Real> Default for AxisMotion<T> {
    fn default() -> Self {
        Self { moving: 0, all: 0, squares: T::zero(), largest: T::zero(), largest_pose: 0 }
    }
}

impl<T: Real> AxisMotion<T> {
    /// Adds pose `index` with its rotation ({P} to {B}).
    pub fn add(&mut self, index: usize, rotation: &Matrix3<T>, excitation: &Excitation<T>) {
        let moved = rotation * excitation.axis_in_platform - excitation.axis;
        let square = moved.norm_squared();
        self.all += 1;
        self.moving += usize::from(square > excitation.least_rad * excitation.least_rad * T::of(0.25));
        self.squares += square;
        if square > self.largest {
            (self.largest, self.largest_pose) = (square, index);
        }
    }

    /// The pose that makes more than half of the squared excitation, from 0; `None` when none does.
    pub fn dominant_pose(&self) -> Option<usize> {
        (self.largest > self.squares * T::of(DOMINANT_SHARE)).then_some(self.largest_pose)
    }
}

/// Refuses poses that are all alike, or that turn about one common axis. The latter also when at most one pose and a
/// tenth of all leave that axis: the others could not contradict them, so the direction is not determined reliably.
///
/// # Errors
/// [`Refusal::TooAlike`], [`Refusal::OneAxis`].
pub fn require_excitation<T: Real>(
    excitation: &Excitation<T>,
    motion: &AxisMotion<T>,
    settings: &EstimatorSettings<T>,
) -> Result<(), Refusal> {
    if excitation.second_rad < settings.spread_limit_rad {
        return Err(Refusal::TooAlike { spread_rad: excitation.second_rad.to_f32() });
    }
    if excitation.least_rad < settings.excitation_limit_rad || 10 * motion.moving <= motion.all + 10 {
        let axis = to_f32(&excitation.axis);
        return Err(Refusal::OneAxis { axis, excitation_rad: excitation.least_rad.to_f32() });
    }
    Ok(())
}

/// How well the centre is determined, for the noise of the gate.
#[derive(Clone, Copy, Debug)]
pub struct Accuracy<'a, T> {
    /// Covariance of the centre, mm².
    pub centre: &'a Matrix3<T>,
    /// The same if the machine's constants and the joint's motion were known, mm².
    pub centre_alone: Option<Matrix3<T>>,
    /// The encoder offset with the largest 1σ: cable from 0, 1σ in mm. `None` when the offsets are not estimated.
    pub worst_offset: Option<(usize, T)>,
}

/// Refuses a standard deviation of the centre above `limit_mm`; names an encoder offset when the offsets alone cause
/// it.
///
/// # Errors
/// [`Refusal::Weak`], [`Refusal::OffsetNotDetermined`].
pub fn require_accuracy<T: Real>(accuracy: &Accuracy<'_, T>, limit_mm: T) -> Result<(), Refusal> {
    let (sigma_mm, direction) = worst_direction_of_point(accuracy.centre);
    // Also refuses NaN, and what is infinite where no limit is set.
    if sigma_mm <= limit_mm && sigma_mm.is_a_number() {
        return Ok(());
    }
    if let (Some((cable, offset_sigma_mm)), Some(alone)) = (accuracy.worst_offset, accuracy.centre_alone)
        && worst_direction_of_point(&alone).0 <= limit_mm
    {
        return Err(Refusal::OffsetNotDetermined { cable: cable_number(cable), sigma_mm: offset_sigma_mm.to_f32() });
    }
    Err(Refusal::Weak { direction: direction.map(Real::to_f32), sigma_mm: sigma_mm.to_f32() })
}

/// Decides why a set is refused as a ball: a few outliers, or a joint centre that is not fixed.
///
/// `variance_mm2`: mean square of the poses' own centres along one axis, mm². `median_mm2`: median of their squared
/// distances from the common centre, mm². `rejected`: poses beyond the inlier limit.
pub fn migration_or_outliers<T: Real>(variance_mm2: T, median_mm2: T, rejected: usize, poses: usize) -> Refusal {
    if variance_mm2 * T::of(3.0) <= median_mm2 * T::of(MIGRATION_RATIO) {
        Refusal::CentreNotFixed { migration_mm: variance_mm2.root().to_f32() }
    } else {
        Refusal::TooManyOutliers { rejected: rejected as u32, poses: poses as u32 }
    }
}

fn to_f32<T: Real>(vector: &Vector3<T>) -> [f32; 3] {
    [vector.x.to_f32(), vector.y.to_f32(), vector.z.to_f32()]
}
