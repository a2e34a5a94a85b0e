//! What one pose says about the joint centre, with the pose's own rotation eliminated.
//!
//! Of the six unknowns (O in {B}, C in {P}) a pose sees three combinations, δ = δO - R δC (see
//! [`pivot`](crate::kinematics::pivot)). Least squares over its six lengths, the small rotation ω eliminated, leaves a
//! 3x3 information matrix S and a vector S δ̂: everything that the pose knows, with the exact maximum-likelihood
//! weight.

use super::blocks::eliminate;
use super::normal_equations::Singular;
use crate::calls;
use crate::kinematics::LengthEquations;
use crate::kinematics::pivot::LengthEquation;
use crate::scalar::Real;
use crate::symmetric::{Symmetric, rounding};
use crate::vector::{add_to, difference, dot, image_transposed, scaled};
use nalgebra::{Matrix3, Vector3};

/// One pose's least-squares information in units of 1/mm² of length variance (multiply by 1/σ²).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseInformation<T> {
    /// S: information on δ, ω eliminated, dimensionless.
    pub information: Symmetric<T>,
    /// How ω follows δ, rad/mm: the inverse of its information times what they share.
    pub through: Matrix3<T>,
    /// Inverse of the information on ω, rad²/mm².
    pub turning_inverse: Symmetric<T>,
    /// S δ̂, mm.
    pub gradient_mm: Vector3<T>,
    /// Sum of the squared length residuals with the best ω and δ = 0, mm².
    pub squares_mm2: T,
    /// The best ω for δ = 0, rad.
    pub turn: Vector3<T>,
}

impl<T: Real> PoseInformation<T> {
    /// The information in six length equations. `None` when they do not determine the rotation (no such pose of a
    /// sound rig).
    #[inline(always)]
    pub fn of(equations: &LengthEquations<T>) -> Option<Self> {
        let mut pose = Self::empty();
        pose.set(equations).is_ok().then_some(pose)
    }

    /// Nothing yet, for [`set`](Self::set).
    #[inline(always)]
    pub(crate) fn empty() -> Self {
        let zero = T::zero();
        let none = Vector3::new(zero, zero, zero);
        Self {
            information: Symmetric::zero(),
            through: Matrix3::new(zero, zero, zero, zero, zero, zero, zero, zero, zero),
            turning_inverse: Symmetric::zero(),
            gradient_mm: none,
            squares_mm2: T::zero(),
            turn: none,
        }
    }

    /// [`of`](Self::of) in place: as a result it would be copied.
    #[inline(never)]
    pub(crate) fn set(&mut self, equations: &LengthEquations<T>) -> Result<(), Singular> {
        let zero = T::zero();
        // 28 sums in two loops: neither has more of them than the processor has registers.
        let (mut direct, mut gradient, mut squares) = (Symmetric::zero(), Vector3::new(zero, zero, zero), zero);
        for LengthEquation { direction: u, residual_mm: e, .. } in &equations.cables {
            direct.add_square(u);
            add_to(&mut gradient, &scaled(u, *e));
            squares += *e * *e;
        }
        let (mut turning, mut torque) = (Symmetric::zero(), Vector3::new(zero, zero, zero));
        let [mut mx, mut my, mut mz] = [torque; 3];
        for LengthEquation { direction: u, moment_mm: g, residual_mm: e } in &equations.cables {
            turning.add_square(g);
            add_to(&mut torque, &scaled(g, *e));
            add_to(&mut mx, &scaled(g, u.x));
            add_to(&mut my, &scaled(g, u.y));
            add_to(&mut mz, &scaled(g, u.z));
        }
        self.information = direct;
        self.through = Matrix3::new(mx.x, my.x, mz.x, mx.y, my.y, mz.y, mx.z, my.z, mz.z);
        self.turning_inverse = turning;
        eliminate(&mut self.information, &mut self.through, &mut self.turning_inverse, rounding())?;
        self.turn = self.turning_inverse.image(&torque);
        self.gradient_mm = difference(&gradient, &image_transposed(&self.through, &torque));
        self.squares_mm2 = squares - dot(&torque, &self.turn);
        Ok(())
    }

    /// Becomes the centre that the pose would have by itself, exactly known: its squared distance is the squares then.
    /// `ridge` is added to the information, which may not know a direction.
    pub fn own_centre(&mut self, ridge: T) {
        let one = Symmetric::diagonal(T::one());
        self.information.add(&one, ridge);
        // Never singular: information is not negative, and the ridge is positive.
        if self.information.invert(&one, T::zero()) {
            self.gradient_mm = self.information.image(&self.gradient_mm);
        }
        self.squares_mm2 = calls::dot(&self.gradient_mm, &self.gradient_mm);
        self.information = one;
    }
}
