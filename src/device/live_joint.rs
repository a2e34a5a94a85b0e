//! Where a moving joint centre is now: R C + t of the pose that the cables show.

use crate::identification::marginal_information::MarginalInformation;
use crate::identification::uncertainty::{unpacked, worst_direction_of_point};
use crate::identification::{Identified, Machine};
use crate::kinematics::{CableLengths, Geometry, JointCentre, LengthJacobian, PlatformPose};
use crate::linear_algebra::{inverse_of_positive_definite, rounding, unit};
use nalgebra::{Matrix3, Matrix6, Vector3};

/// The joint centre in the platform, and what is needed to place it in {B}.
#[derive(Debug, Clone)]
pub(super) struct LiveJoint {
    geometry: Geometry<f32>,
    in_platform_mm: Vector3<f32>,
    covariance_mm2: Matrix3<f32>,
    noise_variance_mm2: f32,
}

impl LiveJoint {
    /// Of an identified centre. `None` when its radii do not fix a place in the platform.
    pub fn new(machine: &Machine<f32>, identified: &Identified<f32>) -> Option<Self> {
        let geometry = machine.geometry_with(&identified.machine);
        let in_platform_mm = JointCentre::from_parameters(&identified.parameters, &geometry).in_platform_mm;
        // The radii's covariance is J Σ Jᵀ with rows J along the arms from the end-points (`uncertainty::parameters_of`).
        let arms = geometry.end_points_mm().map(|end_point| unit(&(in_platform_mm - end_point)).transpose());
        let inverse = Matrix3::from_rows(&arms).try_inverse()?;
        let covariance: Matrix6<f32> = unpacked(&identified.covariance_mm2);
        let of_radii = covariance.fixed_view::<3, 3>(3, 3);
        let noise = machine.noise_mm().max(identified.noise_mm);
        Some(Self {
            covariance_mm2: inverse * of_radii * inverse.transpose(),
            in_platform_mm,
            geometry,
            noise_variance_mm2: machine.sample_variance_mm2(noise),
        })
    }

    /// The centre in {B}, and its σ in its worst direction, mm. `None` for a pose that does not determine it.
    pub fn at(&self, platform: &PlatformPose<f32>, lengths: &CableLengths<f32>) -> Option<(Vector3<f32>, f32)> {
        let rotation = &platform.rotation;
        let in_base_mm = rotation * self.in_platform_mm + platform.origin_mm;
        let centre = JointCentre { in_base_mm, in_platform_mm: self.in_platform_mm };
        let pose = MarginalInformation::new(&LengthJacobian::new(&self.geometry, &centre, rotation, lengths)).ok()?;
        let of_lengths = inverse_of_positive_definite(&pose.information(), rounding())? * self.noise_variance_mm2;
        let covariance = rotation * self.covariance_mm2 * rotation.transpose() + of_lengths;
        Some((in_base_mm, worst_direction_of_point(&covariance).0))
    }
}
