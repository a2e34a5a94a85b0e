//! An end-point turns about its base edge like a door about its hinge.
//!
//! The two cables of end-point P_i run to the two ends of one base edge. Their lengths alone fix how far along the
//! edge P_i stands (ξ) and how far from it (ρ); what remains is one angle. Everything here is independent of the
//! joint centre and computed once a pose.

use super::cable_length::{CableLengths, LengthError, LengthFault, cable_number};
use crate::rig::{ATTACHMENTS, POINTS, Rig};
use crate::scalar::Real;
use nalgebra::{Matrix3, Vector3};

/// One base edge with a right-angled triad: `along` the edge, `outward` in the base plane away from the third
/// attachment point, `upward` normal to the base plane on the platform's side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaseEdge<T> {
    /// The attachment point of the end-point's first cable, in {B}, mm.
    pub origin_mm: Vector3<T>,
    /// Unit vector from the first to the second attachment point.
    pub along: Vector3<T>,
    /// Unit vector in the base plane, away from the third attachment point.
    pub outward: Vector3<T>,
    /// Unit normal of the base plane towards the platform.
    pub upward: Vector3<T>,
    /// Cosine and sine of the edge's direction in the plane's axes; `outward` is (sine, -cosine).
    pub direction: [T; 2],
    /// Length of the edge, mm.
    pub length_mm: T,
    inverse_twice_length: T,
}

/// The three base edges, in the order of the end-points P1, P2, P3, and the axes of their plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaseEdges<T> {
    edges: [BaseEdge<T>; POINTS],
    plane: Matrix3<T>,
}

/// Where an end-point stands on its hinge: coordinate along the base edge and squared distance from it.
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
        let upward = rig.base_normal();
        let base = rig.base_mm();
        // All edges turn the same way, so what holds for the first of them holds for all: `outward` is `along` turned
        // from the second axis to the first. The axes are a left-handed triad when the points are numbered clockwise.
        let axes = BaseEdge::new(base, &upward, 0, &Matrix3::identity());
        let plane = Matrix3::from_rows(&[axes.along.transpose(), -axes.outward.transpose(), upward.transpose()]);
        Self { edges: core::array::from_fn(|i| BaseEdge::new(base, &upward, i, &plane)), plane }
    }

    /// The edges in the order of the end-points.
    pub fn iter(&self) -> impl Iterator<Item = &BaseEdge<T>> {
        self.edges.iter()
    }

    /// The three edges as an array.
    pub fn as_array(&self) -> &[BaseEdge<T>; POINTS] {
        &self.edges
    }

    /// A vector in the axes of the base plane, turned into {B}. Those axes are along the first edge, towards the third
    /// attachment point, and upward: in them `along` and `outward` of every edge lack the third component and `upward`
    /// has no other.
    #[inline(never)]
    pub fn in_base(&self, in_plane: &Vector3<T>) -> Vector3<T> {
        self.plane.tr_mul(in_plane)
    }

    /// (ξ, ρ²) of the three end-points of a pose.
    ///
    /// # Errors
    /// The first end-point whose two cables and base edge do not make a triangle.
    pub fn coordinates(&self, lengths: &CableLengths<T>) -> Result<[HingeCoordinates<T>; POINTS], LengthError> {
        let coordinates = self.unchecked(lengths);
        Self::first_broken(&coordinates).map_or(Ok(coordinates), Err)
    }

    /// The first end-point whose two cables and base edge do not make a triangle.
    #[inline(never)]
    pub fn first_broken(coordinates: &[HingeCoordinates<T>; POINTS]) -> Option<LengthError> {
        // Written so that an overflow to infinity or NaN counts as broken too.
        let closes = |hinge: &HingeCoordinates<T>| {
            hinge.distance_squared_mm2 > T::zero() && hinge.distance_squared_mm2.is_a_number()
        };
        let broken = coordinates.iter().position(|hinge| !closes(hinge))?;
        Some(LengthError { cable: cable_number(2 * broken), fault: LengthFault::BreaksTriangle })
    }

    /// (ξ, ρ²) of lengths that may break their triangles. ρ² is not a positive number then, and no tetrahedron closes.
    #[inline]
    pub fn unchecked(&self, lengths: &CableLengths<T>) -> [HingeCoordinates<T>; POINTS] {
        let [l1, l2, l3, l4, l5, l6] = *lengths.as_mm();
        let [e1, e2, e3] = &self.edges;
        [e1.coordinates(l1, l2), e2.coordinates(l3, l4), e3.coordinates(l5, l6)]
    }
}

impl<T: Real> BaseEdge<T> {
    /// The edge of end-point `i`, with its direction in `plane`.
    #[inline(never)]
    fn new(base_mm: &[Vector3<T>; POINTS], upward: &Vector3<T>, i: usize, plane: &Matrix3<T>) -> Self {
        let [first, second] = ATTACHMENTS[i];
        let third = POINTS - first - second;
        let edge = base_mm[second] - base_mm[first];
        let length_mm = edge.norm_squared().root();
        let along = edge / length_mm;
        let across = along.cross(upward);
        let inwards = across.dot(&(base_mm[third] - base_mm[first])) > T::zero();
        let in_plane = plane * along;
        Self {
            origin_mm: base_mm[first],
            along,
            outward: if inwards { -across } else { across },
            upward: *upward,
            direction: [in_plane.x, in_plane.y],
            length_mm,
            inverse_twice_length: T::one() / (length_mm + length_mm),
        }
    }

    /// (ξ, ρ²) from the two cable lengths, mm: ξ = (L_a² - L_b² + b²) / 2b, ρ² = L_a² - ξ².
    /// ρ² is not positive when the lengths break the triangle.
    #[inline]
    pub fn coordinates(&self, first_mm: T, second_mm: T) -> HingeCoordinates<T> {
        // Differences as products: L_a² - L_b² in single precision would lose the digits that matter.
        let difference = (first_mm - second_mm) * (first_mm + second_mm);
        let along_mm = (difference + self.length_mm * self.length_mm) * self.inverse_twice_length;
        let distance_squared_mm2 = (first_mm - along_mm) * (first_mm + along_mm);
        HingeCoordinates { along_mm, distance_squared_mm2 }
    }
}
