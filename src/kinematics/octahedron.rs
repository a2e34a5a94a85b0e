//! Forward kinematics without the joint centre: six cable lengths and three platform edges are an octahedron.
//!
//! Each end-point turns about its base edge (see [`hinge`](super::hinge)), so three hinge angles are unknown and the
//! three edges give three equations, |P_i - P_j|² = p_ij². Newton's method needs no trigonometric call: the cosine
//! and sine of a hinge are turned by the step and renormalised, and each row of the 3x3 system has two entries.
//!
//! The octahedron has up to sixteen assemblies. The one wanted is connected with the home pose without passing a
//! singular pose, so the determinant of the system keeps the sign that it has at home. Beyond that fold (0.9 % of
//! poses at 60 degrees of tilt and torsion with the centre 60 mm off) the lengths alone cannot tell the two sides;
//! there the joint centre of the other poses decides.

use super::cable_length::LengthError;
use super::hinge::{BaseEdge, BaseEdges, HingeCoordinates};
use crate::kinematics::CableLengths;
use crate::rig::{POINTS, Rig};
use crate::scalar::Real;
use crate::vector::{cross, difference, dot, scaled, square};
use nalgebra::{Matrix3, Vector3};

/// Newton steps after which a pose is given up. A regular pose takes five to six.
const STEP_CAP: usize = 20;

/// Angle of every hinge from the base plane at which Newton's method begins: 75 degrees (cosine, sine). No pose up
/// to 45 degrees of tilt and 30 degrees of torsion was lost from 60 to 80 degrees.
const START: (f64, f64) = (0.258_819_045_102_520_74, 0.965_925_826_289_068_3);

/// Smallest determinant of the normalised system at which an assembly counts as regular. Closer to the fold the
/// lengths determine the pose too poorly to find a start from it.
const REGULAR: f64 = 0.02;

/// An end-point's arm, seen along its hinge, mm: length times cosine and sine of the angle from the base plane
/// (outward) towards the platform.
#[derive(Clone, Copy, Debug, PartialEq)]
struct HingeArm<T> {
    out: T,
    up: T,
}

/// An end-point that turns about its base edge.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Hinged<T> {
    /// Foot of the end-point on the edge's line, in the axes of the base plane, mm.
    foot: [T; 2],
    /// Cosine and sine of the edge's direction.
    direction: [T; 2],
    /// Length of the arm, mm.
    length: T,
    arm: HingeArm<T>,
}

/// Where the platform stands: its end-points and its axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlatformPose<T> {
    /// P1, the origin of {P}, in {B}, mm.
    pub origin_mm: Vector3<T>,
    /// Rotation from {P} to {B}.
    pub rotation: Matrix3<T>,
}

/// Why the lengths of a pose give no platform pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum OctahedronError {
    /// A cable triangle is broken.
    Length(LengthError),
    /// No assembly was found on the home side of the fold: the platform's edges do not fit between the end-points,
    /// or the pose lies at or beyond the fold.
    DoesNotClose,
}

/// The octahedron of a rig.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Octahedron<T> {
    base: BaseEdges<T>,
    edges_mm: [T; POINTS],
    frame: PlatformFrame<T>,
}

/// How the axes of {P} follow from its end-points.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PlatformFrame<T> {
    /// P3 in {P}: x and y, mm.
    third_x_mm: T,
    third_y_mm: T,
}

/// One evaluation of the edge equations: values and the two derivatives of each.
struct EdgeSystem<T> {
    /// (|P_i - P_j|² - p_ij²) / 2, mm².
    value: [T; POINTS],
    /// Derivative with the angle of the edge's first end-point, mm².
    first: [T; POINTS],
    /// Derivative with the angle of the edge's second end-point, mm².
    second: [T; POINTS],
}

impl<T: Real> Octahedron<T> {
    /// The octahedron of `rig`.
    pub fn new(rig: &Rig<T>) -> Self {
        let third = rig.platform_mm()[2];
        Self {
            base: BaseEdges::new(rig),
            edges_mm: *rig.edges_mm(),
            frame: PlatformFrame { third_x_mm: third.x, third_y_mm: third.y },
        }
    }

    /// The rig's base edges.
    pub fn base(&self) -> &BaseEdges<T> {
        &self.base
    }

    /// The platform's pose on the home side of the fold, from one constant start: no estimate is needed.
    ///
    /// # Errors
    /// [`OctahedronError`] when a cable triangle is broken or no regular assembly is found.
    pub fn solve(&self, lengths: &CableLengths<T>) -> Result<PlatformPose<T>, OctahedronError> {
        let hinges = self.base.coordinates(lengths).map_err(OctahedronError::Length)?;
        let [e1, e2, e3] = self.base.as_array();
        let [h1, h2, h3] = &hinges;
        self.newton([Hinged::new(e1, h1), Hinged::new(e2, h2), Hinged::new(e3, h3)])
            .ok_or(OctahedronError::DoesNotClose)
    }

