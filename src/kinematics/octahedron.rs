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

use super::cable_length::{CableLengths, LengthError};
use super::hinge::{BaseEdges, HingeArm, HingeCoordinates};
use crate::calls::triad;
use crate::rig::{POINTS, Rig};
use crate::scalar::Real;
use crate::vector::{difference, scaled};
use nalgebra::{Matrix3, Vector3};

/// Newton steps after which a pose is given up. A regular pose takes about five.
const STEP_CAP: usize = 20;

/// Angle of every hinge from the base plane at which Newton's method begins: 78 degrees (cosine, sine). No pose up
/// to 45 degrees of tilt and 30 degrees of torsion was lost from 60 to 80 degrees; the steps are fewer than from 75 or less.
const START: (f64, f64) = (0.207_911_690_817_759_45, 0.978_147_600_733_805_6);

/// Smallest determinant of the normalised system at which an assembly counts as regular. Closer to the fold the
/// lengths determine the pose too poorly to find a start from it.
const REGULAR: f64 = 0.02;

/// A platform edge P_i P_j spans a corner of the base: hinge j begins where hinge i ends, turned by an angle γ. Seen
/// along hinge i, its outward axis and upward, P_i - P_j is
/// (-along - sin γ out_j, out_i - cos γ out_j + across, up_i - up_j).
#[derive(Clone, Copy, Debug, PartialEq)]
struct Corner<T> {
    /// cos γ and sin γ.
    cos: T,
    sin: T,
    /// p_ij², mm².
    square: T,
    /// From the foot of P_i to the foot of P_j on their hinges: along hinge i and inwards, mm.
    /// 0 until the arms are known.
    along: T,
    across: T,
}

/// The equation of a platform edge at one estimate.
#[derive(Clone, Copy, Debug)]
struct Row<T> {
    /// |P_i - P_j|² - p_ij², mm².
    value: T,
    /// Half of its derivatives with the angles of hinges i and j, mm².
    first: T,
    second: T,
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
    /// Of the platform edges p12, p23, p31.
    corners: [Corner<T>; POINTS],
    /// Largest error of a squared edge at which Newton's method ends, mm².
    close_mm2: T,
    /// 1, or -1 when P3 has a negative y in {P}.
    side: T,
}

