//! What the lengths of one sample say of a hinge in use.

use super::angle::HingeAngles;
use super::joint::HINGE_UNKNOWNS;
use super::pose::{PoseAt, PoseRows};
use super::rig::MAX_CABLES;
use crate::scalar::Real;

/// A sample's equations, one a cable, the angle eliminated: as many are to spare as there are cables, less one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HingeSample<T> {
    /// Reading minus model, mm.
    pub residual_mm: [T; MAX_CABLES],
    /// Derivatives of the readings with the unknowns of the hinge, in the order of [`HINGE_UNKNOWNS`].
    pub by_hinge: [[T; HINGE_UNKNOWNS]; MAX_CABLES],
    /// How much of the square of each cable's own error is left, 0 to 1: the rest looks like another angle.
    pub left_of_cable: [T; MAX_CABLES],
}

impl<T: Real> HingeSample<T> {
    /// What lengths, mm, say of the hinge at their angle, rad; `None` when one of them is no number.
    pub fn new(angles: &HingeAngles<T>, lengths_mm: &[T; MAX_CABLES], angle_rad: T) -> Option<Self> {
        let mut rows = PoseRows::none();
        rows.set(&PoseAt::new(angles.hinge(), angles.machine()), lengths_mm, angle_rad, false, 0..MAX_CABLES);
        let by_angle = rows.by_angle;
        rows.eliminate(&by_angle, HINGE_UNKNOWNS);
        let squares = by_angle.iter().fold(T::zero(), |sum, d| sum + *d * *d);
        let mut sample = Self {
            residual_mm: rows.residual_mm,
            by_hinge: [[T::zero(); HINGE_UNKNOWNS]; MAX_CABLES],
            left_of_cable: by_angle.map(|d| T::one() - d * d / squares),
        };
        for (own, row) in sample.by_hinge.iter_mut().zip(&rows.jacobian) {
            own.iter_mut().zip(row).for_each(|(entry, of_row)| *entry = *of_row);
        }
        sample.squares_mm2().is_a_number().then_some(sample)
    }

    /// Sum of the squared residuals, mm².
    pub fn squares_mm2(&self) -> T {
        self.residual_mm.iter().fold(T::zero(), |sum, residual| sum + *residual * *residual)
    }
}
