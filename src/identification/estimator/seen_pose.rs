//! A pose at the estimate that it was looked at with.

use crate::identification::marginal_information::MarginalInformation;
use crate::identification::parameters::PoseAt;
use crate::kinematics::{CableLengths, LengthJacobian};
use crate::scalar::Real;
use nalgebra::{Matrix3, Vector3};

/// A pose at the present estimate, its rotation and scatter eliminated.
#[derive(Clone, Copy, Debug)]
pub struct SeenPose<T> {
    /// Rotation from {P} to {B}.
    pub(super) rotation: Matrix3<T>,
    pub(super) lengths: CableLengths<T>,
    pub(super) jacobian: LengthJacobian<T>,
    /// Rotation and scatter eliminated.
    pub(super) marginal: MarginalInformation<T>,
    /// S before the scatter was eliminated.
    pub(super) unscattered: Matrix3<T>,
    /// δ̂: its own centre less the model's, mm.
    pub(super) own_centre_mm: Vector3<T>,
    /// Sum of its squared length residuals, mm².
    pub(super) squares_mm2: T,
}

impl<T: Real> SeenPose<T> {
    /// What its columns are worked out from.
    pub(super) fn at(&self) -> PoseAt<'_, T> {
        PoseAt { rotation: &self.rotation, lengths: &self.lengths, jacobian: &self.jacobian }
    }
}
