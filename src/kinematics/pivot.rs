//! The joint centre as a pivot, fixed in both bodies, and the six length equations about it.
//!
//! The centre is fixed in both bodies: at O in {B} and at C in {P}. With R the platform's rotation and s_i its
//! end-points in {P}, end-point i stands at P_i = O + R (s_i - C), and the six cable lengths follow. Let O move by δO,
//! C by δC and the platform turn by ω: P_i moves by δ + ω × w_i with w_i = R (s_i - C) and **δ = δO - R δC**, and a
//! length with unit vector u along its cable changes by u·δ + (w × u)·ω. Lengths are smooth functions of O, C and R:
//! nothing here is singular at a flat tetrahedron or at the octahedron's fold.

use super::cable_length::CableLengths;
use super::spheres::spheres_meet;
use crate::calls::accumulate;
use crate::rig::{CABLES, POINTS, Parameters, Rig};
use crate::scalar::Real;
use crate::vector::{cross, difference, image, scaled, square, sum};
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
    #[inline(never)]
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
    pub fn move_by(&mut self, step: &[T; 6]) {
        accumulate(self.in_base_mm.as_mut_slice(), &step[..3]);
        accumulate(self.in_platform_mm.as_mut_slice(), &step[3..]);
    }

    /// The pivot from the centre in {B} and the radii: C is where three spheres of radii p_i about the end-points
    /// meet, on the base's side of the platform. When they do not meet, the point below their radical axis.
    #[inline(never)]
    pub fn from_parameters(parameters: &Parameters<T>, points: &RigPoints<T>) -> Self {
        let [s1, s2, s3] = &points.platform_mm;
        let mut in_platform_mm = spheres_meet([s1, s2, s3], &parameters.radii_mm, T::one());
        in_platform_mm.z = -in_platform_mm.z.abs();
        Self { in_base_mm: parameters.centre_mm, in_platform_mm }
    }
}

/// The length equation of a cable at one estimate of a pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LengthEquation<T> {
    /// Unit vector from attachment point to end-point: derivative of the length with δ.
    pub direction: Vector3<T>,
    /// w × u: derivative of the length with ω, mm/rad.
    pub moment_mm: Vector3<T>,
    /// Measured minus computed length, mm.
    pub residual_mm: T,
}

/// The six length equations of a pose at one estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LengthEquations<T> {
    /// In the order of the cables, L1..L6.
    pub cables: [LengthEquation<T>; CABLES],
}

impl<T: Real> LengthEquations<T> {
    /// The equations of the pose with rotation `rotation` ({P} to {B}) about the pivot.
    #[inline(always)]
    pub fn new(points: &RigPoints<T>, pivot: &Pivot<T>, rotation: &Matrix3<T>, lengths: &CableLengths<T>) -> Self {
        let mut equations = Self::empty();
        equations.set(points, pivot, rotation, lengths);
        equations
    }

    /// Nothing yet, for [`set`](Self::set).
    #[inline(always)]
    pub(crate) fn empty() -> Self {
        let zero = Vector3::new(T::zero(), T::zero(), T::zero());
        Self { cables: [LengthEquation { direction: zero, moment_mm: zero, residual_mm: T::zero() }; CABLES] }
    }

    /// [`new`](Self::new) in place: as a result they would be copied, which takes half as long as computing them.
    #[inline(never)]
    pub(crate) fn set(
        &mut self,
        points: &RigPoints<T>,
        pivot: &Pivot<T>,
        rotation: &Matrix3<T>,
        lengths: &CableLengths<T>,
    ) {
        let [b1, b2, b3] = &points.base_mm;
        // As in `ATTACHMENTS`.
        let attachments = [[b1, b2], [b2, b3], [b3, b1]];
        let (lengths, _) = lengths.as_mm().as_chunks::<2>();
        let (cables, _) = self.cables.as_chunks_mut::<2>();
        let end_points = points.platform_mm.iter().zip(&attachments).zip(lengths).zip(cables);
        for (((point, [first, second]), [l1, l2]), [cable1, cable2]) in end_points {
            let arm = image(rotation, &difference(point, &pivot.in_platform_mm));
            let end_point = sum(&pivot.in_base_mm, &arm);
            // In words: as a loop they would take an eighth longer.
            *cable1 = LengthEquation::new(&arm, &difference(&end_point, first), *l1);
            *cable2 = LengthEquation::new(&arm, &difference(&end_point, second), *l2);
        }
    }
}

impl<T: Real> LengthEquation<T> {
    /// The equation of the cable along `span` to the end-point at `arm` from the centre, mm.
    #[inline(always)]
    fn new(arm: &Vector3<T>, span: &Vector3<T>, measured_mm: T) -> Self {
        let computed = square(span).root();
        let direction = scaled(span, T::one() / computed);
        Self { direction, moment_mm: cross(arm, &direction), residual_mm: measured_mm - computed }
    }
}
