//! The unknowns of the estimator and their normal equations.
//!
//! Every pose sees O and C. Whatever else is unknown (the machine's constants, how the joint centre moves) is a
//! [`ParameterBlock`]: it gives the Jacobian column of each of its parameters in a pose, and their prior. The unknowns
//! stand in the order block, O, C, so that elimination of the block leaves the normal equations of O and C at the end of
//! the factor.

use super::marginal_information::MarginalInformation;
use crate::kinematics::{CableLengths, LengthJacobian};
use crate::linear_algebra::NormalEquations;
use crate::rig::CABLES;
use crate::scalar::Real;
use heapless::Vec;
use nalgebra::{Matrix3, Vector3};

/// Maximum number of parameters beside O and C: 36 of the machine, 18 of the joint.
const MAX_PARAMETERS: usize = 54;
/// Maximum number of unknowns.
pub const MAX_UNKNOWNS: usize = MAX_PARAMETERS + CENTRE_UNKNOWNS;

/// Three linear functions of the unknowns, one column for each unknown.
pub type Rows<T> = [[T; MAX_UNKNOWNS]; 3];
/// O and C.
pub const CENTRE_UNKNOWNS: usize = 6;
/// Entries of the packed normal matrix.
pub const PACKED: usize = MAX_UNKNOWNS * (MAX_UNKNOWNS + 1) / 2;

/// The normal equations of the estimator.
pub type Equations<T> = NormalEquations<T, MAX_UNKNOWNS, PACKED>;

/// How a pose depends on one parameter, per unit of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Column<T> {
    /// The length of one cable (from 0) changes by this much.
    OneCable(usize, T),
    /// The lengths of all cables do.
    AllCables([T; CABLES]),
    /// The joint centre of the pose moves by this in {B}, mm.
    Centre(Vector3<T>),
}

/// A pose at the present estimate.
#[derive(Clone, Copy, Debug)]
pub struct PoseAt<'a, T> {
    /// Rotation from {P} to {B}.
    pub rotation: &'a Matrix3<T>,
    /// The lengths, corrected by the estimated offsets and drum scales.
    pub lengths: &'a CableLengths<T>,
    /// The Jacobian of the lengths.
    pub jacobian: &'a LengthJacobian<T>,
}

/// Parameters that are estimated together with the joint centre.
pub trait ParameterBlock<T: Real> {
    /// How many take part.
    fn count(&self) -> usize;

    /// The column of the Jacobian of parameter `index`, from 0, in a pose.
    fn column(&self, index: usize, pose: &PoseAt<'_, T>) -> Column<T>;

    /// Adds the prior of the parameters, times the noise's variance `variance_mm2`, mm². Their unknowns begin at
    /// `first`.
    fn add_prior(&self, equations: &mut Equations<T>, first: usize, variance_mm2: T);
}

/// The columns of a pose's three equations, one an unknown, in the order block, O, C: Ū J with J = [I, -R] for O and C,
/// and what the equations make of the lengths for the block.
pub fn columns<T: Real>(
    block: &impl ParameterBlock<T>,
    at: &PoseAt<'_, T>,
    pose: &MarginalInformation<T>,
) -> Vec<Vector3<T>, MAX_UNKNOWNS> {
    let mut columns = Vec::new();
    let mut add = |column: Vector3<T>| {
        // Never full: no block has more parameters.
        let _ = columns.push(column);
    };
    let count = block.count();
    if count > 0 {
        let projector = pose.projector();
        for x in 0..count {
            add(match block.column(x, at) {
                Column::OneCable(cable, change) => projector.get(cable).map_or_else(Vector3::zeros, |k| k * change),
                Column::AllCables(changes) => {
                    projector.iter().zip(changes).fold(Vector3::zeros(), |sum, (k, change)| sum + k * change)
                }
                Column::Centre(moved) => pose.translation * moved,
            });
        }
    }
    let of_platform = -(pose.translation * at.rotation);
    for matrix in [&pose.translation, &of_platform] {
        (0..3).for_each(|j| add(matrix.column(j).into_owned()));
    }
    columns
}

/// Adds a pose's information on O, C and the block's parameters, `weight` times.
#[cfg_attr(feature = "ccm", inline(never), unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
pub fn add_pose<T: Real>(
    equations: &mut Equations<T>,
    block: &impl ParameterBlock<T>,
    at: &PoseAt<'_, T>,
    pose: &MarginalInformation<T>,
    weight: T,
) {
    equations.add_equations(&columns(block, at, pose), &pose.residuals_mm, weight);
}

/// Derivative of S δ̂ of a pose with the unknowns: three rows, one column for each unknown.
pub fn sensitivity<T: Real>(
    block: &impl ParameterBlock<T>,
    at: &PoseAt<'_, T>,
    pose: &MarginalInformation<T>,
) -> [[T; MAX_UNKNOWNS]; 3] {
    let mut rows = [[T::zero(); MAX_UNKNOWNS]; 3];
    for (unknown, column) in columns(block, at, pose).iter().enumerate() {
        let change = pose.translation.tr_mul(column);
        for (row, value) in rows.iter_mut().zip(&change) {
            row[unknown] = *value;
        }
    }
    rows
}
