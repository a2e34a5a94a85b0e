//! What is kept of a calibration.

use crate::identification::Rejected;
use crate::identification::joint::ShownMotion;
use crate::identification::machine::MachineDeviation;
use crate::identification::outcome::MAX_REJECTED;
use crate::identification::outcome::RESULT_PACKED;
use crate::linear_algebra::packed_index;
use crate::rig::{CABLES, Parameters};

/// An accepted calibration, with everything that the device reports about it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Record {
    /// The run that found the centre; not 0.
    pub run_id: u16,
    /// The boot in which it ran, modulo 2^16.
    pub boot: u16,
    /// Whose arm it was made for; 0 = not said.
    pub wearer: u16,
    /// Serial number of the board; 0 when it has none.
    pub serial: u32,
    /// Fingerprint of the rig that it was found on (see [`crate::device::fingerprint`]).
    pub rig: u32,
    /// Firmware that found it: major, minor, patch.
    pub firmware: [u8; 3],
    /// Joint centre in {B} and radii, mm.
    pub parameters: Parameters<f32>,
    /// Covariance of x, y, z, p1, p2, p3, mm²: lower triangle, row by row.
    pub covariance_mm2: [f32; RESULT_PACKED],
    /// Zero error of each encoder, mm; 0 when the zeros were known.
    pub zeros_mm: [f32; CABLES],
    /// 1σ of the zero errors, mm; 0 when the zeros were known.
    pub zero_sigmas_mm: [f32; CABLES],
    /// Standard deviation of the noise of a cable length, mm.
    pub noise_mm: f32,
    /// δE over the poses that identified the centre (Eq. 17), mm.
    pub deviation_mm: f32,
    /// How far the poses were from turning about one common axis, rad.
    pub excitation_rad: f32,
    /// Poses given to the solver.
    pub poses: u16,
    /// How many of these it left out.
    pub left_out: u8,
    /// Which, and for which cables' sake: the first `left_out` of these.
    pub rejected: [Rejected; MAX_REJECTED],
    /// Least-squares steps.
    pub iterations: u8,
    /// Why the iteration ended: code of [`Termination`](crate::identification::Termination).
    pub termination: u8,
    /// Poses of the second set.
    pub verification_poses: u8,
    /// δE over the second set (Eq. 17), mm.
    pub verification_deviation_mm: f32,
    /// The limit that it was held against, mm.
    pub verification_limit_mm: f32,
    /// How the centre moves with the arm; `None` for a ball.
    pub motion: Option<ShownMotion>,
    /// How the machine was found to differ from what is stated.
    pub machine: MachineDeviation<f32>,
}

/// A record whose numbers cannot be those of a calibration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unfit;

impl Record {
    /// Looks whether the numbers can be those of a calibration: finite, radii positive, variances not negative. The
    /// CRC says that a record is what was written; this says that it was worth writing.
    ///
    /// # Errors
    /// [`Unfit`].
    pub fn check(&self) -> Result<(), Unfit> {
        let singles = [
            self.noise_mm,
            self.deviation_mm,
            self.excitation_rad,
            self.verification_deviation_mm,
            self.verification_limit_mm,
        ];
        let MachineDeviation { base_mm, ends_mm, scale } = &self.machine;
        let parameters = self.parameters.to_array();
        let [_, _, _, radii @ ..] = parameters;
        let fit = self.run_id != 0
            && usize::from(self.left_out) <= MAX_REJECTED
            && are_finite(&[&parameters, &self.covariance_mm2, &self.zeros_mm, base_mm, ends_mm, scale])
            && are_not_negative(&[&singles, &self.zero_sigmas_mm, &self.variances()])
            && radii.iter().all(|radius| *radius > 0.0)
            && self.motion.is_none_or(|motion| motion.is_sound());
        if fit { Ok(()) } else { Err(Unfit) }
    }

    /// The diagonal of the covariance, mm².
    fn variances(&self) -> [f32; 6] {
        core::array::from_fn(|i| self.covariance_mm2.get(packed_index(i, i)).copied().unwrap_or(f32::NAN))
    }
}

/// Are all numbers of all lists finite?
pub(super) fn are_finite(lists: &[&[f32]]) -> bool {
    lists.iter().all(|numbers| numbers.iter().all(|number| number.is_finite()))
}

/// Are they, and is none negative?
pub(super) fn are_not_negative(lists: &[&[f32]]) -> bool {
    are_finite(lists) && lists.iter().all(|numbers| numbers.iter().all(|number| *number >= 0.0))
}
