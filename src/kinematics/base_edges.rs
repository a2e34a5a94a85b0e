//! Hinge coordinates: an end-point turns about its base edge like a door about its hinge.
//!
//! The two cables of end-point P_i run to the two ends of one base edge. Their lengths give its coordinate along the
//! edge (ξ) and its distance from it (ρ); one angle is left. Nothing here depends on the joint centre.
//!
//! Points are given in the **axes of the base plane**: origin B1, x along the first edge, y towards the third
//! attachment point, z towards the platform. Edges and their outward normals have no z there, which saves a third of
//! all products.

use super::cable_length::{CableLengths, LengthError};
use crate::linear_algebra::{non_negative_root, triad};
use crate::rig::{POINTS, Rig};
use crate::scalar::Real;
use nalgebra::{Matrix3, Vector3};

/// One base edge, in the axes of the base plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaseEdge<T> {
    /// The attachment point of the end-point's first cable, mm.
    pub origin_mm: [T; 2],
    /// Cosine and sine of the direction to the second attachment point; outward, away from the third, is
    /// (sine, -cosine).
    pub direction: [T; 2],
    /// Length of the edge, mm.
    pub length_mm: T,
    inverse_twice_length: T,
}

/// The three base edges, in the order of the end-points P1, P2, P3, and the axes of their plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaseEdges<T> {
    edges: [BaseEdge<T>; POINTS],
    /// The axes as columns, in {B}. A left-handed triad when the attachment points are numbered clockwise.
    pub(super) axes: Matrix3<T>,
    /// 1, or -1 for a left-handed triad.
    pub(super) side: T,
    /// B1 in {B}, mm.
    pub(super) origin_mm: Vector3<T>,
}

/// Hinge coordinates of an end-point: along the base edge, and squared distance from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HingeCoordinates<T> {
    /// ξ: coordinate of P_i along the edge from its first attachment point, mm.
    pub along_mm: T,
    /// ρ²: squared distance of P_i from the edge's line, mm². Positive.
    pub distance_squared_mm2: T,
}

impl<T: Real> BaseEdges<T> {
    /// The edges of a rig.
    pub fn new(rig: &Rig<T>) -> Self {
        let [b1, b2, b3] = rig.base_mm();
        let mut axes = triad(&(b2 - b1), &(b3 - b1));
        let side = if axes.m33 < T::zero() { -T::one() } else { T::one() };
        (axes.m13, axes.m23, axes.m33) = (axes.m13 * side, axes.m23 * side, axes.m33 * side);
        // From B1 round to B1, as in `ATTACHMENTS`.
        let mut first = Vector3::zeros();
        let edges = [b2, b3, b1].map(|end| {
            let second = axes.tr_mul(&(end - b1));
            BaseEdge::between(&core::mem::replace(&mut first, second), &second)
        });
        Self { edges, axes, side, origin_mm: *b1 }
    }

    /// The three edges in the order of the end-points.
    pub fn as_array(&self) -> &[BaseEdge<T>; POINTS] {
        &self.edges
    }

    /// A point of {B}, mm, in the axes of the base plane, from B1.
    pub fn in_plane(&self, point_mm: &Vector3<T>) -> Vector3<T> {
        self.axes.tr_mul(&(point_mm - self.origin_mm))
    }

    /// The axes of the base plane as columns, in {B}. A left-handed triad when the attachment points are numbered
    /// clockwise.
    pub fn axes(&self) -> &Matrix3<T> {
        &self.axes
    }

    /// A vector in the axes of the base plane, in {B}.
    pub fn in_base(&self, in_plane: &Vector3<T>) -> Vector3<T> {
        self.axes * in_plane
    }

    /// The first end-point whose two cables and base edge make no triangle, as an error; `None` when all do.
    pub fn first_broken(&self, lengths: &CableLengths<T>) -> Option<LengthError> {
        let (pairs, _) = lengths.as_mm().as_chunks();
        let closes = |(edge, [first, second]): (&BaseEdge<T>, &[T; 2])| edge.coordinates(*first, *second).closes();
        let broken = self.edges.iter().zip(pairs).position(|cables| !closes(cables))?;
        Some(LengthError::broken_triangle(broken))
    }

    /// Hinge coordinates of the three end-points. Where lengths break their triangle, ρ² is not positive.
    pub fn unchecked(&self, lengths: &CableLengths<T>) -> [HingeCoordinates<T>; POINTS] {
        let [l1, l2, l3, l4, l5, l6] = *lengths.as_mm();
        let [e1, e2, e3] = &self.edges;
        [e1.coordinates(l1, l2), e2.coordinates(l3, l4), e3.coordinates(l5, l6)]
    }
}

impl<T: Real> HingeCoordinates<T> {
    /// The two cables and the base edge make a triangle. Written so that an overflow to infinity or NaN does not.
    fn closes(&self) -> bool {
        self.distance_squared_mm2 > T::zero() && self.distance_squared_mm2 < T::of(1e30)
    }
}

impl<T: Real> BaseEdge<T> {
    /// The edge between two attachment points in the plane.
    fn between(first_mm: &Vector3<T>, second_mm: &Vector3<T>) -> Self {
        let (x, y) = (second_mm.x - first_mm.x, second_mm.y - first_mm.y);
        let length_mm = non_negative_root(x * x + y * y);
        Self {
            origin_mm: [first_mm.x, first_mm.y],
            direction: [x / length_mm, y / length_mm],
            length_mm,
            inverse_twice_length: T::one() / (length_mm + length_mm),
        }
    }

    /// (ξ, ρ²) from the two cable lengths, mm: ξ = (L_a² - L_b² + b²) / 2b, ρ² = L_a² - ξ².
    /// ρ² is not positive when the lengths break the triangle.
    pub fn coordinates(&self, first_mm: T, second_mm: T) -> HingeCoordinates<T> {
        // Differences as products: L_a² - L_b² in single precision would lose the digits that matter.
        let difference = (first_mm - second_mm) * (first_mm + second_mm);
        let along_mm = (difference + self.length_mm * self.length_mm) * self.inverse_twice_length;
        let distance_squared_mm2 = (first_mm - along_mm) * (first_mm + along_mm);
        HingeCoordinates { along_mm, distance_squared_mm2 }
    }
}
