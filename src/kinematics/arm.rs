//! The arm's rotation from the cable lengths, once the joint centre is known.
//!
//! Six lengths for three angles: one cable may be missing. Position control needs it, and it places a pose that the
//! octahedron cannot place (beyond its fold, or with a bad length).

use super::cable_length::CableLengths;
use super::hinge::BaseEdges;
use super::pivot::{LengthEquation, LengthEquations, Pivot, RigPoints, inverse_of_symmetric};
use super::tetrahedron::TetrahedronBase;
use crate::rig::CABLES;
use crate::scalar::Real;
use crate::vector::{add_to, cross, difference, dot, image, product, scaled, square, unit};
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
    /// The rig's base edges.
    pub base: &'a BaseEdges<T>,
    /// The joint centre in both bodies.
    pub pivot: &'a Pivot<T>,
}

impl<T: Real> Arm<'_, T> {
    /// Best rotation for the cables in `cables` from a start nearby: for tracking, the rotation of the sample before.
    ///
    /// `None` when the iteration meets a singular arrangement or does not settle.
    pub fn fit_from(&self, start: UnitQuaternion<T>, lengths: &CableLengths<T>, cables: CableSet) -> Option<Fit<T>> {
        let mut attitude = start;
        let mut equations = LengthEquations::empty();
        // Single precision: 3e-4 rad. The error after a turn is about its square.
        let settled = T::default_epsilon();
        for _ in 0..STEP_CAP {
            equations.set(self.points, self.pivot, &rotation_of(&attitude), lengths);
            let [mut xx, mut yx, mut yy, mut zx, mut zy, mut zz] = [T::zero(); 6];
            let mut torque = Vector3::new(T::zero(), T::zero(), T::zero());
            let mut squares_mm2 = T::zero();
            for (cable, LengthEquation { moment_mm: g, residual_mm: e, .. }) in equations.cables.iter().enumerate() {
                if cables.has(cable) {
                    xx += g.x * g.x;
                    yx += g.y * g.x;
                    yy += g.y * g.y;
                    zx += g.z * g.x;
                    zy += g.z * g.y;
                    zz += g.z * g.z;
                    add_to(&mut torque, &scaled(g, *e));
                    squares_mm2 += *e * *e;
                }
            }
            let turning = Matrix3::new(xx, yx, zx, yx, yy, zy, zx, zy, zz);
            let turn = image(&inverse_of_symmetric(&turning)?, &torque);
            attitude = turned(&attitude, &turn);
            if square(&turn) <= settled {
                // What the turn has gained is taken off without another evaluation.
                let squares_mm2 = (squares_mm2 - dot(&torque, &turn)).max(T::zero());
                return Some(Fit { attitude, squares_mm2 });
            }
        }
        None
    }

    /// Best rotation with no start: end-points from the tetrahedra at the known centre, with either sign of the apex.
    /// `cables` may lack one cable; the two end-points without it serve then.
    pub fn fit(&self, lengths: &CableLengths<T>, cables: CableSet) -> Option<Fit<T>> {
        let radii = self.pivot.parameters(self.points).radii_mm;
        let whole = |i: usize| cables.has(2 * i) && cables.has(2 * i + 1);
        // Two end-points with both cables sound fix the rotation.
        let (i, j) = if !whole(0) {
            (1, 2)
        } else if !whole(1) {
            (2, 0)
        } else {
            (0, 1)
        };
        let first = self.apices(i, radii[i], lengths)?;
        let second = self.apices(j, radii[j], lengths)?;
        let body = (self.points.platform_mm[i], self.points.platform_mm[j]);
        let [u, v] = [&body.0, &body.1].map(|s| difference(s, &self.pivot.in_platform_mm));
        let body = triad(&u, &v).transpose();
        let mut best: Option<Fit<T>> = None;
        for a in &first {
            for b in &second {
                let rotation = product(&triad(a, b), &body);
                let start = nearest_attitude(&rotation);
                let Some(fit) = self.fit_from(start, lengths, cables) else { continue };
                if best.is_none_or(|best| fit.squares_mm2 < best.squares_mm2) {
                    best = Some(fit);
                }
            }
        }
        best
    }

    /// Both apices of the tetrahedron of end-point `i`, from O. A tetrahedron that does not quite close gives its flat
    /// apex twice: a start to iterate from.
    fn apices(&self, i: usize, radius_mm: T, lengths: &CableLengths<T>) -> Option<[Vector3<T>; 2]> {
        let mm = lengths.as_mm();
        let (Some(edge), Some(&first), Some(&second)) = (self.base.as_array().get(i), mm.get(2 * i), mm.get(2 * i + 1))
        else {
            return None;
        };
        let hinge = edge.coordinates(first, second);
        let tetrahedron = TetrahedronBase::new(edge, &self.base.in_plane(&self.pivot.in_base_mm), radius_mm);
        let foot = tetrahedron.foot_anyhow(&hinge);
        let height_mm = foot.height_squared_mm2.max(T::zero()).root();
        let apex = |height_mm: T| self.base.in_base(&tetrahedron.apex(&foot, height_mm));
        // Refuses a broken triangle, and a centre on the edge's line.
        let closes = hinge.distance_squared_mm2 > T::zero() && foot.depth_mm.is_a_number();
        closes.then(|| [apex(height_mm), apex(-height_mm)])
    }
}

/// `attitude` turned by the small rotation vector `turn` (rad, axes of {B}), to second order and normalised.
pub fn turned<T: Real>(attitude: &UnitQuaternion<T>, turn: &Vector3<T>) -> UnitQuaternion<T> {
    let [x, y, z, w]: [T; 4] = attitude.coords.into();
    let half = T::of(0.5);
    let (a, b, c) = (turn.x * half, turn.y * half, turn.z * half);
    normalised([
        w - a * x - b * y - c * z,
        x + a * w + b * z - c * y,
        y + b * w + c * x - a * z,
        z + c * w + a * y - b * x,
    ])
}

/// The unit quaternion along w, x, y, z.
#[inline(always)]
pub(crate) fn normalised<T: Real>([w, x, y, z]: [T; 4]) -> UnitQuaternion<T> {
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

/// The attitude of a rotation matrix whose columns are orthonormal up to rounding: the largest of the four components
/// first (Shepperd 1978), so that nothing is divided by a small number.
#[inline(never)]
pub fn nearest_attitude<T: Real>(m: &Matrix3<T>) -> UnitQuaternion<T> {
    let one = T::one();
    let (w, x, y, z) = (
        one + m.m11 + m.m22 + m.m33,
        one + m.m11 - m.m22 - m.m33,
        one - m.m11 + m.m22 - m.m33,
        one - m.m11 - m.m22 + m.m33,
    );
    let (a, b, c) = (m.m32 - m.m23, m.m13 - m.m31, m.m21 - m.m12);
    let (d, e, f) = (m.m32 + m.m23, m.m13 + m.m31, m.m21 + m.m12);
    normalised(if w >= x && w >= y && w >= z {
        [w, a, b, c]
    } else if x >= y && x >= z {
        [a, x, f, e]
    } else if y >= z {
        [b, f, y, d]
    } else {
        [c, e, d, z]
    })
}

/// Orthonormal axes from two vectors as columns: x along the first, z along their cross product. Not finite when they
/// are parallel.
#[inline(never)]
pub(super) fn triad<T: Real>(first: &Vector3<T>, second: &Vector3<T>) -> Matrix3<T> {
    let x = unit(first);
    let z = unit(&cross(first, second));
    let y = cross(&z, &x);
    Matrix3::new(x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z)
}
