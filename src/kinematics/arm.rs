//! The arm's rotation from the cable lengths, once the joint centre is known.
//!
//! Six lengths for three angles: one cable may be missing. Position control needs it, and it places a pose that the
//! octahedron cannot place (beyond its fold, or with a bad length).

use super::cable_length::CableLengths;
use super::pivot::{LengthEquation, LengthEquations, Pivot, RigPoints};
use super::spheres::spheres_meet;
use crate::calls::{difference, dot, product, root, transposed, triad};
use crate::rig::{CABLES, POINTS};
use crate::scalar::Real;
use crate::symmetric::{Symmetric, rounding};
use crate::vector::{add_to, scaled};
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

/// Gauss-Newton steps after which a start is given up.
const STEP_CAP: usize = 12;

/// Which cables take part: bit k is cable k + 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CableSet(u8);

impl CableSet {
    /// All six cables.
    pub const ALL: Self = Self((1 << CABLES) - 1);

    /// All but the cable with this index, from 0.
    pub const fn all_but(index: usize) -> Self {
        Self(Self::ALL.0 & !(1 << index))
    }

    /// Does the cable with this index, from 0, take part?
    pub const fn has(self, index: usize) -> bool {
        self.0 & (1 << index) != 0
    }
}

/// A rotation of the platform that fits the lengths.
#[derive(Clone, Copy, Debug)]
pub struct Fit<T> {
    /// Rotation from {P} to {B}.
    pub attitude: UnitQuaternion<T>,
    /// Sum of the squared length residuals of the cables that take part, mm².
    pub squares_mm2: T,
}

/// Everything about a rig and a pivot that fitting a rotation needs.
#[derive(Clone, Copy, Debug)]
pub struct Arm<'a, T> {
    /// The rig's points.
    pub points: &'a RigPoints<T>,
    /// The joint centre in both bodies.
    pub pivot: &'a Pivot<T>,
}

impl<T: Real> Arm<'_, T> {
    /// Best rotation for the cables in `cables` from a start nearby: for tracking, the rotation of the sample before.
    ///
    /// `None` when the iteration meets a singular arrangement or does not settle.
    #[cfg_attr(feature = "ccm", inline(never), unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
    pub fn fit_from(&self, start: UnitQuaternion<T>, lengths: &CableLengths<T>, cables: CableSet) -> Option<Fit<T>> {
        let mut attitude = start;
        let mut equations = LengthEquations::empty();
        // Single precision: 3e-4 rad. The error after a turn is about its square.
        let settled = T::default_epsilon();
        for _ in 0..STEP_CAP {
            equations.set(self.points, self.pivot, &rotation_of(&attitude), lengths);
            let mut turning = Symmetric::zero();
            let mut torque = Vector3::new(T::zero(), T::zero(), T::zero());
            let mut squares_mm2 = T::zero();
            for (cable, LengthEquation { moment_mm: g, residual_mm: e, .. }) in equations.cables.iter().enumerate() {
                if cables.has(cable) {
                    turning.add_square(g);
                    add_to(&mut torque, &scaled(g, *e));
                    squares_mm2 += *e * *e;
                }
            }
            let information = turning;
            if !turning.invert(&information, rounding()) {
                break;
            }
            let turn = turning.image(&torque);
            turn_by(&mut attitude, &turn);
            if dot(&turn, &turn) <= settled {
                // What the turn has gained is taken off without another evaluation.
                let left = squares_mm2 - dot(&torque, &turn);
                return Some(Fit { attitude, squares_mm2: if left > T::zero() { left } else { T::zero() } });
            }
        }
        None
    }

    /// Best rotation with no start: end-points from the tetrahedra at the known centre, with either sign of the apex.
    /// `cables` may lack one cable; the two end-points without it serve then.
    pub fn fit(&self, lengths: &CableLengths<T>, cables: CableSet) -> Option<Fit<T>> {
        let whole = |i: usize| cables.has(2 * i) && cables.has(2 * i + 1);
        // Two end-points with both cables sound fix the rotation.
        let (i, j) = (if whole(0) { 0 } else { 1 }, if whole(2) { 2 } else { 1 });
        let from_centre = |k: usize| difference(&self.points.platform_mm[k], &self.pivot.in_platform_mm);
        let body = transposed(&triad(&from_centre(i), &from_centre(j)));
        let mut best: Option<Fit<T>> = None;
        // One bit for each end-point.
        for sides in 0..4 {
            let side = |bit: u8| if sides & bit == 0 { T::one() } else { -T::one() };
            let ends = triad(&self.apex(i, lengths, side(1)), &self.apex(j, lengths, side(2)));
            let start = nearest_attitude(&product(&ends, &body));
            if let Some(fit) = self.fit_from(start, lengths, cables)
                && best.is_none_or(|best| fit.squares_mm2 < best.squares_mm2)
            {
                best = Some(fit);
            }
        }
        best
    }

    /// End-point `i` from O, on one `side` (1 or -1) of the plane through O and its base edge: where the spheres that its
    /// two cables and its radius allow meet. When they do not quite meet, a point near: a start to iterate from. Not
    /// finite with O on the edge's line.
    #[inline(never)]
    fn apex(&self, i: usize, lengths: &CableLengths<T>, side: T) -> Vector3<T> {
        let (base_mm, mm) = (&self.points.base_mm, lengths.as_mm());
        let radius = difference(&self.points.platform_mm[i], &self.pivot.in_platform_mm);
        // As in `ATTACHMENTS`.
        let centres = [&self.pivot.in_base_mm, &base_mm[i], &base_mm[(i + 1) % POINTS]];
        spheres_meet(centres, &[root(dot(&radius, &radius)), mm[2 * i], mm[2 * i + 1]], side)
    }
}

