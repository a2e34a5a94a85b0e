//! What one pose says about the joint centre, with the pose's own rotation eliminated.
//!
//! Of the six unknowns (O in {B}, C in {P}) a pose sees three combinations, δ = δO - R δC (see
//! [`pivot`](crate::kinematics::pivot)). Least squares over its six lengths, the small rotation ω eliminated, leaves a
//! 3x3 information matrix S and a vector S δ̂: everything that the pose knows, with the exact maximum-likelihood
//! weight.

use crate::kinematics::pivot::{LengthEquations, inverse_of_symmetric};
use crate::rig::CABLES;
use crate::scalar::Real;
use nalgebra::{Matrix3, Vector3};

/// One pose's least-squares information in units of 1/mm² of length variance (multiply by 1/σ²).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseInformation<T> {
    /// S: information on δ, symmetric, dimensionless.
    pub information: Matrix3<T>,
    /// S δ̂, mm.
    pub gradient_mm: Vector3<T>,
    /// Sum of the squared length residuals with the best ω and δ = 0, mm².
    pub squares_mm2: T,
    /// The best ω for δ = 0, rad.
    pub turn: Vector3<T>,
    /// Inverse of the information on ω, rad²/mm².
    pub turning_inverse: Matrix3<T>,
    /// The information shared by δ and ω, times that inverse, 1/mm: what ω takes away from δ.
    pub through: Matrix3<T>,
}

impl<T: Real> PoseInformation<T> {
    /// The information in six length equations. `None` when they do not determine the rotation (no such pose of a
    /// sound rig).
    pub fn of(equations: &LengthEquations<T>) -> Option<Self> {
        let mut direct = Matrix3::zeros();
        let mut mixed = Matrix3::zeros();
        let mut turning = Matrix3::zeros();
        let mut gradient = Vector3::zeros();
        let mut torque = Vector3::zeros();
        let mut squares = T::zero();
        for cable in 0..CABLES {
            let (u, g, e) = (equations.direction[cable], equations.moment_mm[cable], equations.residual_mm[cable]);
            direct += u * u.transpose();
            mixed += u * g.transpose();
            turning += g * g.transpose();
            gradient += u * e;
            torque += g * e;
            squares += e * e;
        }
        let inverse = inverse_of_symmetric(&turning)?;
        let through = mixed * inverse;
        let turn = inverse * torque;
        Some(Self {
            information: direct - through * mixed.transpose(),
            gradient_mm: gradient - mixed * turn,
            squares_mm2: squares - torque.dot(&turn),
            turn,
            turning_inverse: inverse,
            through,
        })
    }
}
