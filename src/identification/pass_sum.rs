//! One pass of the paper's iteration: DᵀD, DᵀY and YᵀY (Eq. 15, 17) summed over the poses without D.
//!
//! With D = K W of a pose (see [`model`](super::model)) its share is Wᵀ M W and Wᵀ s for M = KᵀK and s = KᵀY, three by
//! three and three. In W = [OP_i, p_i] the radii are the same for all poses of a pass, so they are multiplied in once,
//! at its end: 144 operations a pose instead of 189 with the rows of D, and fewer sums to load and store.

use super::model::{LaidPose, Turns};
use super::normal_equations::{NormalEquations, at};
use crate::kinematics::BaseEdges;
use crate::rig::POINTS;
use crate::scalar::Real;
use crate::vector::{add_to, combination};
use nalgebra::Vector3;

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
    #[inline(never)]
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
    #[inline(always)]
    pub fn add(&mut self, pose: &LaidPose<T>, turns: &Turns<T>) {
        let [p1, p2, p3] = &pose.points_mm;
        let [[k11, k12], [k22, k23], [k33, k31]] = *turns;
        let [y1, y2, y3] = pose.residuals_mm;
        // M = KᵀK; each two end-points share one edge, each end-point has two.
        let (m11, m22, m33) = (k11 * k11 + k31 * k31, k12 * k12 + k22 * k22, k23 * k23 + k33 * k33);
        let (m21, m32, m31) = (k11 * k12, k22 * k23, k33 * k31);
        let (s1, s2, s3) = (k11 * y1 + k31 * y3, k12 * y1 + k22 * y2, k23 * y2 + k33 * y3);
        let v1 = combination(&pose.points_mm, [m11, m21, m31]);
        let v2 = combination(&pose.points_mm, [m21, m22, m32]);
        let v3 = combination(&pose.points_mm, [m31, m32, m33]);
        let [c11, c21, c22, c31, c32, c33] = &mut self.centre;
        *c11 += p1.x * v1.x + p2.x * v2.x + p3.x * v3.x;
        *c21 += p1.y * v1.x + p2.y * v2.x + p3.y * v3.x;
        *c22 += p1.y * v1.y + p2.y * v2.y + p3.y * v3.y;
        *c31 += p1.z * v1.x + p2.z * v2.x + p3.z * v3.x;
        *c32 += p1.z * v1.y + p2.z * v2.y + p3.z * v3.y;
        *c33 += p1.z * v1.z + p2.z * v2.z + p3.z * v3.z;
        let [mixed1, mixed2, mixed3] = &mut self.mixed;
        add_to(mixed1, &v1);
        add_to(mixed2, &v2);
        add_to(mixed3, &v3);
        let [t11, t21, t22, t31, t32, t33] = &mut self.turns;
        *t11 += m11;
        *t21 += m21;
        *t22 += m22;
        *t31 += m31;
        *t32 += m32;
        *t33 += m33;
        add_to(&mut self.centre_gradient, &combination(&pose.points_mm, [s1, s2, s3]));
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
    pub fn normal_equations(&self, base: &BaseEdges<T>, radii_mm: &[T; POINTS]) -> NormalEquations<T> {
        // Written where they stay: a matrix on the stack beside that of the caller would be the deepest of all.
        let mut equations = NormalEquations::new();
        equations.squares = self.squares;
        let [c11, c21, c22, c31, c32, c33] = self.centre;
        // Rows turned first, columns then.
        let x = base.in_base(&Vector3::new(c11, c21, c31));
        let y = base.in_base(&Vector3::new(c21, c22, c32));
        let z = base.in_base(&Vector3::new(c31, c32, c33));
        let centre_gradient = base.in_base(&self.centre_gradient);
        for i in 0..3 {
            let row = base.in_base(&Vector3::new(x[i], y[i], z[i]));
            let mixed = base.in_base(&self.mixed[i]);
            for j in 0..3 {
                equations.matrix[at(3 + i, j)] = mixed[j] * radii_mm[i];
                if j <= i {
                    equations.matrix[at(i, j)] = row[j];
                    equations.matrix[at(3 + i, 3 + j)] = self.turns[at(i, j)] * radii_mm[i] * radii_mm[j];
                }
            }
            equations.gradient[i] = centre_gradient[i];
            equations.gradient[3 + i] = self.turn_gradient[i] * radii_mm[i];
        }
        equations
    }
}
