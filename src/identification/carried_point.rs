//! A point with its covariance, carried from one body to the next through an identified joint.

use crate::linear_algebra::non_negative_root;
use crate::scalar::Real;
use nalgebra::{Matrix3, Vector3};

/// A point in some body's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CarriedPoint<T> {
    /// Where it is, mm.
    pub at_mm: Vector3<T>,
    /// Covariance, mm².
    pub covariance_mm2: Matrix3<T>,
}

impl<T: Real> CarriedPoint<T> {
    /// A point that is known exactly.
    pub fn exact(at_mm: Vector3<T>) -> Self {
        Self { at_mm, covariance_mm2: Matrix3::zeros() }
    }

    /// 1σ along each axis, mm.
    pub fn sigma_mm(&self) -> Vector3<T> {
        self.covariance_mm2.diagonal().map(non_negative_root)
    }

    /// The same point in a frame that is turned and moved.
    #[must_use]
    pub fn moved(&self, rotation: &Matrix3<T>, to_mm: Vector3<T>) -> Self {
        Self { at_mm: to_mm, covariance_mm2: rotation * self.covariance_mm2 * rotation.transpose() }
    }
}