/// `attitude` turned by the small rotation vector `turn` (rad, axes of {B}), to second order and normalised.
pub fn turned<T: Real>(attitude: &UnitQuaternion<T>, turn: &Vector3<T>) -> UnitQuaternion<T> {
    let mut turned = *attitude;
    turn_by(&mut turned, turn);
    turned
}

/// [`turned`] in place.
#[inline(never)]
pub(crate) fn turn_by<T: Real>(attitude: &mut UnitQuaternion<T>, turn: &Vector3<T>) {
    let [x, y, z, w]: [T; 4] = attitude.coords.into();
    let half = T::of(0.5);
    let (a, b, c) = (turn.x * half, turn.y * half, turn.z * half);
    *attitude = normalised(
        w - a * x - b * y - c * z,
        x + a * w + b * z - c * y,
        y + b * w + c * x - a * z,
        z + c * w + a * y - b * x,
    );
}

/// The unit quaternion along w, x, y, z.
#[inline(never)]
pub(crate) fn normalised<T: Real>(w: T, x: T, y: T, z: T) -> UnitQuaternion<T> {
    let scale = T::one() / (w * w + x * x + y * y + z * z).root();
    UnitQuaternion::new_unchecked(Quaternion::new(w * scale, x * scale, y * scale, z * scale))
}

/// The rotation matrix of an attitude.
// nalgebra's own is the same formula in four times the instructions, where the compiler keeps code small.
#[inline(never)]
pub fn rotation_of<T: Real>(attitude: &UnitQuaternion<T>) -> Matrix3<T> {
    let [x, y, z, w]: [T; 4] = attitude.coords.into();
    let (x2, y2, z2) = (x + x, y + y, z + z);
    let (xx, yy, zz) = (x * x2, y * y2, z * z2);
    let (xy, xz, yz) = (x * y2, x * z2, y * z2);
    let (wx, wy, wz) = (w * x2, w * y2, w * z2);
    let one = T::one();
    Matrix3::new(one - yy - zz, xy - wz, xz + wy, xy + wz, one - xx - zz, yz - wx, xz - wy, yz + wx, one - xx - yy)
}

/// The attitude of a rotation matrix whose columns are orthonormal up to rounding: by one of the four components that
/// is not small (after Shepperd 1978), so that nothing is divided by a small number.
#[inline(never)]
pub fn nearest_attitude<T: Real>(m: &Matrix3<T>) -> UnitQuaternion<T> {
    let one = T::one();
    let (more, less, sum, difference) = (one + m.m11, one - m.m11, m.m22 + m.m33, m.m22 - m.m33);
    let (w, x, y, z) = (more + sum, more - sum, less + difference, less - difference);
    let (a, b, c) = (m.m32 - m.m23, m.m13 - m.m31, m.m21 - m.m12);
    let (d, e, f) = (m.m32 + m.m23, m.m13 + m.m31, m.m21 + m.m12);
    // A quarter of their sum, 4, is large enough.
    if w >= one {
        normalised(w, a, b, c)
    } else if x >= one {
        normalised(a, x, f, e)
    } else if y >= one {
        normalised(b, f, y, d)
    } else {
        normalised(c, e, d, z)
    }
}
