//! Forward kinematics of the 3-3 Stewart-Gough platform: the platform's pose from six cable lengths, without the joint
//! centre. Base triangle, platform triangle and six cables are an octahedron (Nanua, Waldron and Murthy 1990).
//!
//! Each end-point turns about its base edge (see [`base edges`](super::base_edges)), so three hinge angles are unknown
//! and the three edges give three equations, |P_i - P_j|² = p_ij². Newton's method needs no trigonometric call: the
//! cosine and sine of a hinge are turned by the step and renormalised, and each row of the 3x3 system has two entries.
//!
//! The lengths admit up to sixteen assembly modes. The one wanted is connected with the home pose without passing a
//! (type II) singularity (Gosselin and Angeles 1990), so the determinant of the system keeps the sign that it has at
//! home. Beyond that singularity (0.9 % of poses at 60 degrees of tilt and torsion with the centre 60 mm off) the
//! lengths alone cannot distinguish the two modes; there the joint centre of the other poses decides.

use super::base_edges::{BaseEdges, HingeCoordinates};
use super::cable_length::{CableLengths, LengthError};
use crate::linear_algebra::triad;
use crate::rig::{CABLES, POINTS, Rig};
use crate::scalar::Real;
use nalgebra::{Matrix3, Vector3};

/// Maximum number of Newton steps. A regular pose takes about five.
const MAX_STEPS: usize = 20;

/// Angle of every hinge from the base plane at which Newton's method begins: 78 degrees (cosine, sine). No pose up to
/// 45 degrees of tilt and 30 degrees of torsion was lost from 60 to 80 degrees; the steps are fewer than from 75 or
/// less.
const START: (f64, f64) = (0.207_911_690_817_759_45, 0.978_147_600_733_805_6);

/// Smallest determinant of the system with normalised rows at which a pose counts as regular. Closer to the singularity
/// the lengths determine the pose too poorly for a start.
const REGULAR: f64 = 0.02;

/// An end-point's arm, seen along its hinge, mm: length times cosine and sine of the angle from the base plane
/// (outward) towards the platform.
#[derive(Clone, Copy, Debug)]
struct HingeArm<T> {
    /// ξ: where the arm begins on the base edge, mm.
    along: T,
    length: T,
    /// Length times cosine, outward in the base plane.
    out: T,
    /// Length times sine, towards the platform.
    up: T,
}

/// A platform edge P_i P_j spans a corner of the base: hinge j begins where hinge i ends, turned by an angle γ. Seen
/// from there, P_i is (-a, out_i, up_i) along hinge i, outward and upward, and P_j is (b, out_j, up_j) along hinge j;
/// the cables from the corner to both, L and L', and the edge make a triangle. By the law of cosines -P_i·P_j + (L² +
/// L'² - p_ij²)/2 = 0, where -P_i·P_j = (a b - out_i out_j) cos γ + (b out_i + a out_j) sin γ - up_i up_j.
#[derive(Clone, Copy, Debug)]
struct Corner<T> {
    /// All in it that depends on no angle, mm².
    constant: T,
    /// b sin γ and a sin γ: what out_i and out_j have, mm.
    first: T,
    second: T,
    /// cos γ.
    cos: T,
}

/// The equation of a platform edge at one estimate.
#[derive(Clone, Copy, Debug)]
struct Row<T> {
    /// Half of |P_i - P_j|² - p_ij², mm².
    value: T,
    /// How fast it falls with the angles of hinges i and j, mm².
    first: T,
    second: T,
}

/// The pose of the platform.
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
pub enum PlatformError {
    /// A cable triangle is broken.
    Length(LengthError),
    /// No assembly mode was found on the home side of the singularity: the platform's edges do not fit between the
    /// end-points, or the pose lies at or beyond the singularity.
    DoesNotClose,
}

/// The forward kinematics of a rig.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForwardKinematics<T> {
    base: BaseEdges<T>,
    /// p12, p23, p31, mm.
    edges_mm: [T; POINTS],
    /// Largest error of half a squared edge at which Newton's method ends, mm².
    tolerance_mm2: T,
}

impl<T: Real> ForwardKinematics<T> {
    /// The forward kinematics of `rig`; where every cable has ends of its own, of the nearest triangles.
    pub fn new(rig: &Rig<T>) -> Self {
        let edges_mm = *rig.edges_mm();
        // Half the digits: the step that follows has them all.
        let tolerance_mm2 = edges_mm[0] * edges_mm[0] * T::default_epsilon().root() * T::of(0.5);
        Self { base: BaseEdges::new(rig), edges_mm, tolerance_mm2 }
    }

