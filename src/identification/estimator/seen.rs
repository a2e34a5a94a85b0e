//! What a pose says of the centre at the present estimate.

use super::fit::Fit;
use super::model::Model;
use super::scratch::Scratch;
use super::seen_pose::SeenPose;
use crate::identification::machine::Machine;
use crate::identification::marginal_information::{MarginalInformation, own_centre};
use crate::identification::parameters::Rows;
use crate::identification::pose::Pose;
use crate::identification::pose_in_work::{PoseInWork, with_all_columns};
use crate::scalar::Real;

impl<T: Real> Fit<T> {
    /// A pose at the present estimate, rotation and scatter eliminated. `None` without a rotation.
    pub fn seen(&self, machine: &Machine<T>, pose: &Pose<T>) -> Option<SeenPose<T>> {
        let lengths = self.estimate.corrected(machine, pose.lengths());
        let rotation = pose.rotation();
        let jacobian = self.jacobian(&rotation, &lengths);
        // Changed where it stays: a copy takes 200 cycles.
        let mut marginal = MarginalInformation::new(&jacobian);
        let Ok(marginal) = &mut marginal else { return None };
        let (unscattered, squares_mm2) = (marginal.information(), marginal.squares_mm2());
        let own_centre_mm = own_centre(&unscattered, &marginal.gradient_mm());
        let variance = self.variance_mm2() * machine.relative_variance(pose.samples);
        marginal.add_scatter(self.joint.scatter_mm2() / variance);
        let marginal = *marginal;
        Some(SeenPose { rotation, lengths, jacobian, marginal, unscattered, own_centre_mm, squares_mm2 })
    }

    /// The same, to stay where the equations at work are.
    #[cfg_attr(feature = "ccm", unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
    pub fn see(&mut self, machine: &Machine<T>, pose: &Pose<T>) -> Option<&SeenPose<T>> {
        self.scratch = Scratch::Seen(self.seen(machine, pose)?);
        match &self.scratch {
            Scratch::Seen(seen) => Some(seen),
            _ => None,
        }
    }

    /// The equations of the pose that was seen last go to work: their columns follow.
    pub fn put_to_work(&mut self) {
        let Scratch::Seen(seen) = self.scratch else { return };
        let at = seen.at();
        self.scratch.put_pose(&at, &seen.marginal, T::one());
    }

    /// Derivative of S δ̂ with the unknowns: three rows, one column for each unknown.
    pub fn sensitivity(&self, machine: &Machine<T>, seen: &SeenPose<T>) -> Rows<T> {
        self.with_all_columns(machine, seen).sensitivity()
    }

    /// The pose's equations with all their columns.
    pub fn with_all_columns(&self, machine: &Machine<T>, seen: &SeenPose<T>) -> PoseInWork<T> {
        let at = seen.at();
        let model = Model { machine, estimate: &self.estimate, joint: &self.joint };
        with_all_columns(&model, &at, &seen.marginal)
    }
}
