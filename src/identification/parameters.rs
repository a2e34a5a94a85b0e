//! The unknowns of the estimator and their normal equations.
//!
//! Every pose sees O and C. Whatever else is unknown (the machine's constants, how the joint centre moves) is a
//! [`ParameterBlock`]: it says how the lengths of a pose change with each of its parameters, and what is known of them
//! beforehand. The unknowns stand in the order: block, O, C, so that elimination of the block
//! leaves the normal equations of O and C at the end of the factor.

use super::marginal_information::MarginalInformation;
use crate::kinematics::{CableLengths, LengthJacobian};
use crate::linear_algebra::NormalEquations;
use crate::rig::CABLES;
use crate::scalar::Real;
use heapless::Vec;
use nalgebra::{Matrix3, Vector3};

/// Most parameters beside O and C.
pub const MAX_PARAMETERS: usize = 54;
/// Most unknowns.
pub const MAX_UNKNOWNS: usize = MAX_PARAMETERS + CENTRE_UNKNOWNS;
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
    /// The joint centre of the pose moves so, in {B}.
    Centre(Vector3<T>),
}

/// A pose at the present estimate.
#[derive(Clone, Copy, Debug)]
pub struct PoseAt<'a, T> {
    /// Rotation from {P} to {B}.
    pub rotation: &'a Matrix3<T>,
    /// The lengths less what is known to be wrong with them.
    pub lengths: &'a CableLengths<T>,
    /// The Jacobian of the lengths.
    pub jacobian: &'a LengthJacobian<T>,
}

/// Parameters that are estimated with the joint centre.
pub trait ParameterBlock<T: Real> {
    /// How many take part.
    fn count(&self) -> usize;

    /// The column of the Jacobian of parameter `index`, from 0, in a pose.
    fn column(&self, index: usize, pose: &PoseAt<'_, T>) -> Column<T>;

    /// Adds what is known of the parameters beforehand, for a noise of this variance; the first of them is unknown
    /// `first`.
    fn add_prior(&self, equations: &mut Equations<T>, first: usize, variance_mm2: T);
}

/// Columns of a pose's three equations, one an unknown.
pub type Columns<T> = Vec<Vector3<T>, MAX_UNKNOWNS>;

/// Fills in the columns of the block's parameters: what the three equations make of a change of the lengths.
fn columns_of_block<T: Real>(
    block: &impl ParameterBlock<T>,
    at: &PoseAt<'_, T>,
    pose: &MarginalInformation<T>,
    columns: &mut Columns<T>,
) {
    let count = block.count();
    if count == 0 {
        return;
    }
    let projector = pose.projector();
    for x in 0..count {
        let column = match block.column(x, at) {
            Column::OneCable(cable, change) => projector.get(cable).map_or_else(Vector3::zeros, |k| k * change),
            Column::AllCables(changes) => {
                projector.iter().zip(changes).fold(Vector3::zeros(), |sum, (k, change)| sum + k * change)
            }
            Column::Centre(moved) => pose.translation * moved,
        };
        // Never full: no block has more parameters.
        let _ = columns.push(column);
    }
}

/// The columns of O and C: Ū J with J = [I, -R].
fn columns_of_centre<T: Real>(at: &PoseAt<'_, T>, pose: &MarginalInformation<T>) -> [Matrix3<T>; 2] {
    [pose.translation, -(pose.translation * at.rotation)]
}

/// Adds a pose's information on O, C and the block's parameters, `weight` times.
pub fn add_pose<T: Real>(
    equations: &mut Equations<T>,
    block: &impl ParameterBlock<T>,
    at: &PoseAt<'_, T>,
    pose: &MarginalInformation<T>,
    weight: T,
) {
    let mut parameters = Columns::new();
    columns_of_block(block, at, pose, &mut parameters);
    let [of_base, of_platform] = columns_of_centre(at, pose);
    equations.add_equations(&parameters, [&of_base, &of_platform], &pose.residuals_mm, weight);
}

/// How S δ̂ of a pose changes with the unknowns: three rows, one column an unknown.
pub fn sensitivity<T: Real>(
    block: &impl ParameterBlock<T>,
    at: &PoseAt<'_, T>,
    pose: &MarginalInformation<T>,
) -> [[T; MAX_UNKNOWNS]; 3] {
    let mut rows = [[T::zero(); MAX_UNKNOWNS]; 3];
    let mut columns = Columns::new();
    columns_of_block(block, at, pose, &mut columns);
    for matrix in columns_of_centre(at, pose) {
        for column in matrix.column_iter() {
            let _ = columns.push(column.into_owned());
        }
    }
    for (unknown, column) in columns.iter().enumerate() {
        let change = pose.translation.tr_mul(column);
        for (row, value) in rows.iter_mut().zip(&change) {
            row[unknown] = *value;
        }
    }
    rows
}
