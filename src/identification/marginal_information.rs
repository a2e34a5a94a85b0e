//! What one pose says about the joint centre, with the pose's own rotation eliminated (Schur complement).
//!
//! Of the six unknowns (O in {B}, C in {P}) a pose sees three combinations, δ = δO - R δC (see
//! [`length_jacobian`](crate::kinematics::length_jacobian)). With U and G the translation and rotation rows of the
//! Jacobian, the least squares over its six lengths have the blocks UᵀU, GᵀU, GᵀG; eliminating the small rotation ω
//! leaves
//!
//! ```text
//! S = UᵀU - (GᵀU)ᵀ (GᵀG)⁻¹ GᵀU
//! ```
//!
//! and S δ̂ for the best δ: everything that the pose knows, with the exact maximum-likelihood weight.

use crate::kinematics::LengthJacobian;
use crate::linear_algebra::{Singular, inverse_of_positive_definite, rounding};
use crate::scalar::Real;
use nalgebra::{Matrix3, Vector3};

/// One pose's least-squares information, for lengths with a variance of 1 mm² (multiply by 1/σ²).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MarginalInformation<T> {
    /// S: information on δ, ω eliminated, dimensionless.
    pub information: Matrix3<T>,
    /// (GᵀG)⁻¹ GᵀU: the best ω follows δ by minus this, rad/mm.
    pub rotation_gain: Matrix3<T>,
    /// (GᵀG)⁻¹: covariance of ω for a known δ, rad²/mm².
    pub rotation_covariance: Matrix3<T>,
    /// S δ̂, mm.
    pub gradient_mm: Vector3<T>,
    /// Sum of the squared length residuals with the best ω and δ = 0, mm².
    pub squares_mm2: T,
    /// The best ω for δ = 0, rad.
    pub turn: Vector3<T>,
}

impl<T: Real> MarginalInformation<T> {
    /// The information in six lengths.
    ///
    /// # Errors
    /// [`Singular`] when they do not determine the rotation (no such pose of a sound rig).
    pub fn new(jacobian: &LengthJacobian<T>) -> Result<Self, Singular> {
        let mut direct = Matrix3::zeros();
        let mut mixed = Matrix3::zeros();
        let mut rotation = Matrix3::zeros();
        let (mut gradient, mut rotational_gradient) = (Vector3::zeros(), Vector3::zeros());
        let mut squares = T::zero();
        for row in &jacobian.rows {
            let (u, g, e) = (&row.translation, &row.rotation_mm, row.residual_mm);
            add_outer_product(&mut direct, u, u);
            add_outer_product(&mut mixed, g, u);
            add_outer_product(&mut rotation, g, g);
            gradient += u * e;
            rotational_gradient += g * e;
            squares += e * e;
        }
        let rotation_covariance = inverse_of_positive_definite(&rotation, rounding()).ok_or(Singular)?;
        let rotation_gain = rotation_covariance * mixed;
        let turn = rotation_covariance * rotational_gradient;
        Ok(Self {
            information: direct - mixed.tr_mul(&rotation_gain),
            rotation_gain,
            rotation_covariance,
            gradient_mm: gradient - rotation_gain.tr_mul(&rotational_gradient),
            squares_mm2: squares - rotational_gradient.dot(&turn),
            turn,
        })
    }

    /// δ̂ for itself: the centre that the pose would have alone, exactly known, at a distance of √squares from the common
    /// one. `ridge` is added to the information, which may not know a direction.
    pub fn into_own_centre(self, ridge: T) -> Self {
        let information = self.information + Matrix3::from_diagonal_element(ridge);
        let gradient_mm =
            inverse_of_positive_definite(&information, T::zero()).map_or(self.gradient_mm, |v| v * self.gradient_mm);
        Self {
            information: Matrix3::identity(),
            gradient_mm,
            squares_mm2: gradient_mm.norm_squared(),
            ..self
        }
    }
}

fn add_outer_product<T: Real>(sum: &mut Matrix3<T>, a: &Vector3<T>, b: &Vector3<T>) {
    *sum += a * b.transpose();
}
