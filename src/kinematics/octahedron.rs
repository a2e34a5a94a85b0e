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
use crate::rig::{EDGE_ENDS, POINTS, Rig};
use crate::scalar::Real;
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

    fn newton(&self, mut hinged: [Hinged<T>; POINTS]) -> Option<PlatformPose<T>> {
        // Half a thousandth of a millimetre on an edge; the step that follows squares the relative error.
        let close = self.edges_mm[0] * T::of(5e-4);
        for _ in 0..STEP_CAP {
            let system = self.evaluate(&hinged);
            let determinant = system.determinant();
            let step = system.step(determinant);
            for (hinged, turn) in hinged.iter_mut().zip(step) {
                hinged.turn(turn);
            }
            if system.value.iter().all(|v| v.abs() < close) {
                // Judged where the equations hold: on the home side the determinant is negative.
                let regular = -determinant > system.scale() * T::of(REGULAR);
                return regular.then(|| self.frame.pose(&self.base, &hinged.map(|hinged| hinged.point())));
            }
        }
        None
    }

    fn evaluate(&self, hinged: &[Hinged<T>; POINTS]) -> EdgeSystem<T> {
        let points = hinged.map(|hinged| hinged.point());
        let tangents = hinged.map(|hinged| hinged.tangent());
        let mut system =
            EdgeSystem { value: [T::zero(); POINTS], first: [T::zero(); POINTS], second: [T::zero(); POINTS] };
        for (k, &[i, j]) in EDGE_ENDS.iter().enumerate() {
            let span = points[i] - points[j];
            system.value[k] = (span.norm_squared() - self.edges_mm[k] * self.edges_mm[k]) * T::of(0.5);
            system.first[k] = span.dot(&tangents[i]);
            system.second[k] = -span.dot(&tangents[j]);
        }
        system
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
        let limited = step.clamp(-T::one(), T::one());
        let out = self.arm.out - self.arm.up * limited;
        let up = self.arm.up + self.arm.out * limited;
        let scale = self.length / (out * out + up * up).root();
        self.arm = HingeArm { out: out * scale, up: up * scale };
    }
}

impl<T: Real> EdgeSystem<T> {
    /// Determinant of [f0 s0 0; 0 f1 s1; s2 0 f2].
    fn determinant(&self) -> T {
        let ([f0, f1, f2], [s0, s1, s2]) = (self.first, self.second);
        f0 * f1 * f2 + s0 * s1 * s2
    }

    /// Product of the lengths of the rows: what the determinant is compared with.
    fn scale(&self) -> T {
        let square = |k: usize| self.first[k] * self.first[k] + self.second[k] * self.second[k];
        square(0).root() * square(1).root() * square(2).root()
    }

    /// Newton's step by Cramer's rule.
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
        let (along, third) = (base.in_base(&(p2 - p1)), base.in_base(&(p3 - p1)));
        let x = along / along.norm_squared().root();
        let across = third - x * x.dot(&third);
        let y = across / across.norm_squared().root();
        let y = if self.third_y_mm > T::zero() { y } else { -y };
        let z = x.cross(&y);
        PlatformPose { origin_mm: base.point_in_base(p1), rotation: Matrix3::from_columns(&[x, y, z]) }
    }
}
