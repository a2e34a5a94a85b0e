//! What a pose says of the centre at the present estimate.

use super::fit::Fit;
use super::model::Model;
use crate::identification::machine::Machine;
use crate::identification::marginal_information::{MarginalInformation, own_centre};
use crate::identification::parameters::{PoseAt, Rows};
use crate::identification::pose::Pose;
use crate::identification::pose_in_work::sensitivity;
use crate::kinematics::{CableLengths, LengthJacobian};
use crate::scalar::Real;
use nalgebra::{Matrix3, Vector3};

/// A pose at the present estimate, its rotation and scatter eliminated.
#[derive(Clone, Copy, Debug)]
pub(super) struct SeenPose<T> {
    /// Rotation from {P} to {B}.
    pub rotation: Matrix3<T>,
    lengths: CableLengths<T>,
    jacobian: LengthJacobian<T>,
    /// Rotation and scatter eliminated.
    pub marginal: MarginalInformation<T>,
    /// S before the scatter was eliminated.
    pub unscattered: Matrix3<T>,
    /// δ̂: its own centre less the model's, mm.
    pub own_centre_mm: Vector3<T>,
    /// Sum of its squared length residuals, mm².
    pub squares_mm2: T,
}

impl<T: Real> SeenPose<T> {
    fn at(&self) -> PoseAt<'_, T> {
        PoseAt { rotation: &self.rotation, lengths: &self.lengths, jacobian: &self.jacobian }
    }
}

impl<T: Real> Fit<T> {
    /// A pose at the present estimate, rotation and scatter eliminated. `None` without a rotation.
    pub fn seen(&self, machine: &Machine<T>, pose: &Pose<T>) -> Option<SeenPose<T>> {
        let lengths = self.estimate.corrected(machine, pose.lengths());
        let rotation = pose.rotation();
        let jacobian = self.jacobian(&rotation, &lengths);
        let mut marginal = MarginalInformation::new(&jacobian).ok()?;
        let (unscattered, squares_mm2) = (marginal.information(), marginal.squares_mm2());
        let own_centre_mm = own_centre(&unscattered, &marginal.gradient_mm());
        let variance = self.variance_mm2() * machine.relative_variance(pose.samples);
        marginal.add_scatter(self.joint.scatter_mm2() / variance);
        Some(SeenPose { rotation, lengths, jacobian, marginal, unscattered, own_centre_mm, squares_mm2 })
    }

    /// Its equations go to work: their columns follow.
    pub fn put_to_work(&mut self, seen: &SeenPose<T>) {
        let at = seen.at();
        self.scratch.put_pose(&at, &seen.marginal, self.joint.features(&at), T::one());
    }

    /// Derivative of S δ̂ with the unknowns: three rows, one column for each unknown.
    pub fn sensitivity(&self, machine: &Machine<T>, seen: &SeenPose<T>) -> Rows<T> {
        let at = seen.at();
        let features = self.joint.features(&at);
        sensitivity(&Model { machine, estimate: &self.estimate, joint: &self.joint, features }, &at, &seen.marginal)
    }
}