impl<T: Real> Octahedron<T> {
    /// The octahedron of `rig`.
    pub fn new(rig: &Rig<T>) -> Self {
        let third = rig.platform_mm()[2];
        let (base, edges_mm) = (BaseEdges::new(rig), rig.edges_mm());
        let edges = base.as_array();
        let corner = |i: usize, j: usize| {
            let ([c1, s1], [c2, s2]) = (edges[i].direction, edges[j].direction);
            let (cos, sin, square) = (c1 * c2 + s1 * s2, c1 * s2 - s1 * c2, edges_mm[i] * edges_mm[i]);
            Corner { cos, sin, square, along: T::zero(), across: T::zero() }
        };
        Self {
            // As in `EDGE_ENDS`.
            corners: [corner(0, 1), corner(1, 2), corner(2, 0)],
            // Half the digits: the step that follows has them all.
            close_mm2: edges_mm[0] * edges_mm[0] * T::default_epsilon().root(),
            base,
            side: if third.y > T::zero() { T::one() } else { -T::one() },
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
        let mut arms = self.arms(lengths);
        // Also false for NaN: a triangle that does not close has no height.
        if let Some(broken) = arms.iter().position(|arm| !(arm.length > T::zero() && arm.length < T::of(1e15))) {
            return Err(OctahedronError::Length(LengthError::broken_triangle(broken)));
        }
        let [c12, c23, c31] = self.corners(&arms);
        let close = self.close_mm2;
        let [a1, a2, a3] = &mut arms;
        for _ in 0..STEP_CAP {
            let (r1, r2, r3) = (&c12.row(a1, a2), &c23.row(a2, a3), &c31.row(a3, a1));
            let (determinant, [s1, s2, s3]) = newton(r1, r2, r3);
            // In words: as a loop they would leave the registers, a tenth of the time.
            a1.turn(s1);
            a2.turn(s2);
            a3.turn(s3);
            if r1.value.abs() < close && r2.value.abs() < close && r3.value.abs() < close {
                // Judged where the equations hold: on the home side the determinant is negative.
                if -determinant > r1.slope() * r2.slope() * r3.slope() * T::of(REGULAR) {
                    return Ok(self.pose(&arms));
                }
                break;
            }
        }
        Err(OctahedronError::DoesNotClose)
    }

    #[inline(always)]
    fn arms(&self, lengths: &CableLengths<T>) -> [HingeArm<T>; POINTS] {
        let mm = lengths.as_mm();
        core::array::from_fn(|i| HingeArm::at_start(&self.base.as_array()[i].coordinates(mm[2 * i], mm[2 * i + 1])))
    }

    #[inline(always)]
    fn corners(&self, arms: &[HingeArm<T>; POINTS]) -> [Corner<T>; POINTS] {
        let corner = |i: usize, j: usize| {
            let corner = self.corners[i];
            let (short, beyond) = (self.base.as_array()[i].length_mm - arms[i].along, arms[j].along);
            Corner { along: short + corner.cos * beyond, across: corner.sin * beyond, ..corner }
        };
        [corner(0, 1), corner(1, 2), corner(2, 0)]
    }

    /// Pose of the platform from its end-points, which keep their distances.
    #[inline(always)]
    fn pose(&self, arms: &[HingeArm<T>; POINTS]) -> PlatformPose<T> {
        let [p1, p2, p3] = core::array::from_fn(|i| self.base.end_point(i, &arms[i]));
        let rotation = triad(&difference(&p2, &p1), &scaled(&difference(&p3, &p1), self.side));
        PlatformPose { origin_mm: p1, rotation }
    }
}

impl<T: Real> HingeArm<T> {
    #[inline(always)]
    fn at_start(hinge: &HingeCoordinates<T>) -> Self {
        let length = hinge.distance_squared_mm2.root();
        Self { along: hinge.along_mm, length, out: length * T::of(START.0), up: length * T::of(START.1) }
    }

    /// Turns the arm by atan(`step`), which no step takes past 90 degrees.
    #[inline(always)]
    fn turn(&mut self, step: T) {
        let out = self.out - self.up * step;
        let up = self.up + self.out * step;
        let scale = self.length / (out * out + up * up).root();
        (self.out, self.up) = (out * scale, up * scale);
    }
}

impl<T: Real> Corner<T> {
    /// The equation of the platform edge between the arms of hinges i and j.
    #[inline(always)]
    fn row(&self, i: &HingeArm<T>, j: &HingeArm<T>) -> Row<T> {
        let (along, out, up) = (self.along + self.sin * j.out, i.out - self.cos * j.out + self.across, i.up - j.up);
        Row {
            value: along * along + out * out + up * up - self.square,
            first: i.out * up - i.up * out,
            second: j.up * (self.cos * out - self.sin * along) - j.out * up,
        }
    }
}

impl<T: Real> Row<T> {
    /// Length of the row: the product of the three is what their determinant is compared with.
    #[inline(always)]
    fn slope(&self) -> T {
        (self.first * self.first + self.second * self.second).root()
    }
}

/// Determinant of the system and Newton's step of the angles of P1, P2, P3, in which it is [f0 s0 0; 0 f1 s1; s2 0 f2].
#[inline(always)]
fn newton<T: Real>(r1: &Row<T>, r2: &Row<T>, r3: &Row<T>) -> (T, [T; POINTS]) {
    let (ff, ss) = (r1.first * r2.first, r1.second * r2.second);
    // The first two rows without the angle of P2: ff x1 - ss x3 = -value.
    let value = r1.value * r2.first - r1.second * r2.value;
    let determinant = ff * r3.first + ss * r3.second;
    let minus_inverse = T::of(-0.5) / determinant;
    let second = r2.value * r3.first * r1.first + r2.second * (r3.second * r1.value - r3.value * r1.first);
    let steps = [
        (value * r3.first + ss * r3.value) * minus_inverse,
        second * minus_inverse,
        (ff * r3.value - value * r3.second) * minus_inverse,
    ];
    (determinant, steps)
}
