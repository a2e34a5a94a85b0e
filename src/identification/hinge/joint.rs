//! A hinge between two bodies: its axis in both, and where they stand against each other along it.
//!
//! A point p of the platform stands at x = c + h a + Rot(a, θ) R₀ (p − q): a and c are the axis' direction and foot point
//! in the base, d = R₀ᵀa and q the same in the platform, h the offset along the axis, θ the angle. Of twelve numbers nine
//! are observable: a body that slides or turns along its axis describes the same hinge, and so does another zero of θ.

use crate::kinematics::rotation::{rotation_of, turned};
use crate::linear_algebra::unit;
use crate::scalar::Real;
use nalgebra::{Matrix3, Quaternion, SMatrix, UnitQuaternion, Vector3};

/// Unknowns of a hinge, in this order: direction of the axis in the base (2, rad), its foot point (2, mm), the same in
/// the platform (4), offset along the axis (1, mm). Two-component ones are along [`across`] of the axis.
pub const HINGE_UNKNOWNS: usize = 9;

/// Where the unknowns begin.
pub(super) const AXIS: usize = 0;
pub(super) const FOOT: usize = 2;
pub(super) const AXIS_IN_PLATFORM: usize = 4;
pub(super) const FOOT_IN_PLATFORM: usize = 6;
pub(super) const ALONG: usize = 8;

/// Is unknown `k` a direction, in rad? The others are places, in mm.
pub const fn is_direction(k: usize) -> bool {
    matches!(k, 0 | 1 | 4 | 5)
}

/// A hinge. The foot point of an axis is its point nearest to the origin of the body's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hinge<T: Real> {
    axis: Vector3<T>,
    foot_mm: Vector3<T>,
    /// Platform to base at angle zero; turns the axis in the platform into that in the base.
    attitude: UnitQuaternion<T>,
    foot_in_platform_mm: Vector3<T>,
    along_mm: T,
}

/// What follows from a hinge alone, whatever the pose.
pub(super) struct Frame<T: Real> {
    /// Rotation of the platform ({P} to {B}) at angle zero.
    pub at_zero: Matrix3<T>,
    axis_in_platform: Vector3<T>,
    across: [Vector3<T>; 2],
    across_in_platform: [Vector3<T>; 2],
}

/// Two unit vectors across an axis, and across each other.
pub fn across<T: Real>(axis: &Vector3<T>) -> [Vector3<T>; 2] {
    let other = if axis.x.abs() < T::of(0.7) { Vector3::x() } else { Vector3::y() };
    let first = unit(&(other - axis * axis.dot(&other)));
    [first, axis.cross(&first)]
}

impl<T: Real> Hinge<T> {
    /// The hinge with these axes, of any length but zero, whose two points (mm) coincide. At angle zero the platform has the
    /// smallest rotation that brings its axis onto the base's.
    pub fn through(
        axis: &Vector3<T>,
        point_mm: &Vector3<T>,
        axis_in_platform: &Vector3<T>,
        point_in_platform_mm: &Vector3<T>,
    ) -> Self {
        let (a, d) = (unit(axis), unit(axis_in_platform));
        let (along_base, along_platform) = (a.dot(point_mm), d.dot(point_in_platform_mm));
        Self {
            axis: a,
            foot_mm: point_mm - a * along_base,
            attitude: smallest_rotation(&d, &a),
            foot_in_platform_mm: point_in_platform_mm - d * along_platform,
            along_mm: along_base - along_platform,
        }
    }

    /// All its numbers: axis and foot point in the base, attitude at angle zero (x, y, z, w), foot point in the platform,
    /// offset along the axis.
    pub fn to_array(&self) -> [T; 14] {
        let [[ax, ay, az], [cx, cy, cz]] = [self.axis, self.foot_mm].map(Into::into);
        let [x, y, z, w]: [T; 4] = self.attitude.coords.into();
        let [qx, qy, qz] = self.foot_in_platform_mm.into();
        [ax, ay, az, cx, cy, cz, x, y, z, w, qx, qy, qz, self.along_mm]
    }

