//! One pass of the paper's iteration: DᵀD, DᵀY and YᵀY (Eq. 15, 17) summed over the poses without D.
//!
//! With D = K W of a pose (see [`model`](super::model)) its share is Wᵀ M W and Wᵀ s for M = KᵀK and s = KᵀY, three by
//! three and three. In W = [OP_i, p_i] the radii are the same for all poses of a pass, so they are multiplied in once,
//! at its end: 144 operations a pose instead of 189 with the rows of D, and fewer sums to load and store.

use super::SixUnknowns;
use super::model::{EdgeJacobian, EvaluatedPose};
use crate::kinematics::BaseEdges;
use crate::linear_algebra::packed_index;
use crate::rig::POINTS;
use crate::scalar::Real;
use nalgebra::{Matrix3, Vector3};

/// The sums of a pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PassSum<T> {
    /// Σ OP_iᵀ M_ij OP_j over i and j: the block of the centre, lower triangle.
    centre: [T; 6],
    /// Σ V_i with V_i = M_ij OP_j: the mixed block, without p_i.
    mixed: [Vector3<T>; POINTS],
    /// Σ M: the block of the radii, without p_i p_j, lower triangle.
    turns: [T; 6],
    /// Σ s_i OP_i.
    centre_gradient: Vector3<T>,
    /// Σ s_i: the radii's gradient, without p_i.
    turn_gradient: [T; POINTS],
    squares: T,
}

impl<T: Real> PassSum<T> {
    /// No poses yet.
    pub fn new() -> Self {
        let zero = T::zero();
        Self {
            centre: [zero; 6],
            mixed: [Vector3::zeros(); POINTS],
            turns: [zero; 6],
            centre_gradient: Vector3::zeros(),
            turn_gradient: [zero; POINTS],
            squares: zero,
        }
    }

    /// Adds a pose.
    pub fn add(&mut self, pose: &EvaluatedPose<T>, jacobian: &EdgeJacobian<T>) {
        let [p1, p2, p3] = &pose.points_mm;
        let [[k11, k12], [k22, k23], [k33, k31]] = *jacobian;
        let [y1, y2, y3] = pose.residuals_mm;
        // M = KᵀK; each two end-points share one edge, each end-point has two.
        let (m11, m22, m33) = (k11 * k11 + k31 * k31, k12 * k12 + k22 * k22, k23 * k23 + k33 * k33);
        let (m21, m32, m31) = (k11 * k12, k22 * k23, k33 * k31);
        let (s1, s2, s3) = (k11 * y1 + k31 * y3, k12 * y1 + k22 * y2, k23 * y2 + k33 * y3);
        let v1 = p1 * m11 + p2 * m21 + p3 * m31;
        let v2 = p1 * m21 + p2 * m22 + p3 * m32;
        let v3 = p1 * m31 + p2 * m32 + p3 * m33;
        let [c11, c21, c22, c31, c32, c33] = &mut self.centre;
        *c11 += p1.x * v1.x + p2.x * v2.x + p3.x * v3.x;
        *c21 += p1.y * v1.x + p2.y * v2.x + p3.y * v3.x;
        *c22 += p1.y * v1.y + p2.y * v2.y + p3.y * v3.y;
        *c31 += p1.z * v1.x + p2.z * v2.x + p3.z * v3.x;
        *c32 += p1.z * v1.y + p2.z * v2.y + p3.z * v3.y;
        *c33 += p1.z * v1.z + p2.z * v2.z + p3.z * v3.z;
        let [mixed1, mixed2, mixed3] = &mut self.mixed;
        *mixed1 += v1;
        *mixed2 += v2;
        *mixed3 += v3;
        let [t11, t21, t22, t31, t32, t33] = &mut self.turns;
        *t11 += m11;
        *t21 += m21;
        *t22 += m22;
        *t31 += m31;
        *t32 += m32;
        *t33 += m33;
        self.centre_gradient += p1 * s1 + p2 * s2 + p3 * s3;
        let [g1, g2, g3] = &mut self.turn_gradient;
        *g1 += s1;
        *g2 += s2;
        *g3 += s3;
        self.squares += pose.squares_mm2();
    }

    /// YᵀY, mm².
    pub fn squares(&self) -> T {
        self.squares
    }

    /// The normal equations of x, y, z (in {B}), p1, p2, p3 at the radii of the pass, mm.
    pub fn normal_equations(&self, base: &BaseEdges<T>, radii_mm: &[T; POINTS]) -> SixUnknowns<T> {
        let mut equations = SixUnknowns::new(6);
        equations.add_squares(self.squares);
        let [c11, c21, c22, c31, c32, c33] = self.centre;
        let axes = base.axes();
        let centre = axes * Matrix3::new(c11, c21, c31, c21, c22, c32, c31, c32, c33) * axes.transpose();
        let centre_gradient = axes * self.centre_gradient;
        for i in 0..3 {
            let mixed = axes * self.mixed[i];
            for j in 0..3 {
                equations.add_to_entry(3 + i, j, mixed[j] * radii_mm[i]);
                if j <= i {
                    equations.add_to_entry(i, j, centre[(i, j)]);
                    equations.add_to_entry(3 + i, 3 + j, self.turns[packed_index(i, j)] * radii_mm[i] * radii_mm[j]);
                }
            }
            equations.add_to_gradient(i, centre_gradient[i]);
            equations.add_to_gradient(3 + i, self.turn_gradient[i] * radii_mm[i]);
        }
        equations
    }
}