    /// The platform's pose on the home side of the singularity, from one constant start: no estimate is needed.
    ///
    /// # Errors
    /// [`PlatformError`] when a cable triangle is broken or no regular assembly is found.
    #[cfg_attr(feature = "ccm", inline(never), unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
    pub fn solve(&self, lengths: &CableLengths<T>) -> Result<PlatformPose<T>, PlatformError> {
        let (edges, mm) = (self.base.as_array(), lengths.as_mm());
        let mut arms = core::array::from_fn(|i| HingeArm::at_start(&edges[i].coordinates(mm[2 * i], mm[2 * i + 1])));
        let corners = core::array::from_fn(|j| self.corner((j + 2) % POINTS, j, &arms, mm));
        let [c31, c12, c23] = &corners;
        for _ in 0..MAX_STEPS {
            let [a1, a2, a3] = &arms;
            let (r1, r2, r3) = (&c12.row(a1, a2), &c23.row(a2, a3), &c31.row(a3, a1));
            let (determinant, steps) = newton(r1, r2, r3);
            let ([a1, a2, a3], [s1, s2, s3]) = (&mut arms, steps);
            a1.turn(s1);
            a2.turn(s2);
            a3.turn(s3);
            let tolerance = self.tolerance_mm2;
            if r1.value.abs() < tolerance && r2.value.abs() < tolerance && r3.value.abs() < tolerance {
                // Judged where the equations hold: on the home side the determinant is positive.
                let least = r1.slope_squared() * r2.slope_squared() * r3.slope_squared() * T::of(REGULAR * REGULAR);
                if determinant > T::zero() && determinant * determinant > least {
                    return Ok(self.pose(&arms));
                }
                break;
            }
        }
        // A triangle that does not close has no height, and no equation holds. Also false for NaN.
        let broken = arms.iter().position(|arm| !(arm.length > T::zero()));
        Err(broken.map_or(PlatformError::DoesNotClose, |i| PlatformError::Length(LengthError::broken_triangle(i))))
    }

    /// The corner at which hinge `i` ends and hinge `j` begins.
    fn corner(&self, i: usize, j: usize, arms: &[HingeArm<T>; POINTS], mm: &[T; CABLES]) -> Corner<T> {
        let (edges, half) = (self.base.as_array(), T::of(0.5));
        let ([c1, s1], [c2, s2]) = (edges[i].direction, edges[j].direction);
        let (cos, sin) = (c1 * c2 + s1 * s2, c1 * s2 - s1 * c2);
        let (short, beyond) = (edges[i].length_mm - arms[i].along, arms[j].along);
        let (l1, l2, edge) = (mm[2 * i + 1], mm[2 * j], self.edges_mm[i]);
        let constant = ((l1 - edge) * (l1 + edge) + l2 * l2) * half + short * beyond * cos;
        Corner { constant, first: sin * beyond, second: sin * short, cos }
    }

    /// Pose of the platform from its end-points, which keep their distances.
    fn pose(&self, arms: &[HingeArm<T>; POINTS]) -> PlatformPose<T> {
        let (base, side) = (&self.base, self.base.side);
        // In {B}, from B1.
        let [p1, p2, p3] = &core::array::from_fn(|i| {
            let (edge, arm) = (&base.as_array()[i], &arms[i]);
            let ([x, y], [cos, sin]) = (edge.origin_mm, edge.direction);
            let (x, y) = (x + cos * arm.along + sin * arm.out, y + sin * arm.along - cos * arm.out);
            base.axes * Vector3::new(x, y, arm.up)
        });
        // P3 has a negative y in {P} where the base is numbered clockwise.
        let rotation = triad(&(p2 - p1), &((p3 - p1) * side));
        PlatformPose { origin_mm: base.origin_mm + p1, rotation }
    }
}

impl<T: Real> HingeArm<T> {
    fn at_start(hinge: &HingeCoordinates<T>) -> Self {
        let length = hinge.distance_squared_mm2.root();
        Self { along: hinge.along_mm, length, out: length * T::of(START.0), up: length * T::of(START.1) }
    }

    /// Turns the arm by atan(`step`), which no step takes past 90 degrees.
    fn turn(&mut self, step: T) {
        let out = self.out - self.up * step;
        let up = self.up + self.out * step;
        let scale = self.length / (out * out + up * up).root();
        (self.out, self.up) = (out * scale, up * scale);
    }
}

impl<T: Real> Corner<T> {
    /// The equation of the platform edge between the arms of hinges i and j.
    fn row(&self, i: &HingeArm<T>, j: &HingeArm<T>) -> Row<T> {
        let (first, second) = (self.first - self.cos * j.out, self.second - self.cos * i.out);
        Row {
            value: self.constant + i.out * first + j.out * self.second - i.up * j.up,
            first: i.up * first + i.out * j.up,
            second: j.up * second + j.out * i.up,
        }
    }
}

impl<T: Real> Row<T> {
    /// Squared length of the row: the product of the three is what their determinant is compared with.
    fn slope_squared(&self) -> T {
        self.first * self.first + self.second * self.second
    }
}

/// Determinant of the system and Newton's step of the angles of P1, P2, P3, in which it is [f0 s0 0; 0 f1 s1; s2 0 f2].
fn newton<T: Real>(r1: &Row<T>, r2: &Row<T>, r3: &Row<T>) -> (T, [T; POINTS]) {
    let (ff, ss) = (r1.first * r2.first, r1.second * r2.second);
    // The first two rows without the angle of P2: ff x1 - ss x3 = value.
    let value = r1.value * r2.first - r1.second * r2.value;
    let determinant = ff * r3.first + ss * r3.second;
    let inverse = T::one() / determinant;
    let second = r2.value * r3.first * r1.first + r2.second * (r3.second * r1.value - r3.value * r1.first);
    let steps =
        [(value * r3.first + ss * r3.value) * inverse, second * inverse, (ff * r3.value - value * r3.second) * inverse];
    (determinant, steps)
}