    /// From the numbers of [`to_array`](Self::to_array), to the bit; what they are is not looked at.
    pub fn from_array([ax, ay, az, cx, cy, cz, x, y, z, w, qx, qy, qz, along_mm]: [T; 14]) -> Self {
        Self {
            axis: Vector3::new(ax, ay, az),
            foot_mm: Vector3::new(cx, cy, cz),
            attitude: UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z)),
            foot_in_platform_mm: Vector3::new(qx, qy, qz),
            along_mm,
        }
    }

    /// Are its numbers those of a hinge: finite, directions of length one?
    pub fn is_sound(&self) -> bool {
        let is_one = |squares: T| (squares - T::one()).abs() < T::of(1e-3);
        let are_numbers = self.to_array().iter().all(|number| number.is_a_number());
        are_numbers && is_one(self.axis.norm_squared()) && is_one(self.attitude.coords.norm_squared())
    }

    /// Direction of the axis in the base, a unit vector.
    pub fn axis(&self) -> &Vector3<T> {
        &self.axis
    }

    /// Foot point of the axis in the base, mm.
    pub fn foot_mm(&self) -> &Vector3<T> {
        &self.foot_mm
    }

    /// Direction of the axis in the platform, a unit vector.
    pub fn axis_in_platform(&self) -> Vector3<T> {
        self.rotation_at_zero().tr_mul(&self.axis)
    }

    /// Foot point of the axis in the platform, mm.
    pub fn foot_in_platform_mm(&self) -> &Vector3<T> {
        &self.foot_in_platform_mm
    }

    /// How far the platform's foot point stands from the base's along the axis, mm.
    pub fn along_mm(&self) -> T {
        self.along_mm
    }

    /// Rotation of the platform ({P} to {B}) at angle zero.
    pub fn rotation_at_zero(&self) -> Matrix3<T> {
        rotation_of(&self.attitude)
    }

    /// Rotation of the platform ({P} to {B}) at an angle, rad.
    pub fn rotation(&self, angle_rad: T) -> Matrix3<T> {
        about(&self.axis, angle_rad) * self.rotation_at_zero()
    }

    /// The same as a quaternion.
    pub fn attitude(&self, angle_rad: T) -> UnitQuaternion<T> {
        turned(&self.attitude, &(self.axis * angle_rad))
    }

    /// Where the platform's foot point stands in the base, mm.
    pub fn platform_foot_mm(&self) -> Vector3<T> {
        self.foot_mm + self.axis * self.along_mm
    }

    /// The axis' point in the base nearest to `point_mm`, mm.
    pub fn nearest_mm(&self, point_mm: &Vector3<T>) -> Vector3<T> {
        self.foot_mm + self.axis * self.axis.dot(point_mm)
    }

    /// The hinge's frame.
    pub(super) fn frame(&self) -> Frame<T> {
        let at_zero = self.rotation_at_zero();
        let axis_in_platform = at_zero.tr_mul(&self.axis);
        Frame { at_zero, axis_in_platform, across: across(&self.axis), across_in_platform: across(&axis_in_platform) }
    }

    /// How a platform point moves with the unknowns and then with the angle, mm per unit. `frame`: the hinge's; `rotation`: the
    /// platform's; `arm_mm`: from the platform's foot point to the point, in {P}.
    ///
    /// A foot point stays at a right angle to its axis: what it gives way along the axis counts as well.
    pub(super) fn motions(
        &self,
        frame: &Frame<T>,
        rotation: &Matrix3<T>,
        arm_mm: &Vector3<T>,
    ) -> [Vector3<T>; HINGE_UNKNOWNS + 1] {
        let (a, c, q) = (&self.axis, &self.foot_mm, &self.foot_in_platform_mm);
        let Frame { axis_in_platform: d, across: [e1, e2], across_in_platform: [f1, f2], .. } = frame;
        let from_axis = a * self.along_mm + rotation * arm_mm;
        let turned = |e: &Vector3<T>| a.cross(e).cross(&from_axis) - a * e.dot(c);
        let turned_in_platform = |f: &Vector3<T>| a * f.dot(q) - rotation * d.cross(f).cross(arm_mm);
        [
            turned(e1),
            turned(e2),
            *e1,
            *e2,
            turned_in_platform(f1),
            turned_in_platform(f2),
            -(rotation * f1),
            -(rotation * f2),
            *a,
            a.cross(&from_axis),
        ]
    }

    /// The angle of this hinge's zero from the zero of `other`, the same hinge, rad.
    pub(super) fn zero_from(&self, other: &Self) -> T {
        let turn = self.attitude * other.attitude.conjugate();
        turn.imag().dot(&self.axis).atan2(turn.w) * T::of(2.0)
    }

    /// The same hinge with its axis named in the other direction; angles change their sign.
    #[must_use]
    pub fn reversed(mut self) -> Self {
        self.axis = -self.axis;
        self.along_mm = -self.along_mm;
        self
    }

    /// The same hinge with its axis in the direction of `drawn`, or, without one, with the largest component of its
    /// direction positive: run for run the same joint has the same direction, and its angle the same sign.
    #[must_use]
    pub(super) fn named_as(self, drawn: Option<&Vector3<T>>) -> Self {
        let larger = |one: T, other: T| if other.abs() > one.abs() { other } else { one };
        let largest = || self.axis.iter().copied().fold(T::zero(), larger);
        let forward = drawn.map_or_else(largest, |drawn| drawn.dot(&self.axis));
        if forward < T::zero() { self.reversed() } else { self }
    }

    /// The hinge moved by a step of its unknowns.
    #[must_use]
    pub fn moved(&self, step: &[T]) -> Self {
        let x = |k: usize| step.get(k).copied().unwrap_or_else(T::zero);
        let d = self.axis_in_platform();
        let ([e1, e2], [f1, f2]) = (across(&self.axis), across(&d));
        let turn = self.axis.cross(&(e1 * x(AXIS) + e2 * x(AXIS + 1)));
        let turn_in_platform = d.cross(&(f1 * x(AXIS_IN_PLATFORM) + f2 * x(AXIS_IN_PLATFORM + 1)));
        let none = UnitQuaternion::identity();
        let axis = unit(&(rotation_of(&turned(&none, &turn)) * self.axis));
        // First the platform turns against its axis, then both turn with it.
        let attitude = turned(&turned(&self.attitude, &-(self.rotation_at_zero() * turn_in_platform)), &turn);
        let axis_in_platform = rotation_of(&attitude).tr_mul(&axis);
        let foot = self.foot_mm + e1 * x(FOOT) + e2 * x(FOOT + 1);
        let foot_in_platform = self.foot_in_platform_mm + f1 * x(FOOT_IN_PLATFORM) + f2 * x(FOOT_IN_PLATFORM + 1);
        Self {
            axis,
            foot_mm: foot - axis * axis.dot(&foot),
            attitude,
            foot_in_platform_mm: foot_in_platform - axis_in_platform * axis_in_platform.dot(&foot_in_platform),
            along_mm: self.along_mm + x(ALONG),
        }
    }

    /// The unknowns of `other` seen from this hinge: zero for the same, and for small differences the step that leads
    /// there. `other` is taken in the direction that has an acute angle to this axis.
    pub fn difference(&self, other: &Self) -> [T; HINGE_UNKNOWNS] {
        let other = if self.axis.dot(&other.axis) < T::zero() { other.reversed() } else { *other };
        let d = self.axis_in_platform();
        let ([e1, e2], [f1, f2]) = (across(&self.axis), across(&d));
        let foot = other.foot_mm - self.foot_mm;
        let foot_in_platform = other.foot_in_platform_mm - self.foot_in_platform_mm;
        let axis_in_platform = other.axis_in_platform();
        [
            e1.dot(&other.axis),
            e2.dot(&other.axis),
            e1.dot(&foot),
            e2.dot(&foot),
            f1.dot(&axis_in_platform),
            f2.dot(&axis_in_platform),
            f1.dot(&foot_in_platform),
            f2.dot(&foot_in_platform),
            other.along_mm - self.along_mm,
        ]
    }

    /// Derivative of [`difference`](Self::difference) with a step of `other`.
    pub fn difference_jacobian(&self, other: &Self) -> SMatrix<T, HINGE_UNKNOWNS, HINGE_UNKNOWNS> {
        let mut jacobian = SMatrix::<T, HINGE_UNKNOWNS, HINGE_UNKNOWNS>::identity();
        let mut body = |from: &Vector3<T>, at: &Vector3<T>, foot: &Vector3<T>, first: usize| {
            let (rows, columns) = (across(from), across(at));
            for (i, row) in rows.iter().enumerate() {
                for (j, column) in columns.iter().enumerate() {
                    let turned = row.dot(column);
                    for part in [first, first + 2] {
                        if let Some(entry) = jacobian.get_mut((part + i, part + j)) {
                            *entry = turned;
                        }
                    }
                    // The foot point stays at a right angle to the axis.
                    if let Some(entry) = jacobian.get_mut((first + 2 + i, first + j)) {
                        *entry = -row.dot(at) * column.dot(foot);
                    }
                }
            }
        };
        body(&self.axis, &other.axis, &other.foot_mm, AXIS);
        body(&self.axis_in_platform(), &other.axis_in_platform(), &other.foot_in_platform_mm, AXIS_IN_PLATFORM);
        jacobian
    }
}

/// The rotation by an angle (rad) about an axis, a unit vector (Rodrigues).
pub(super) fn about<T: Real>(axis: &Vector3<T>, angle_rad: T) -> Matrix3<T> {
    let (sin, cos) = angle_rad.sine_and_cosine();
    Matrix3::identity() * cos + axis.cross_matrix() * sin + axis * axis.transpose() * (T::one() - cos)
}

/// The smallest rotation that brings one unit vector onto another; a half turn about anything across where they are
/// opposite.
fn smallest_rotation<T: Real>(from: &Vector3<T>, to: &Vector3<T>) -> UnitQuaternion<T> {
    let w = T::one() + from.dot(to);
    let opposite = w < T::of(1e-6);
    let (w, v) = if opposite { (T::zero(), across(from)[0]) } else { (w, from.cross(to)) };
    let q = Quaternion::from_parts(w, v);
    UnitQuaternion::new_unchecked(q * (T::one() / q.norm_squared().root()))
}
