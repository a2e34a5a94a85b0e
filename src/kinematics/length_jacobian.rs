//! The joint centre in both bodies, and the Jacobian of the six lengths about it.
//!
//! The centre is fixed in both bodies: at O in {B} and at C in {P}. With R the platform's rotation and s_k the end of
//! cable k in {P}, that end stands at P_k = O + R (s_k - C), and the six cable lengths follow. Let O move by δO, C by
//! δC and the platform turn by ω: P_k moves by δ + ω × w_k with w_k = R (s_k - C) and **δ = δO - R δC**, and a length
//! with unit vector u along its cable changes by u·δ + (w × u)·ω. Lengths are smooth functions of O, C and R: nothing
//! here is singular at a flat tetrahedron or at a singularity of the forward kinematics.

use super::cable_length::CableLengths;
use super::geometry::{Geometry, Span};
use super::trilateration::trilaterate;
use crate::rig::{CABLES, Parameters};
use crate::scalar::Real;
use nalgebra::{Matrix3, Vector3};

/// The joint centre in both bodies: the six unknowns in the form in which every pose is linear in them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointCentre<T> {
    /// O: joint centre in {B}, mm.
    pub in_base_mm: Vector3<T>,
    /// C: joint centre in {P}, mm.
    pub in_platform_mm: Vector3<T>,
}

impl<T: Real> JointCentre<T> {
    /// From the six unknowns, O then C, mm.
    pub fn from_array([x, y, z, u, v, w]: &[T; 6]) -> Self {
        Self { in_base_mm: Vector3::new(*x, *y, *z), in_platform_mm: Vector3::new(*u, *v, *w) }
    }

    /// From the centre in {B} and the radii: C is where three spheres of radii p_i about the end-points meet, on the
    /// base's side of the platform. When they do not meet, the point of the platform's plane on their radical axis.
    pub fn from_parameters(parameters: &Parameters<T>, geometry: &Geometry<T>) -> Self {
        let [s1, s2, s3] = &geometry.end_points_mm();
        let mut in_platform_mm = trilaterate([s1, s2, s3], &parameters.radii_mm, T::one());
        in_platform_mm.z = -in_platform_mm.z.abs();
        Self { in_base_mm: parameters.centre_mm, in_platform_mm }
    }
}

/// A row of the Jacobian: one length at one estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LengthRow<T> {
    /// u, the unit vector along the cable: derivative of the length with a translation of the platform.
    pub translation: Vector3<T>,
    /// w × u: derivative of the length with a rotation of the platform about the joint centre, mm/rad.
    pub rotation_mm: Vector3<T>,
    /// Measured minus computed length, mm.
    pub residual_mm: T,
}

/// The Jacobian of the six lengths of a pose, and their residuals, at one estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LengthJacobian<T> {
    /// In the order of the cables, L1..L6.
    pub rows: [LengthRow<T>; CABLES],
}

impl<T: Real> LengthRow<T> {
    /// The row of a cable (from 0) whose end stands at `arm` from the joint centre.
    ///
    /// Inlined, a Jacobian is written where it is wanted: 310 instructions of 900 less, a tenth of an identification.
    #[inline(always)]
    fn new(geometry: &Geometry<T>, centre: &JointCentre<T>, cable: usize, arm: &Vector3<T>, measured_mm: T) -> Self {
        let Span { length_mm, direction } = geometry.span(cable, &(centre.in_base_mm + arm));
        Self { translation: direction, rotation_mm: arm.cross(&direction), residual_mm: measured_mm - length_mm }
    }
}

impl<T: Real> LengthJacobian<T> {
    /// The Jacobian of the pose with rotation `rotation` ({P} to {B}) about the joint centre `centre`.
    // Not inlined: one copy where it is quick to run instead of three, 4 KB of flash (`cargo footprint --sections`).
    #[inline(never)]
    #[cfg_attr(feature = "ccm", unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
    pub fn new(
        geometry: &Geometry<T>,
        centre: &JointCentre<T>,
        rotation: &Matrix3<T>,
        lengths: &CableLengths<T>,
    ) -> Self {
        let arm = |cable: usize| rotation * (geometry.end_mm[cable] - centre.in_platform_mm);
        let row = |cable: usize, arm: &Vector3<T>| LengthRow::new(geometry, centre, cable, arm, lengths.as_mm()[cable]);
        let [a, c, e] = [arm(0), arm(2), arm(4)];
        // The second cable of an end-point of the 3-3 machine has the arm of the first.
        let [b, d, f] = if geometry.is_three_three { [a, c, e] } else { [arm(1), arm(3), arm(5)] };
        Self { rows: [row(0, &a), row(1, &b), row(2, &c), row(3, &d), row(4, &e), row(5, &f)] }
    }

    /// Includes that the joint centre moves with the rotation, by `turning` ω for a small ω, mm/rad.
    pub fn include_motion(&mut self, turning: &Matrix3<T>) {
        for row in &mut self.rows {
            row.rotation_mm += turning.tr_mul(&row.translation);
        }
    }
}
