//! The parameters beside O and C in one block: first the machine's, then the joint's.

use crate::identification::joint::{Features, Joint};
use crate::identification::machine::{Machine, MachineEstimate};
use crate::identification::parameters::{Column, Equations, ParameterBlock, PoseAt};
use crate::scalar::Real;

/// The machine and the joint as one block of parameters, seen from one pose.
#[derive(Debug)]
pub struct Model<'a, T: Real> {
    /// The machine as stated.
    pub machine: &'a Machine<T>,
    /// As it is estimated.
    pub estimate: &'a MachineEstimate<T>,
    /// The joint.
    pub joint: &'a Joint<T>,
    /// What the joint's motion depends on in this pose; `None` for a ball.
    pub features: Option<Features<T>>,
}

impl<T: Real> ParameterBlock<T> for Model<'_, T> {
    fn count(&self) -> usize {
        self.estimate.count() + self.joint.count()
    }

    fn column(&self, index: usize, pose: &PoseAt<'_, T>) -> Column<T> {
        match index.checked_sub(self.estimate.count()) {
            None => self.estimate.column(self.machine, index, pose),
            Some(index) => self.joint.column(index, self.features.as_ref()),
        }
    }

    fn add_prior(&self, equations: &mut Equations<T>, first: usize, variance_mm2: T) {
        self.estimate.add_prior(self.machine, equations, first, variance_mm2);
        self.joint.add_prior(equations, first + self.estimate.count(), variance_mm2);
    }
}
