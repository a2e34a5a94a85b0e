//! The normal equations of the pivot: O in {B} and C in {P}, from poses that each see δO - R δC.

use super::normal_equations::{NormalEquations, at};
use crate::scalar::Real;
use crate::vector::{image_transposed, product_transposed};
use nalgebra::{Matrix3, Vector3};

impl<T: Real> NormalEquations<T> {
    /// Adds what a pose knows of δ = δO - R δC: Jᵀ S J and Jᵀ g for J = [I, -R], unknowns O and C.
    #[inline(never)]
    pub fn add_information(&mut self, rotation: &Matrix3<T>, information: &Matrix3<T>, gradient: &Vector3<T>) {
        let (r, s) = (rotation, information);
        let m = product_transposed(r, s);
        #[rustfmt::skip]
        let [
            o11,
            o21, o22,
            o31, o32, o33,
            m11, m12, m13, c11,
            m21, m22, m23, c21, c22,
            m31, m32, m33, c31, c32, c33,
        ] = &mut self.matrix;
        *o11 += s.m11;
        *o21 += s.m21;
        *o22 += s.m22;
        *o31 += s.m31;
        *o32 += s.m32;
        *o33 += s.m33;
        *m11 -= m.m11;
        *m12 -= m.m12;
        *m13 -= m.m13;
        *m21 -= m.m21;
        *m22 -= m.m22;
        *m23 -= m.m23;
        *m31 -= m.m31;
        *m32 -= m.m32;
        *m33 -= m.m33;
        // Rᵀ S R is symmetric.
        *c11 += m.m11 * r.m11 + m.m12 * r.m21 + m.m13 * r.m31;
        *c21 += m.m21 * r.m11 + m.m22 * r.m21 + m.m23 * r.m31;
        *c22 += m.m21 * r.m12 + m.m22 * r.m22 + m.m23 * r.m32;
        *c31 += m.m31 * r.m11 + m.m32 * r.m21 + m.m33 * r.m31;
        *c32 += m.m31 * r.m12 + m.m32 * r.m22 + m.m33 * r.m32;
        *c33 += m.m31 * r.m13 + m.m32 * r.m23 + m.m33 * r.m33;
        let turned = image_transposed(r, gradient);
        let [g1, g2, g3, h1, h2, h3] = &mut self.gradient;
        *g1 += gradient.x;
        *g2 += gradient.y;
        *g3 += gradient.z;
        *h1 -= turned.x;
        *h2 -= turned.y;
        *h3 -= turned.z;
    }

    /// Adds what a sample knows of δO = a + b t, unknowns a and b, for a known t.
    pub fn add_growing(&mut self, information: &Matrix3<T>, gradient: &Vector3<T>, t: T) {
        let Self { matrix, gradient: total, .. } = self;
        for i in 0..3 {
            for j in 0..=i {
                matrix[at(i, j)] += information[(i, j)];
                matrix[at(3 + i, 3 + j)] += information[(i, j)] * t * t;
            }
            for j in 0..3 {
                matrix[at(3 + i, j)] += information[(i, j)] * t;
            }
            total[i] += gradient[i];
            total[3 + i] += gradient[i] * t;
        }
    }

    /// Information and gradient of the first three unknowns, the others held.
    pub fn constant_part(&self) -> (Matrix3<T>, Vector3<T>) {
        let information = Matrix3::from_fn(|i, j| self.matrix[if i >= j { at(i, j) } else { at(j, i) }]);
        (information, Vector3::new(self.gradient[0], self.gradient[1], self.gradient[2]))
    }
}
