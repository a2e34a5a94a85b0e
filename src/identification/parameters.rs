//! The unknowns of the estimator and their normal equations.
//!
//! Every pose sees O and C. Whatever else is unknown is a [`ParameterBlock`]: the machine's constants, of which it gives
//! the Jacobian column of each in a pose; the gains with which the joint centre moves, of which it gives the features that
//! they multiply; and the prior of both. The unknowns stand in the order constants, gains, O, C, so that elimination of the
//! block leaves the normal equations of O and C at the end of the factor.

use super::marginal_information::MarginalInformation;
use crate::kinematics::{CableLengths, LengthJacobian};
use crate::linear_algebra::NormalEquations;
use crate::rig::CABLES;
use crate::scalar::Real;
use heapless::Vec;
use nalgebra::{Matrix3, Vector3};

/// Maximum number of parameters beside O and C: 18 of a 3-3 machine and 24 of a moving joint; or 36 of a machine with ends of
/// its own for every cable.
const MAX_PARAMETERS: usize = 42;
/// Maximum number of constants of a machine.
pub const MAX_CONSTANTS: usize = 36;
/// Maximum number of features of a rotation with which a joint centre moves.
pub const MAX_FEATURES: usize = 8;
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

/// How the lengths of a pose change with one constant, per unit of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Column<T> {
    /// The length of one cable (from 0) changes by this much.
    OneCable(usize, T),
    /// The lengths of all cables do.
    AllCables([T; CABLES]),
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
    /// How many constants of the machine take part.
    fn constants(&self) -> usize;

    /// The column of the Jacobian of constant `index`, from 0, in a pose.
    fn column(&self, index: usize, pose: &PoseAt<'_, T>) -> Column<T>;

    /// φ of a rotation ({P} to {B}), when the joint centre moves by A φ in {B}: the columns of A, three gains for each feature,
    /// are unknowns behind the constants. None of a centre that stays.
    fn features(&self, rotation: &Matrix3<T>) -> CentreFeatures<T>;

    /// Adds the prior of the parameters, times the noise's variance `variance_mm2`, mm². Their unknowns begin at
    /// `first`.
    fn add_prior(&self, equations: &mut Equations<T>, first: usize, variance_mm2: T);
}

/// Columns of a pose's three equations, one a constant.
pub type Columns<T> = Vec<Vector3<T>, MAX_CONSTANTS>;
/// Features of a pose's rotation.
pub type CentreFeatures<T> = Vec<T, MAX_FEATURES>;

/// What the three equations of a pose make of a change of its lengths.
pub fn change_of_equations<T: Real>(column: &Column<T>, projector: &[Vector3<T>; CABLES]) -> Vector3<T> {
    match column {
        Column::OneCable(cable, change) => projector.get(*cable).map_or_else(Vector3::zeros, |k| k * *change),
        Column::AllCables(changes) => {
            projector.iter().zip(changes).fold(Vector3::zeros(), |sum, (k, change)| sum + k * *change)
        }
    }
}

/// The normal equations of O and C alone, of the poses of a pass: Jᵀ S J and Jᵀ S δ̂ for J = [I, -R]. Added to the others at
/// the end of the pass: every pose has them, and three matrices are summed faster than a packed triangle.
#[derive(Clone, Copy, Debug)]
pub struct CentreSums<T> {
    /// Σ S, Σ S R and Σ Rᵀ S R.
    base: Matrix3<T>,
    mixed: Matrix3<T>,
    platform: Matrix3<T>,
    /// Σ S δ̂ and Σ Rᵀ S δ̂.
    base_gradient: Vector3<T>,
    platform_gradient: Vector3<T>,
}

impl<T: Real> Default for CentreSums<T> {
    fn default() -> Self {
        let (matrix, vector) = (Matrix3::zeros(), Vector3::zeros());
        Self { base: matrix, mixed: matrix, platform: matrix, base_gradient: vector, platform_gradient: vector }
    }
}

impl<T: Real> CentreSums<T> {
    /// Adds a pose, `weight` times.
    #[cfg_attr(feature = "ccm", unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
    pub fn add(&mut self, rotation: &Matrix3<T>, pose: &MarginalInformation<T>, weight: T) {
        let information = pose.information() * weight;
        let turned = information * rotation;
        let gradient = pose.gradient_mm() * weight;
        self.base += information;
        self.mixed += turned;
        self.platform += rotation.tr_mul(&turned);
        self.base_gradient += gradient;
        self.platform_gradient += rotation.tr_mul(&gradient);
    }

    /// Adds the sums to the equations, of which they are the last unknowns, and begins anew.
    #[cfg_attr(feature = "ccm", unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
    pub fn move_to(&mut self, equations: &mut Equations<T>) {
        let Self { base, mixed, platform, base_gradient, platform_gradient } = core::mem::take(self);
        let first = equations.unknowns() - CENTRE_UNKNOWNS;
        for i in 0..3 {
            for j in 0..3 {
                equations.add_to_entry(first + 3 + i, first + j, -mixed[(j, i)]);
                if j <= i {
                    equations.add_to_entry(first + i, first + j, base[(i, j)]);
                    equations.add_to_entry(first + 3 + i, first + 3 + j, platform[(i, j)]);
                }
            }
            equations.add_to_gradient(first + i, base_gradient[i]);
            equations.add_to_gradient(first + 3 + i, -platform_gradient[i]);
        }
    }
}
