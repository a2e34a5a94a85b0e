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
        let triad = |i: usize| {
            let [first, second] = ATTACHMENTS[i];
            let third = POINTS - first - second;
            let edge = base[second] - base[first];
            let length_mm = edge.norm_squared().root();
            let along = edge / length_mm;
            let across = along.cross(&upward);
            let inwards = across.dot(&(base[third] - base[first])) > T::zero();
            (length_mm, along, if inwards { -across } else { across })
        };
        // All edges turn the same way, so what holds for the first of them holds for all: `outward` is `along` turned
        // from the second axis to the first. The axes are a left-handed triad when the points are numbered clockwise.
        let (_, x, outward) = triad(0);
        let plane = Matrix3::from_rows(&[x.transpose(), -outward.transpose(), upward.transpose()]);
        let edges = core::array::from_fn(|i| {
            let (length_mm, along, outward) = triad(i);
            let inverse_twice_length = T::one() / (length_mm + length_mm);
            let in_plane = plane * along;
            let direction = [in_plane.x, in_plane.y];
            let origin_mm = base[ATTACHMENTS[i][0]];
            BaseEdge { origin_mm, along, outward, upward, direction, length_mm, inverse_twice_length }
        });
        Self { edges, plane }
    }

    /// The edges in the order of the end-points.
    pub fn iter(&self) -> impl Iterator<Item = &BaseEdge<T>> {
        self.edges.iter()
    }

    /// The three edges as an array.
    pub fn as_array(&self) -> &[BaseEdge<T>; POINTS] {
        &self.edges
    }

    /// The axes of the base plane as rows, in {B}: along the first edge, towards the third attachment point, upward.
    /// In them `along` and `outward` of every edge lack the third component and `upward` is nothing else.
    pub fn plane(&self) -> &Matrix3<T> {
        &self.plane
    }

    /// (ξ, ρ²) of the three end-points of a pose.
    ///
    /// # Errors
    /// The first end-point whose two cables and base edge do not make a triangle.
    pub fn coordinates(&self, lengths: &CableLengths<T>) -> Result<[HingeCoordinates<T>; POINTS], LengthError> {
        let coordinates = self.unchecked(lengths);
        for (i, hinge) in coordinates.iter().enumerate() {
            // Written so that an overflow to infinity or NaN counts as broken too.
            let closes = hinge.distance_squared_mm2 > T::zero() && hinge.distance_squared_mm2.is_a_number();
            if !closes {
                return Err(LengthError { cable: cable_number(2 * i), fault: LengthFault::BreaksTriangle });
            }
        }
        Ok(coordinates)
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
