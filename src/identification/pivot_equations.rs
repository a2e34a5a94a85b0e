//! The normal equations of the pivot: O in {B} and C in {P}, from poses that each see δO - R δC.

use super::normal_equations::{NormalEquations, UNKNOWNS, at};
use crate::kinematics::PlatformPose;
use crate::scalar::Real;
use nalgebra::{Matrix3, Vector3};

impl<T: Real> NormalEquations<T> {
    /// Adds the three equations O - R C = t of a platform pose with rotation R and origin t: the linear fit that
    /// needs no start.
    pub fn add_pivot(&mut self, pose: &PlatformPose<T>) {
        for row in 0..3 {
            let mut equation = [T::zero(); UNKNOWNS];
            equation[row] = T::one();
            for column in 0..3 {
                equation[3 + column] = -pose.rotation[(row, column)];
            }
            self.add(&equation, pose.origin_mm[row]);
        }
    }

    /// Adds what a pose knows of δ = δO - R δC: Jᵀ S J and Jᵀ g for J = [I, -R], unknowns O and C.
    pub fn add_information(&mut self, rotation: &Matrix3<T>, information: &Matrix3<T>, gradient: &Vector3<T>) {
        let mixed = rotation.transpose() * information;
        let inner = mixed * rotation;
        let turned = rotation.transpose() * gradient;
        let Self { matrix, gradient: total, .. } = self;
        for i in 0..3 {
            for j in 0..=i {
                matrix[at(i, j)] += information[(i, j)];
                matrix[at(3 + i, 3 + j)] += inner[(i, j)];
            }
            for j in 0..3 {
                matrix[at(3 + i, j)] -= mixed[(i, j)];
            }
            total[i] += gradient[i];
            total[3 + i] -= turned[i];
        }
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
