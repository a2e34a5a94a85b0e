//! The unknowns of the estimator and their normal equations.
//!
//! Every pose sees O and C. Whatever else is unknown (the machine's constants, how the joint centre moves) is a
//! [`ParameterBlock`]: it says how the lengths of a pose change with each of its parameters, and what is known of them
//! beforehand. The unknowns stand in the order: block, O, C, so that elimination of the block
//! leaves the normal equations of O and C at the end of the factor.

use super::marginal_information::MarginalInformation;
use crate::kinematics::{CableLengths, LengthJacobian};
use crate::linear_algebra::{NormalEquations, inverse_of_positive_definite};
use crate::rig::CABLES;
use crate::scalar::Real;
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

/// What a parameter is seen through in a pose, its rotation eliminated.
#[derive(Clone, Copy)]
struct Seen<T> {
    column: Column<T>,
    /// Against δ, rotation and scatter eliminated; and before the scatter was.
    centre: Vector3<T>,
    unscattered: Vector3<T>,
    /// Gᵀ x, and (GᵀG)⁻¹ of it.
    rotational: Vector3<T>,
    eliminated: Vector3<T>,
    /// (S + 1 / scatter)⁻¹ `unscattered`.
    scattered: Vector3<T>,
}

/// The scatter of a pose's own joint centre eliminated as well: it has a variance of `scatter` times the noise's along
/// each axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scattered<T> {
    /// The pose's information with both eliminated.
    pub information: MarginalInformation<T>,
    /// S and S δ̂ before the scatter was eliminated.
    unscattered: Matrix3<T>,
    unscattered_gradient_mm: Vector3<T>,
    /// (S + 1 / scatter)⁻¹; zero without scatter.
    gain: Matrix3<T>,
}

impl<T: Real> Scattered<T> {
    /// Eliminates a scatter of this variance, in units of the noise's; 0 = none.
    pub fn new(pose: &MarginalInformation<T>, scatter: T) -> Self {
        let gain = if scatter > T::zero() {
            let precision = pose.information + Matrix3::from_diagonal_element(T::one() / scatter);
            inverse_of_positive_definite(&precision, T::zero())
        } else {
            None
        };
        let mut information = *pose;
        if let Some(gain) = gain {
            let kept = Matrix3::identity() - pose.information * gain;
            information.information = kept * pose.information;
            information.gradient_mm = kept * pose.gradient_mm;
            information.squares_mm2 -= pose.gradient_mm.dot(&(gain * pose.gradient_mm));
        }
        Self {
            information,
            unscattered: pose.information,
            unscattered_gradient_mm: pose.gradient_mm,
            gain: gain.unwrap_or_else(Matrix3::zeros),
        }
    }
}

/// Adds a pose's information on O, C and the block's parameters, `weight` times.
pub fn add_pose<T: Real>(
    equations: &mut Equations<T>,
    block: &impl ParameterBlock<T>,
    at: &PoseAt<'_, T>,
    pose: &Scattered<T>,
    weight: T,
) {
    let parameters = block.count();
    add_centre(equations, parameters, at.rotation, &pose.information, weight);
    if parameters > 0 {
        add_parameters(equations, block, at, pose, weight);
    }
}

/// Jᵀ S J and Jᵀ g for J = [I, -R], unknowns O and C.
fn add_centre<T: Real>(
    equations: &mut Equations<T>,
    first: usize,
    rotation: &Matrix3<T>,
    pose: &MarginalInformation<T>,
    weight: T,
) {
    let information = pose.information * weight;
    let turned = information * rotation;
    let in_platform = rotation.tr_mul(&turned);
    let gradient = pose.gradient_mm * weight;
    let gradient_in_platform = rotation.tr_mul(&gradient);
    for i in 0..3 {
        for (entry, j) in equations.row_mut(first + i, first).zip(0..=i) {
            *entry += information[(i, j)];
        }
        let row = [-turned[(0, i)], -turned[(1, i)], -turned[(2, i)]];
        let own = [in_platform[(i, 0)], in_platform[(i, 1)], in_platform[(i, 2)]];
        for (entry, value) in equations.row_mut(first + 3 + i, first).zip(row.into_iter().chain(own)) {
            *entry += value;
        }
        equations.add_to_gradient(first + i, gradient[i]);
        equations.add_to_gradient(first + 3 + i, -gradient_in_platform[i]);
    }
    equations.add_squares(pose.squares_mm2 * weight);
}

