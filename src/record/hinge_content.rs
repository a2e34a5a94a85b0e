//! What is kept of an elbow's calibration.

use super::content::{Record, Unfit, are_finite, are_not_negative};
use crate::identification::hinge::{HINGE_UNKNOWNS, Hinge, MAX_CONSTANTS};
use crate::linear_algebra::packed_index;

/// Entries of the packed covariance of a hinge.
pub const HINGE_PACKED: usize = HINGE_UNKNOWNS * (HINGE_UNKNOWNS + 1) / 2;

/// An accepted calibration of an elbow, with everything that the device reports about it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HingeRecord {
    /// The run that found the hinge; not 0.
    pub run_id: u16,
    /// The boot in which it ran, modulo 2^16.
    pub boot: u16,
    /// Whose arm it was made for; 0 = not said.
    pub wearer: u16,
    /// Serial number of the board; 0 when it has none.
    pub serial: u32,
    /// Fingerprint of the rig that it was found on.
    pub rig: u32,
    /// Firmware that found it: major, minor, patch.
    pub firmware: [u8; 3],
    /// The hinge.
    pub hinge: Hinge<f32>,
    /// Covariance of its unknowns, rad and mm: lower triangle, row by row.
    pub covariance: [f32; HINGE_PACKED],
    /// By how much each of the machine's constants differs from what is stated.
    pub constants: [f32; MAX_CONSTANTS],
    /// Standard deviation of the noise of a cable length, mm.
    pub noise_mm: f32,
    /// What is left of the residuals, root mean square over the redundant lengths, mm.
    pub rms_residual_mm: f32,
    /// From the smallest to the largest angle of the poses used, rad.
    pub flexion_rad: f32,
    /// Poses given to the solver.
    pub poses: u8,
    /// How many of these it left out.
    pub left_out: u8,
    /// Poses of the second set.
    pub verification_poses: u8,
    /// Deviation of the second set, mm.
    pub verification_deviation_mm: f32,
    /// The limit that it was held against, mm.
    pub verification_limit_mm: f32,
}

impl HingeRecord {
    /// Looks whether the numbers can be those of a calibration.
    ///
    /// # Errors
    /// [`Unfit`].
    pub fn check(&self) -> Result<(), Unfit> {
        let singles = [
            self.noise_mm,
            self.rms_residual_mm,
            self.flexion_rad,
            self.verification_deviation_mm,
            self.verification_limit_mm,
        ];
        let variances: [f32; HINGE_UNKNOWNS] =
            core::array::from_fn(|i| self.covariance.get(packed_index(i, i)).copied().unwrap_or(f32::NAN));
        let fit = self.run_id != 0
            && self.left_out <= self.poses
            && self.hinge.is_sound()
            && are_finite(&[&self.covariance, &self.constants])
            && are_not_negative(&[&variances, &singles]);
        if fit { Ok(()) } else { Err(Unfit) }
    }
}

/// What is kept, whichever joint the board is about.
// One of them is there at a time, and no heap to box it on.
#[allow(clippy::large_enum_variant)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum JointRecord {
    /// A ball, or a centre that moves with the arm.
    Ball(Record),
    /// A hinge.
    Hinge(HingeRecord),
}

impl From<Record> for JointRecord {
    fn from(record: Record) -> Self {
        Self::Ball(record)
    }
}

impl From<HingeRecord> for JointRecord {
    fn from(record: HingeRecord) -> Self {
        Self::Hinge(record)
    }
}

impl JointRecord {
    /// The run that found it.
    pub const fn run_id(&self) -> u16 {
        match self {
            Self::Ball(record) => record.run_id,
            Self::Hinge(record) => record.run_id,
        }
    }

    /// Fingerprint of the rig that it was found on.
    pub const fn rig(&self) -> u32 {
        match self {
            Self::Ball(record) => record.rig,
            Self::Hinge(record) => record.rig,
        }
    }

    /// The record, if it is of a ball.
    pub const fn ball(&self) -> Option<&Record> {
        match self {
            Self::Ball(record) => Some(record),
            Self::Hinge(_) => None,
        }
    }

    /// The record, if it is of a hinge.
    pub const fn hinge(&self) -> Option<&HingeRecord> {
        match self {
            Self::Ball(_) => None,
            Self::Hinge(record) => Some(record),
        }
    }

    /// Looks whether the numbers can be those of a calibration.
    ///
    /// # Errors
    /// [`Unfit`].
    pub fn check(&self) -> Result<(), Unfit> {
        match self {
            Self::Ball(record) => record.check(),
            Self::Hinge(record) => record.check(),
        }
    }
}
