//! The joint centre as a pivot, fixed in both bodies, and the six length equations about it.
//!
//! The centre is fixed in both bodies: at O in {B} and at C in {P}. With R the platform's rotation and s_i its
//! end-points in {P}, end-point i stands at P_i = O + R (s_i - C), and the six cable lengths follow. Let O move by δO,
//! C by δC and the platform turn by ω: P_i moves by δ + ω × w_i with w_i = R (s_i - C) and **δ = δO - R δC**, and a
//! length with unit vector u along its cable changes by u·δ + (w × u)·ω. Lengths are smooth functions of O, C and R:
//! nothing here is singular at a flat tetrahedron or at the octahedron's fold.

use super::cable_length::CableLengths;
use crate::rig::{CABLES, POINTS, Parameters, Rig};
use crate::scalar::Real;
use crate::vector::{add_to, cross, difference, image, scaled, square, sum};
use nalgebra::{Matrix3, Vector3};

/// The joint centre in both bodies: the six unknowns in the form in which every pose is linear in them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pivot<T> {
    /// O: joint centre in {B}, mm.
    pub in_base_mm: Vector3<T>,
    /// C: joint centre in {P}, mm.
    pub in_platform_mm: Vector3<T>,
}

/// The points of a rig that lengths are computed from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigPoints<T> {
    /// Attachment points B1..B3 in {B}, mm.
    pub base_mm: [Vector3<T>; POINTS],
    /// End-points s_1..s_3 in {P}, mm.
    pub platform_mm: [Vector3<T>; POINTS],
}

impl<T: Real> RigPoints<T> {
    /// The points of `rig`.
    pub fn new(rig: &Rig<T>) -> Self {
        Self { base_mm: *rig.base_mm(), platform_mm: rig.platform_mm() }
    }
}

impl<T: Real> Pivot<T> {
    /// From the six unknowns, O then C, mm.
    pub fn from_array([x, y, z, u, v, w]: &[T; 6]) -> Self {
        Self { in_base_mm: Vector3::new(*x, *y, *z), in_platform_mm: Vector3::new(*u, *v, *w) }
    }

    /// Moves by a step in O and C, mm.
    pub fn move_by(&mut self, [x, y, z, u, v, w]: &[T; 6]) {
        add_to(&mut self.in_base_mm, &Vector3::new(*x, *y, *z));
        add_to(&mut self.in_platform_mm, &Vector3::new(*u, *v, *w));
    }

    /// The pivot from the centre in {B} and the radii: C is where three spheres of radii p_i about the end-points
    /// meet, on the base's side of the platform. When they do not meet, the point below their radical axis.
    pub fn from_parameters(parameters: &Parameters<T>, points: &RigPoints<T>) -> Self {
        let [_, second, third] = points.platform_mm;
        let [p1, p2, p3] = parameters.radii_mm.map(|p| p * p);
        // |C - s_i|² = p_i², first equation subtracted; s_1 is the origin and s_2 lies on the x axis.
        let x = (p1 - p2 + second.x * second.x) / (second.x + second.x);
        let y = (p1 - p3 + third.norm_squared() - x * third.x * T::of(2.0)) / (third.y + third.y);
        let depth = (p1 - x * x - y * y).max(T::zero()).root();
        Self { in_base_mm: parameters.centre_mm, in_platform_mm: Vector3::new(x, y, -depth) }
    }

    /// Centre and radii: p_i = |s_i - C|.
    pub fn parameters(&self, points: &RigPoints<T>) -> Parameters<T> {
        Parameters {
            centre_mm: self.in_base_mm,
            radii_mm: points.platform_mm.map(|s| (s - self.in_platform_mm).norm_squared().root()),
        }
    }
}

/// The six length equations of a pose at one estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LengthEquations<T> {
    /// Unit vector from attachment point to end-point: derivative of the length with δ.
    pub direction: [Vector3<T>; CABLES],
    /// w × u: derivative of the length with ω, mm/rad.
    pub moment_mm: [Vector3<T>; CABLES],
    /// Measured minus computed length, mm.
    pub residual_mm: [T; CABLES],
}

impl<T: Real> LengthEquations<T> {
    /// The equations of the pose with rotation `rotation` ({P} to {B}) about the pivot.
    #[inline(never)]
    pub fn new(points: &RigPoints<T>, pivot: &Pivot<T>, rotation: &Matrix3<T>, lengths: &CableLengths<T>) -> Self {
        let zero = Vector3::new(T::zero(), T::zero(), T::zero());
        let mut equations =
            Self { direction: [zero; CABLES], moment_mm: [zero; CABLES], residual_mm: *lengths.as_mm() };
        let [b1, b2, b3] = &points.base_mm;
        let (directions, _) = equations.direction.as_chunks_mut();
        let (moments, _) = equations.moment_mm.as_chunks_mut();
        let (residuals, _) = equations.residual_mm.as_chunks_mut();
        // As in `ATTACHMENTS`.
        let mut attachments = [b1, b2, b3];
        let cables = directions.iter_mut().zip(moments).zip(residuals);
        for (point, (([d1, d2], [m1, m2]), [e1, e2])) in points.platform_mm.iter().zip(cables) {
            let arm = image(rotation, &difference(point, &pivot.in_platform_mm));
            let end_point = sum(&pivot.in_base_mm, &arm);
            let cable =
                |attachment: &Vector3<T>, direction: &mut Vector3<T>, moment: &mut Vector3<T>, residual: &mut T| {
                    let span = difference(&end_point, attachment);
                    let computed = square(&span).root();
                    *direction = scaled(&span, T::one() / computed);
                    *moment = cross(&arm, direction);
                    *residual -= computed;
                };
            let [first, second, _] = attachments;
            cable(first, d1, m1, e1);
            cable(second, d2, m2, e2);
            attachments.rotate_left(1);
        }
        equations
    }
}

/// Inverse of a symmetric positive definite 3x3 matrix by cofactors; `None` when its determinant has no digits left.
#[inline(never)]
pub fn inverse_of_symmetric<T: Real>(matrix: &Matrix3<T>) -> Option<Matrix3<T>> {
    let (a, b, c) = (matrix.m11, matrix.m22, matrix.m33);
    let (d, e, f) = (matrix.m21, matrix.m31, matrix.m32);
    let (c11, c12, c13) = (b * c - f * f, e * f - d * c, d * f - e * b);
    let determinant = a * c11 + d * c12 + e * c13;
    if !(determinant > a * b * c * T::default_epsilon() * T::of(8.0)) {
        return None;
    }
    let inverse = T::one() / determinant;
    let (c22, c23, c33) = ((a * c - e * e) * inverse, (d * e - a * f) * inverse, (a * b - d * d) * inverse);
    let (c11, c12, c13) = (c11 * inverse, c12 * inverse, c13 * inverse);
    Some(Matrix3::new(c11, c12, c13, c12, c22, c23, c13, c23, c33))
}
