//! The arm's rotation from the cable lengths, once the joint centre is known.
//!
//! Six lengths for three angles: one cable may be missing. Position control needs it, and it places a pose that the
//! octahedron cannot place (beyond its fold, or with a bad length).

use super::cable_length::CableLengths;
use super::hinge::{BaseEdges, HingeCoordinates};
use super::pivot::{LengthEquations, Pivot, RigPoints, inverse_of_symmetric};
use crate::rig::CABLES;
use crate::scalar::Real;
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
        // Single precision: 3e-4 rad. The error after a turn is about its square.
        let settled = T::default_epsilon();
        for _ in 0..STEP_CAP {
            let rotation = attitude.to_rotation_matrix();
            let equations = LengthEquations::new(self.points, self.pivot, rotation.matrix(), lengths);
            let mut turning = Matrix3::zeros();
            let mut torque = Vector3::zeros();
            let mut squares_mm2 = T::zero();
            for cable in (0..CABLES).filter(|cable| cables.has(*cable)) {
                let (g, e) = (equations.moment_mm[cable], equations.residual_mm[cable]);
                turning += g * g.transpose();
                torque += g * e;
                squares_mm2 += e * e;
            }
            let turn = inverse_of_symmetric(&turning)? * torque;
            attitude = turned(&attitude, &turn);
            if turn.norm_squared() <= settled {
                // What the turn has gained is taken off without another evaluation.
                let squares_mm2 = (squares_mm2 - torque.dot(&turn)).max(T::zero());
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
        let body = triad(&(body.0 - self.pivot.in_platform_mm), &(body.1 - self.pivot.in_platform_mm))?;
        let mut best: Option<Fit<T>> = None;
        for a in &first {
            for b in &second {
                let Some(space) = triad(a, b) else { continue };
                let start = nearest_attitude(&(space * body.transpose()));
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
        let edge = &self.base.as_array()[i];
        let HingeCoordinates { along_mm, distance_squared_mm2 } = edge.coordinates(mm[2 * i], mm[2 * i + 1]);
        let centre = self.base.in_plane(&self.pivot.in_base_mm);
        let origin = Vector3::new(edge.origin_mm[0], edge.origin_mm[1], T::zero());
        let along = Vector3::new(edge.direction[0], edge.direction[1], T::zero());
        let from_origin = centre - origin;
        let inner = along * from_origin.dot(&along) - from_origin;
        let distance_mm = inner.norm_squared().root();
        if !(distance_mm > T::zero() && distance_squared_mm2 > T::zero()) {
            return None;
        }
        let inner = inner / distance_mm;
        let x = along_mm - from_origin.dot(&along);
        let d = (distance_mm * distance_mm - radius_mm * radius_mm + distance_squared_mm2 + x * x)
            / (distance_mm + distance_mm);
        let height = (distance_squared_mm2 - d * d).max(T::zero()).root();
        let flat = along * x + inner * (distance_mm - d);
        let normal = along.cross(&inner) * height;
        Some([self.base.in_base(&(flat + normal)), self.base.in_base(&(flat - normal))])
    }
}

/// `attitude` turned by the small rotation vector `turn` (rad, axes of {B}), to second order and normalised.
pub fn turned<T: Real>(attitude: &UnitQuaternion<T>, turn: &Vector3<T>) -> UnitQuaternion<T> {
    let small = Quaternion::from_parts(T::one(), turn * T::of(0.5));
    UnitQuaternion::new_normalize(small * attitude.quaternion())
}

/// The attitude of a rotation matrix whose columns are orthonormal up to rounding.
pub fn nearest_attitude<T: Real>(matrix: &Matrix3<T>) -> UnitQuaternion<T> {
    let rotation = nalgebra::Rotation3::from_matrix_unchecked(*matrix);
    UnitQuaternion::new_normalize(UnitQuaternion::from_rotation_matrix(&rotation).into_inner())
}

/// Orthonormal axes from two vectors, or `None` when they are parallel.
fn triad<T: Real>(first: &Vector3<T>, second: &Vector3<T>) -> Option<Matrix3<T>> {
    let normal = first.cross(second);
    let (length, height) = (first.norm_squared().root(), normal.norm_squared().root());
    if !(length > T::zero() && height > T::zero()) {
        return None;
    }
    let (x, z) = (first / length, normal / height);
    Some(Matrix3::from_columns(&[x, z.cross(&x), z]))
}
