//! The paper's tetrahedron O-B_a-B_b-P_i: an end-point from the joint centre, its radius and its two cables (Eq. 1-9).
//!
//! Written in the hinge's coordinates. With the foot of O on the base edge's line as origin of a triad `along` (the
//! edge), `inner` (from O to the line) and `normal` (of the plane O-B_a-B_b, on the outer side), an end-point at
//! distance p from O and at hinge coordinates (ξ, ρ²) has
//!
//! ```text
//! X = ξ - o_x,   d = (Y² - p² + ρ² + X²) / 2Y,   h = sqrt(ρ² - d²),
//! OP = X along + (Y - d) inner + h normal
//! ```
//!
//! where Y is the distance of O from the line. Its differential needs no 3x3 inverse: for the paper's A_i⁻¹ B_i only
//! the last column `a3 = (inner + (d/h) normal) / Y` is wanted, because
//! δOP = -δO + a3 (OP·δO + p δp), and -δO cancels in the difference of two end-points.

use super::hinge::{BaseEdge, HingeCoordinates};
use crate::scalar::Real;
use nalgebra::Vector3;

/// The part of a tetrahedron that depends on the joint centre and the radius, but not on the pose: O-B_a-B_b.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TetrahedronBase<T> {
    along: Vector3<T>,
    inner: Vector3<T>,
    normal: Vector3<T>,
    /// o_x: coordinate of O along the edge, mm.
    centre_along_mm: T,
    /// Y: distance of O from the edge's line, mm.
    distance_mm: T,
    inverse_distance: T,
    /// 1/2Y, 1/mm.
    half_inverse_distance: T,
    /// Y² - p², mm².
    power_mm2: T,
}

/// A closed tetrahedron: the end-point, and how it stands over the plane O-B_a-B_b.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Apex<T> {
    /// OP_i, from the joint centre, in the axes of {B}, mm.
    pub point_mm: Vector3<T>,
    /// d: distance from the base edge towards O, measured in the plane, mm.
    pub depth_mm: T,
    /// h: height over the plane, mm. Positive.
    pub height_mm: T,
}

impl<T: Real> TetrahedronBase<T> {
    /// The triangle O-B_a-B_b of one end-point with radius `radius_mm` about the centre at `centre_mm` in {B}.
    /// Meaningless (not finite) when the centre lies on the base edge's line; no tetrahedron closes then.
    pub fn new(edge: &BaseEdge<T>, centre_mm: &Vector3<T>, radius_mm: T) -> Self {
        let from_origin = centre_mm - edge.origin_mm;
        let centre_along_mm = from_origin.dot(&edge.along);
        let out = -from_origin.dot(&edge.outward);
        let up = -from_origin.dot(&edge.upward);
        let distance_mm = (out * out + up * up).root();
        let inverse_distance = T::one() / distance_mm;
        let (out, up) = (out * inverse_distance, up * inverse_distance);
        Self {
            along: edge.along,
            inner: edge.outward * out + edge.upward * up,
            // `inner` turned by 90 degrees about the edge, from outward to upward: the side of the plane O-B_a-B_b on
            // which the end-point lies at home. At large tilts (2 % of poses at 60 degrees) it changes sides.
            normal: edge.upward * out - edge.outward * up,
            centre_along_mm,
            distance_mm,
            inverse_distance,
            half_inverse_distance: inverse_distance * T::of(0.5),
            power_mm2: (distance_mm - radius_mm) * (distance_mm + radius_mm),
        }
    }

    /// The end-point on the outer side of the plane O-B_a-B_b, or `None` when the tetrahedron does not close: no
    /// point has these two cable lengths and this distance from the centre.
    #[inline]
    pub fn apex(&self, hinge: &HingeCoordinates<T>) -> Option<Apex<T>> {
        let x = hinge.along_mm - self.centre_along_mm;
        let d = (self.power_mm2 + hinge.distance_squared_mm2 + x * x) * self.half_inverse_distance;
        let height_squared = hinge.distance_squared_mm2 - d * d;
        // Also false for NaN. At exactly zero the differential is infinite: the two apices meet.
        if !(height_squared > T::zero()) {
            return None;
        }
        let height_mm = height_squared.root();
        let point_mm = self.along * x + self.inner * (self.distance_mm - d) + self.normal * height_mm;
        Some(Apex { point_mm, depth_mm: d, height_mm })
    }

    /// The direction in which the hinge turns, Y a3 = inner + (d/h) normal. OP_i moves along it by 1/Y
    /// ([`inverse_distance`](Self::inverse_distance)) times OP·δO + p δp.
    #[inline]
    pub fn turning(&self, apex: &Apex<T>, inverse_height: T) -> Vector3<T> {
        self.inner + self.normal * (apex.depth_mm * inverse_height)
    }

    /// 1/Y, 1/mm.
    #[inline]
    pub fn inverse_distance(&self) -> T {
        self.inverse_distance
    }
}
