//! How one module stands on the limb that another one moves.

use crate::identification::carried_point::CarriedPoint;
use crate::scalar::Real;
use nalgebra::{Matrix3, Vector3};

/// The frame of the next module's base in the platform of the one before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mount<T> {
    /// Rotation from the next module's base to this platform.
    pub rotation: Matrix3<T>,
    /// Origin of the next module's base in this platform, mm.
    pub origin_mm: Vector3<T>,
    /// How well the origin is known, 1σ of each coordinate, mm.
    pub sigma_mm: T,
    /// How well the rotation is known, 1σ about each axis, rad.
    pub sigma_rad: T,
}

impl<T: Real> Mount<T> {
    /// A point of the next module's base, in this platform.
    pub fn carry(&self, point: &CarriedPoint<T>) -> CarriedPoint<T> {
        let arm = self.rotation * point.at_mm;
        let mut carried = point.moved(&self.rotation, arm + self.origin_mm);
        carried.covariance_mm2 += self.own_covariance_mm2(&arm);
        carried
    }

    /// A point of this platform, in the next module's base.
    pub fn carry_back(&self, point: &CarriedPoint<T>) -> CarriedPoint<T> {
        let arm = point.at_mm - self.origin_mm;
        let back = self.rotation.transpose();
        let with_own = CarriedPoint { covariance_mm2: point.covariance_mm2 + self.own_covariance_mm2(&arm), ..*point };
        with_own.moved(&back, back * arm)
    }

    fn own_covariance_mm2(&self, arm_mm: &Vector3<T>) -> Matrix3<T> {
        let cross = arm_mm.cross_matrix();
        Matrix3::from_diagonal_element(self.sigma_mm * self.sigma_mm)
            + cross * cross.transpose() * (self.sigma_rad * self.sigma_rad)
    }
}
