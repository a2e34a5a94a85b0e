//! What one pose says about the joint centre, with the pose's own rotation eliminated.
//!
//! Of the six unknowns (O in {B}, C in {P}) a pose sees three combinations, δ = δO - R δC (see
//! [`pivot`](crate::kinematics::pivot)). Least squares over its six lengths, the small rotation ω eliminated, leaves a
//! 3x3 information matrix S and a vector S δ̂: everything that the pose knows, with the exact maximum-likelihood
//! weight.

use crate::kinematics::pivot::{LengthEquation, LengthEquations, inverse_of_symmetric};
use crate::scalar::Real;
use crate::vector::{add_to, difference, dot, image, product, scaled};
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
    #[inline(never)]
    pub fn of(equations: &LengthEquations<T>) -> Option<Self> {
        let zero = T::zero();
        // Σ u uᵀ and Σ g gᵀ (lower triangles), Σ u gᵀ (row by row): with the rest 28 sums, which stay in registers.
        let [mut dxx, mut dyx, mut dyy, mut dzx, mut dzy, mut dzz] = [zero; 6];
        let [mut txx, mut tyx, mut tyy, mut tzx, mut tzy, mut tzz] = [zero; 6];
        let [mut mxx, mut mxy, mut mxz, mut myx, mut myy, mut myz, mut mzx, mut mzy, mut mzz] = [zero; 9];
        let [mut gradient, mut torque] = [Vector3::new(zero, zero, zero); 2];
        let mut squares = zero;
        for LengthEquation { direction: u, moment_mm: g, residual_mm: e } in &equations.cables {
            dxx += u.x * u.x;
            dyx += u.y * u.x;
            dyy += u.y * u.y;
            dzx += u.z * u.x;
            dzy += u.z * u.y;
            dzz += u.z * u.z;
            txx += g.x * g.x;
            tyx += g.y * g.x;
            tyy += g.y * g.y;
            tzx += g.z * g.x;
            tzy += g.z * g.y;
            tzz += g.z * g.z;
            mxx += u.x * g.x;
            mxy += u.x * g.y;
            mxz += u.x * g.z;
            myx += u.y * g.x;
            myy += u.y * g.y;
            myz += u.y * g.z;
            mzx += u.z * g.x;
            mzy += u.z * g.y;
            mzz += u.z * g.z;
            add_to(&mut gradient, &scaled(u, *e));
            add_to(&mut torque, &scaled(g, *e));
            squares += *e * *e;
        }
        let inverse = inverse_of_symmetric(&Matrix3::new(txx, tyx, tzx, tyx, tyy, tzy, tzx, tzy, tzz))?;
        let mixed = Matrix3::new(mxx, mxy, mxz, myx, myy, myz, mzx, mzy, mzz);
        let through = product(&mixed, &inverse);
        let turn = image(&inverse, &torque);
        // Symmetric: six entries of `direct` - `through` `mixed`ᵀ are all.
        let (xx, yx, yy) = (
            dxx - (through.m11 * mxx + through.m12 * mxy + through.m13 * mxz),
            dyx - (through.m21 * mxx + through.m22 * mxy + through.m23 * mxz),
            dyy - (through.m21 * myx + through.m22 * myy + through.m23 * myz),
        );
        let (zx, zy, zz) = (
            dzx - (through.m31 * mxx + through.m32 * mxy + through.m33 * mxz),
            dzy - (through.m31 * myx + through.m32 * myy + through.m33 * myz),
            dzz - (through.m31 * mzx + through.m32 * mzy + through.m33 * mzz),
        );
        Some(Self {
            information: Matrix3::new(xx, yx, zx, yx, yy, zy, zx, zy, zz),
            gradient_mm: difference(&gradient, &image(&mixed, &turn)),
            squares_mm2: squares - dot(&torque, &turn),
            turn,
            turning_inverse: inverse,
            through,
        })
    }
}
