//! What a pose says of the centre at the present estimate.

use super::fit::Fit;
use super::model::Model;
use crate::identification::machine::Machine;
use crate::identification::marginal_information::{MarginalInformation, own_centre};
use crate::identification::parameters::PoseAt;
use crate::identification::pose::Pose;
use crate::identification::pose_in_work::PoseInWork;
use crate::scalar::Real;
use nalgebra::{Matrix3, Vector3};

/// A pose at the present estimate, its rotation and scatter eliminated.
#[derive(Clone, Copy, Debug)]
pub(super) struct SeenPose<T> {
    /// Rotation from {P} to {B}.
    pub rotation: Matrix3<T>,
    /// S and S δ̂, rotation and scatter eliminated.
    pub information: Matrix3<T>,
    pub gradient_mm: Vector3<T>,
    /// S before the scatter was eliminated.
    pub unscattered: Matrix3<T>,
    /// δ̂: its own centre less the model's, mm.
    pub own_centre_mm: Vector3<T>,
    /// Sum of its squared length residuals, mm².
    pub squares_mm2: T,
}

impl<T: Real> Fit<T> {
    /// A pose at the present estimate, rotation and scatter eliminated, and the same to go to work: its columns follow.
    /// `None` without a rotation.
    pub fn seen(&self, machine: &Machine<T>, pose: &Pose<T>) -> Option<(SeenPose<T>, PoseInWork<T>)> {
        let lengths = self.estimate.corrected(machine, pose.lengths());
        let rotation = pose.rotation();
        let jacobian = self.jacobian(&rotation, &lengths);
        let information = MarginalInformation::new(&jacobian).ok()?;
        let variance = self.variance_mm2() * machine.relative_variance(pose.samples);
        let mut scattered = information;
        scattered.add_scatter(self.joint.scatter_mm2() / variance);
        let at = PoseAt { rotation: &rotation, lengths: &lengths, jacobian: &jacobian };
        let in_work = PoseInWork::new(&at, &scattered, self.joint.features(&at), T::one());
        let seen = SeenPose {
            rotation,
            information: scattered.information(),
            gradient_mm: scattered.gradient_mm(),
            own_centre_mm: own_centre(&information.information(), &information.gradient_mm()),
            unscattered: information.information(),
            squares_mm2: information.squares_mm2(),
        };
        Some((seen, in_work))
    }

    /// All columns of a pose in work.
    pub fn add_all_columns(&self, machine: &Machine<T>, in_work: &mut PoseInWork<T>) {
        let features = in_work.features();
        while !in_work.add_columns(&Model { machine, estimate: &self.estimate, joint: &self.joint, features }) {}
    }
}