/// The rows and columns of the block's parameters.
fn add_parameters<T: Real>(
    equations: &mut Equations<T>,
    block: &impl ParameterBlock<T>,
    at: &PoseAt<'_, T>,
    pose: &Scattered<T>,
    weight: T,
) {
    let count = block.count();
    let mut all = heapless::Vec::<Seen<T>, MAX_PARAMETERS>::new();
    for x in 0..count {
        let (seen, gradient) = seen(&block.column(x, at), at, pose);
        equations.add_to_gradient(x, gradient * weight);
        for (entry, other) in equations.row_mut(x, 0).zip(all.iter().chain([&seen])) {
            *entry += shared(&seen, other) * weight;
        }
        let of_centre = seen.centre * weight;
        let of_platform = -at.rotation.tr_mul(&of_centre);
        for i in 0..3 {
            equations.add_to_entry(count + i, x, of_centre[i]);
            equations.add_to_entry(count + 3 + i, x, of_platform[i]);
        }
        // Never full: no block has more.
        let _ = all.push(seen);
    }
}

/// How S δ̂ of a pose changes with the unknowns: three rows, one column an unknown.
pub fn sensitivity<T: Real>(
    block: &impl ParameterBlock<T>,
    at: &PoseAt<'_, T>,
    pose: &Scattered<T>,
) -> [[T; MAX_UNKNOWNS]; 3] {
    let mut rows = [[T::zero(); MAX_UNKNOWNS]; 3];
    let mut set = |unknown: usize, column: &Vector3<T>| {
        for (row, value) in rows.iter_mut().zip(column) {
            if let Some(entry) = row.get_mut(unknown) {
                *entry = *value;
            }
        }
    };
    let count = block.count();
    for x in 0..count {
        set(x, &seen(&block.column(x, at), at, pose).0.centre);
    }
    let information = &pose.information.information;
    let turned = information * at.rotation;
    for i in 0..3 {
        set(count + i, &information.column(i).into_owned());
        set(count + 3 + i, &-turned.column(i));
    }
    rows
}

/// What a parameter is seen through, and its gradient.
fn seen<T: Real>(column: &Column<T>, at: &PoseAt<'_, T>, pose: &Scattered<T>) -> (Seen<T>, T) {
    let none = Vector3::zeros();
    let information = &pose.information;
    let rows = &at.jacobian.rows;
    let (direct, rotational, residual) = match column {
        Column::Centre(moved) => {
            let centre = information.information * moved;
            let gradient = moved.dot(&information.gradient_mm);
            let (unscattered, rotational, eliminated, scattered) = (none, none, none, none);
            return (Seen { column: *column, centre, unscattered, rotational, eliminated, scattered }, gradient);
        }
        Column::OneCable(cable, change) => rows.get(*cable).map_or((none, none, T::zero()), |row| {
            (row.translation * *change, row.rotation_mm * *change, row.residual_mm * *change)
        }),
        Column::AllCables(changes) => {
            rows.iter().zip(changes).fold((none, none, T::zero()), |(direct, rotational, residual), (row, change)| {
                let (u, g) = (row.translation * *change, row.rotation_mm * *change);
                (direct + u, rotational + g, residual + row.residual_mm * *change)
            })
        }
    };
    let eliminated = information.rotation_covariance * rotational;
    let unscattered = direct - information.rotation_gain.tr_mul(&rotational);
    let scattered = pose.gain * unscattered;
    let centre = unscattered - pose.unscattered * scattered;
    let gradient =
        residual - rotational.dot(&information.turn) - scattered.dot(&pose.unscattered_gradient_mm);
    (Seen { column: *column, centre, unscattered, rotational, eliminated, scattered }, gradient)
}

/// The entry of the normal matrix that two parameters share.
fn shared<T: Real>(x: &Seen<T>, y: &Seen<T>) -> T {
    let direct = match (&x.column, &y.column) {
        (Column::Centre(moved), _) => return moved.dot(&y.centre),
        (_, Column::Centre(moved)) => return moved.dot(&x.centre),
        (Column::OneCable(i, a), Column::OneCable(j, b)) => {
            if i == j { *a * *b } else { T::zero() }
        }
        (Column::OneCable(k, a), Column::AllCables(all)) | (Column::AllCables(all), Column::OneCable(k, a)) => {
            all.get(*k).map_or(T::zero(), |b| *a * *b)
        }
        (Column::AllCables(a), Column::AllCables(b)) => {
            a.iter().zip(b).fold(T::zero(), |sum, (a, b)| sum + *a * *b)
        }
    };
    direct - x.rotational.dot(&y.eliminated) - x.unscattered.dot(&y.scattered)
}
