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
//!
//! Vectors are in the axes of the base plane (see [`base_edges`](crate::kinematics::base_edges)).

use crate::kinematics::base_edges::{BaseEdge, HingeCoordinates};
use crate::scalar::Real;
use nalgebra::Vector3;

/// The part of a tetrahedron that depends on the joint centre and the radius, but not on the pose: O-B_a-B_b.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TetrahedronBase<T> {
    /// Cosine and sine of `along` in the base plane.
    direction: [T; 2],
    /// `inner` = `out` outward + `up` upward, a unit vector; `normal` = `out` upward - `up` outward.
    out: T,
    up: T,
    /// o_x: coordinate of O along the edge, mm.
    centre_along_mm: T,
    /// Y: distance of O from the edge's line, mm.
    distance_mm: T,
    /// 1/2Y, 1/mm.
    half_inverse: T,
    /// `out` / Y and `up` / Y, 1/mm.
    out_gradient: T,
    up_gradient: T,
    /// Y² - p², mm².
    power_mm2: T,
}

/// How a closed tetrahedron's end-point stands over the plane O-B_a-B_b.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot<T> {
    /// X: coordinate along the base edge from O, mm.
    pub along_mm: T,
    /// d: distance from the base edge towards O, measured in the plane, mm.
    pub depth_mm: T,
    /// h²: squared height over the plane, mm². Positive when the tetrahedron closes.
    pub height_squared_mm2: T,
}

impl<T: Real> TetrahedronBase<T> {
    /// The triangle O-B_a-B_b of one end-point with radius `radius_mm` about the centre at `centre_mm` in the axes of
    /// the base plane. Meaningless (not finite) when the centre lies on the base edge's line; no tetrahedron closes
    /// then.
    pub fn new(edge: &BaseEdge<T>, centre_mm: &Vector3<T>, radius_mm: T) -> Self {
        let [cos, sin] = edge.direction;
        let (x, y) = (centre_mm.x - edge.origin_mm[0], centre_mm.y - edge.origin_mm[1]);
        let centre_along_mm = x * cos + y * sin;
        let (out, up) = (y * cos - x * sin, -centre_mm.z);
        let distance_mm = (out * out + up * up).root();
        let inverse_distance = T::one() / distance_mm;
        // `normal` is `inner` turned by 90 degrees about the edge, from outward to upward: the side of the plane
        // O-B_a-B_b on which the end-point lies at home. At large tilts (2 % of poses at 60 degrees) it changes sides.
        let (out, up) = (out * inverse_distance, up * inverse_distance);
        Self {
            direction: edge.direction,
            out,
            up,
            centre_along_mm,
            distance_mm,
            half_inverse: inverse_distance * T::of(0.5),
            out_gradient: out * inverse_distance,
            up_gradient: up * inverse_distance,
            power_mm2: (distance_mm - radius_mm) * (distance_mm + radius_mm),
        }
    }

    /// Where the end-point stands in the plane O-B_a-B_b, or `None` when the tetrahedron does not close: no point has
    /// these two cable lengths and this distance from the centre.
    pub fn foot(&self, hinge: &HingeCoordinates<T>) -> Option<Foot<T>> {
        let along_mm = hinge.along_mm - self.centre_along_mm;
        let depth_mm = (self.power_mm2 + hinge.distance_squared_mm2 + along_mm * along_mm) * self.half_inverse;
        let foot = Foot { along_mm, depth_mm, height_squared_mm2: hinge.distance_squared_mm2 - depth_mm * depth_mm };
        // Also false for NaN. At exactly zero the differential is infinite: the two apices meet.
        if foot.height_squared_mm2 > T::zero() { Some(foot) } else { None }
    }

    /// OP_i, from the joint centre, in the axes of the base plane, mm: the apex at height h over its foot, on the
    /// outer side of the plane O-B_a-B_b.
    pub fn apex(&self, foot: &Foot<T>, height_mm: T) -> Vector3<T> {
        let inwards = self.distance_mm - foot.depth_mm;
        let outward = inwards * self.out - height_mm * self.up;
        let upward = inwards * self.up + height_mm * self.out;
        let [cos, sin] = self.direction;
        Vector3::new(foot.along_mm * cos + outward * sin, foot.along_mm * sin - outward * cos, upward)
    }

    /// a3, 1/mm, in the axes of the base plane, from 1/h: OP_i moves along it when OP·δO + p δp grows.
    pub fn gradient(&self, foot: &Foot<T>, inverse_height: T) -> Vector3<T> {
        let slope = foot.depth_mm * inverse_height;
        let outward = self.out_gradient - slope * self.up_gradient;
        let upward = self.up_gradient + slope * self.out_gradient;
        let [cos, sin] = self.direction;
        Vector3::new(outward * sin, -(outward * cos), upward)
    }
}