    #[inline(always)]
    fn newton(&self, [mut h1, mut h2, mut h3]: [Hinged<T>; POINTS]) -> Option<PlatformPose<T>> {
        // Half a thousandth of a millimetre on an edge; the step that follows squares the relative error.
        let close = self.edges_mm[0] * T::of(5e-4);
        for _ in 0..STEP_CAP {
            let system = self.evaluate(&h1, &h2, &h3);
            let determinant = system.determinant();
            let [turn1, turn2, turn3] = system.step(determinant);
            h1.turn(turn1);
            h2.turn(turn2);
            h3.turn(turn3);
            let [v1, v2, v3] = system.value;
            if v1.abs() < close && v2.abs() < close && v3.abs() < close {
                // Judged where the equations hold: on the home side the determinant is negative.
                let regular = -determinant > system.scale() * T::of(REGULAR);
                return regular.then(|| self.frame.pose(&self.base, &[h1.point(), h2.point(), h3.point()]));
            }
        }
        None
    }

    #[inline(always)]
    fn evaluate(&self, h1: &Hinged<T>, h2: &Hinged<T>, h3: &Hinged<T>) -> EdgeSystem<T> {
        let (p1, p2, p3) = (h1.point(), h2.point(), h3.point());
        let (t1, t2, t3) = (h1.tangent(), h2.tangent(), h3.tangent());
        let (p12, p23, p31) = (difference(&p1, &p2), difference(&p2, &p3), difference(&p3, &p1));
        let [e12, e23, e31] = self.edges_mm;
        let half = T::of(0.5);
        EdgeSystem {
            value: [
                (square(&p12) - e12 * e12) * half,
                (square(&p23) - e23 * e23) * half,
                (square(&p31) - e31 * e31) * half,
            ],
            first: [dot(&p12, &t1), dot(&p23, &t2), dot(&p31, &t3)],
            second: [-dot(&p12, &t2), -dot(&p23, &t3), -dot(&p31, &t1)],
        }
    }
}

impl<T: Real> Hinged<T> {
    #[inline(always)]
    fn new(edge: &BaseEdge<T>, hinge: &HingeCoordinates<T>) -> Self {
        let [cos, sin] = edge.direction;
        let [x, y] = edge.origin_mm;
        let length = hinge.distance_squared_mm2.root();
        Self {
            foot: [x + cos * hinge.along_mm, y + sin * hinge.along_mm],
            direction: edge.direction,
            length,
            arm: HingeArm { out: length * T::of(START.0), up: length * T::of(START.1) },
        }
    }

    /// The end-point, in the axes of the base plane, mm.
    #[inline(always)]
    fn point(&self) -> Vector3<T> {
        let ([x, y], [cos, sin]) = (self.foot, self.direction);
        Vector3::new(x + self.arm.out * sin, y - self.arm.out * cos, self.arm.up)
    }

    /// Derivative of [`point`](Self::point) with the angle, mm/rad.
    #[inline(always)]
    fn tangent(&self) -> Vector3<T> {
        let [cos, sin] = self.direction;
        Vector3::new(-(self.arm.up * sin), self.arm.up * cos, self.arm.out)
    }

    /// Turns the arm by atan(`step`), so that no step passes 90 degrees.
    #[inline(always)]
    fn turn(&mut self, step: T) {
        let limited = if step > T::one() {
            T::one()
        } else if step < -T::one() {
            -T::one()
        } else {
            step
        };
        let out = self.arm.out - self.arm.up * limited;
        let up = self.arm.up + self.arm.out * limited;
        let scale = self.length / (out * out + up * up).root();
        self.arm = HingeArm { out: out * scale, up: up * scale };
    }
}

impl<T: Real> EdgeSystem<T> {
    /// Determinant of [f0 s0 0; 0 f1 s1; s2 0 f2].
    #[inline(always)]
    fn determinant(&self) -> T {
        let ([f0, f1, f2], [s0, s1, s2]) = (self.first, self.second);
        f0 * f1 * f2 + s0 * s1 * s2
    }

    /// Product of the lengths of the rows: what the determinant is compared with.
    fn scale(&self) -> T {
        let ([f0, f1, f2], [s0, s1, s2]) = (self.first, self.second);
        (f0 * f0 + s0 * s0).root() * (f1 * f1 + s1 * s1).root() * (f2 * f2 + s2 * s2).root()
    }

    /// Newton's step by Cramer's rule.
    #[inline(always)]
    fn step(&self, determinant: T) -> [T; POINTS] {
        let ([f0, f1, f2], [s0, s1, s2], [v0, v1, v2]) = (self.first, self.second, self.value);
        let minus_inverse = -T::one() / determinant;
        [
            (v0 * f1 * f2 + s0 * (s1 * v2 - v1 * f2)) * minus_inverse,
            (v1 * f2 * f0 + s1 * (s2 * v0 - v2 * f0)) * minus_inverse,
            (v2 * f0 * f1 + s2 * (s0 * v1 - v0 * f1)) * minus_inverse,
        ]
    }
}

impl<T: Real> PlatformFrame<T> {
    /// Pose of the platform from its end-points in the axes of the base plane, which keep their distances.
    fn pose(&self, base: &BaseEdges<T>, points: &[Vector3<T>; POINTS]) -> PlatformPose<T> {
        let [p1, p2, p3] = points;
        let (along, third) = (base.in_base(&difference(p2, p1)), base.in_base(&difference(p3, p1)));
        let x = scaled(&along, T::one() / square(&along).root());
        let across = difference(&third, &scaled(&x, dot(&x, &third)));
        let outwards = if self.third_y_mm > T::zero() { T::one() } else { -T::one() };
        let y = scaled(&across, outwards / square(&across).root());
        let z = cross(&x, &y);
        PlatformPose {
            origin_mm: base.point_in_base(p1),
            rotation: Matrix3::new(x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z),
        }
    }
}
