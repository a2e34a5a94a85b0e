//! The parameters beside O and C in one block: first the machine's, then the joint's.

use crate::identification::joint::Joint;
use crate::identification::machine::{MAX_MACHINE, Machine, MachineEstimate};
use crate::identification::parameters::{CentreFeatures, Column, Equations, MAX_CONSTANTS, ParameterBlock, PoseAt};
use crate::scalar::Real;
use nalgebra::Matrix3;

/// The machine and the joint as one block of parameters.
#[derive(Debug)]
pub struct Model<'a, T: Real> {
    /// The machine as stated.
    pub machine: &'a Machine<T>,
    /// As it is estimated.
    pub estimate: &'a MachineEstimate<T>,
    /// The joint.
    pub joint: &'a Joint<T>,
}

impl<T: Real> ParameterBlock<T> for Model<'_, T> {
    fn constants(&self) -> usize {
        const { assert!(MAX_MACHINE <= MAX_CONSTANTS) };
        self.estimate.count()
    }

    fn column(&self, index: usize, pose: &PoseAt<'_, T>) -> Column<T> {
        self.estimate.column(self.machine, index, pose)
    }

    fn features(&self, rotation: &Matrix3<T>) -> CentreFeatures<T> {
        self.joint.features(rotation)
    }

    fn add_prior(&self, equations: &mut Equations<T>, first: usize, variance_mm2: T) {
        self.estimate.add_prior(self.machine, equations, first, variance_mm2);
        self.joint.add_prior(equations, first + self.estimate.count(), variance_mm2);
    }
}
