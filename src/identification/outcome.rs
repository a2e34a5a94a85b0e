//! What an identification ends with: a centre with its covariance, or a refusal.

use super::machine::MachineDeviation;
use super::uncertainty;
use crate::linear_algebra::non_negative_root;
use crate::rig::{CABLES, Parameters};
use crate::scalar::Real;
use heapless::Vec;

pub use super::refusal::Refusal;
pub use super::uncertainty::{RESULT_PACKED, RESULT_UNKNOWNS};

/// Maximum number of iterations of any method; the RMS residual of each is kept.
pub const MAX_ITERATIONS: usize = 30;

/// Maximum number of rejected poses that a result lists: a fifth of the default buffer.
pub const MAX_REJECTED: usize = 25;

/// Why an iteration ended well.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Termination {
    /// δE fell below ε: the residuals vanish (noise-free lengths).
    DeviationBelowTolerance = 1,
    /// The last step moved no parameter by as much as the tolerance: what is left of δE is noise.
    Settled = 2,
}

/// A pose that was left out, and its faulty cables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Rejected {
    /// Pose, from 0.
    pub pose: u32,
    /// Bit k set: cable k + 1. Two bits when two cables look alike or were exchanged; none when no single cable
    /// explains the pose.
    pub cables: u8,
}

impl Rejected {
    /// The faulty cables, 1 to 6.
    pub fn cable_numbers(self) -> impl Iterator<Item = u8> {
        (1..=6).filter(move |cable| self.cables & (1 << (cable - 1)) != 0)
    }
}

/// An identified joint centre.
#[derive(Clone, Debug, PartialEq)]
pub struct Identified<T> {
    /// Joint centre and radii, mm.
    pub parameters: Parameters<T>,
    /// Covariance of x, y, z, p1, p2, p3, mm²: lower triangle, row by row.
    pub covariance_mm2: [T; RESULT_PACKED],
    /// Standard deviation (1σ) of the noise of a cable length, mm. The covariance is computed with it; wider where an
    /// estimated noise beyond the rig's may hide a bad reading.
    pub noise_mm: T,
    /// RMS residual δE over the poses used, three degrees of freedom a pose, mm. The paper's
    /// iteration gives δE of the platform edges (Eq. 17, as the root mean square that its text describes); the
    /// estimator gives the same figure in terms of cable lengths.
    pub rms_residual_mm: T,
    /// The same before each step and after the last (the paper's iteration), after each step (the estimator), mm.
    pub rms_residuals_mm: Vec<T, { MAX_ITERATIONS + 1 }>,
    /// Least-squares steps taken.
    pub iterations: u8,
    /// Why the iteration ended.
    pub termination: Termination,
    /// Poses given.
    pub poses: u32,
    /// Poses left out, each with its faulty cables; the first [`MAX_REJECTED`] of them.
    pub rejected: Vec<Rejected, MAX_REJECTED>,
    /// RMS angle by which the poses move the axis that they move least, rad (see
    /// [`Excitation`](super::excitation::Excitation)). Infinite for the paper's iteration, which does not look.
    pub excitation_rad: T,
    /// Encoder offsets (reading minus true length), mm. 0 when they are taken as known.
    pub offsets_mm: [T; CABLES],
    /// 1σ of the encoder offsets, mm. 0 when they are taken as known.
    pub offset_sigmas_mm: [T; CABLES],
    /// By how much shape and drums of the machine differ from what is stated. 0 where they are taken as known.
    pub machine: MachineDeviation<T>,
}

impl<T: Real> Identified<T> {
    /// An empty result that the estimator fills in place.
    pub(crate) fn empty(nominal: Parameters<T>) -> Self {
        let zero = T::zero();
        Self {
            parameters: nominal,
            covariance_mm2: [zero; RESULT_PACKED],
            noise_mm: zero,
            rms_residual_mm: zero,
            rms_residuals_mm: Vec::new(),
            iterations: 0,
            termination: Termination::Settled,
            poses: 0,
            rejected: Vec::new(),
            excitation_rad: zero,
            offsets_mm: [zero; CABLES],
            offset_sigmas_mm: [zero; CABLES],
            machine: MachineDeviation::none(),
        }
    }

    /// 1σ of x, y, z, p1, p2, p3, mm.
    pub fn sigma_mm(&self) -> [T; RESULT_UNKNOWNS] {
        uncertainty::sigmas(&self.covariance_mm2)
    }

    /// The direction in x, y, z, p1, p2, p3 that is known worst, a unit vector, and its 1σ, mm.
    pub fn weak_direction(&self) -> ([T; RESULT_UNKNOWNS], T) {
        uncertainty::worst_direction(&self.covariance_mm2)
    }

    /// 1σ of the centre in its worst direction in {B}, mm, and that direction.
    pub fn worst_centre_sigma_mm(&self) -> (T, [T; 3]) {
        uncertainty::worst_centre_direction(&self.covariance_mm2)
    }
}

/// State of a method after a slice of work. `R`: the result, or a reference to it.
#[derive(Clone, Debug, PartialEq)]
pub enum Progress<R> {
    /// Not done: call again.
    Working,
    /// The centre is identified.
    Identified(R),
    /// There is no result; the refusal names the cause.
    Refused(Refusal),
}

/// δE (Eq. 17): root mean square of the residuals of `poses` poses, mm, from their sum of squares, mm².
pub(crate) fn rms_residual<T: Real>(squares_mm2: T, poses: usize) -> T {
    non_negative_root(squares_mm2 / T::of_integer(3 * poses as i32))
}
