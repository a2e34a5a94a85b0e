//! An identified hinge with its covariance.

use super::joint::{ALONG, AXIS, AXIS_IN_PLATFORM, FOOT, FOOT_IN_PLATFORM, HINGE_UNKNOWNS, Hinge};
use super::machine::HingeMachine;
use super::refusal::{HingePart, HingeRefusal};
use super::settings::HingeSettings;
use crate::linear_algebra::non_negative_root;
use crate::scalar::Real;
use nalgebra::{Matrix2, SMatrix};

/// An identified hinge.
#[derive(Clone, Debug, PartialEq)]
pub struct IdentifiedHinge<T: Real> {
    /// The hinge.
    pub hinge: Hinge<T>,
    /// Covariance of its unknowns in the order of [`HINGE_UNKNOWNS`], rad and mm.
    pub covariance: SMatrix<T, HINGE_UNKNOWNS, HINGE_UNKNOWNS>,
    /// The machine as it was estimated.
    pub machine: HingeMachine<T>,
    /// 1σ of one length that the covariance is computed with, mm.
    pub noise_mm: T,
    /// What is left of the residuals, root mean square over the redundant lengths, mm.
    pub rms_residual_mm: T,
    /// From the smallest to the largest angle of the poses used, rad.
    pub flexion_rad: T,
    /// Poses given.
    pub poses: u32,
    /// Poses left out; the poses themselves say which, and which cable is suspected.
    pub rejected: u32,
}

impl<T: Real> IdentifiedHinge<T> {
    /// Nothing but places to fill: a hinge and a machine.
    pub(super) fn at(hinge: &Hinge<T>, machine: HingeMachine<T>) -> Self {
        Self {
            hinge: *hinge,
            covariance: SMatrix::zeros(),
            machine,
            noise_mm: T::zero(),
            rms_residual_mm: T::zero(),
            flexion_rad: T::zero(),
            poses: 0,
            rejected: 0,
        }
    }

    /// 1σ of one unknown, rad or mm.
    pub(super) fn sigma(&self, unknown: usize) -> T {
        non_negative_root(self.entry(unknown, unknown))
    }

    /// 1σ of each unknown, rad and mm.
    pub fn sigmas(&self) -> [T; HINGE_UNKNOWNS] {
        core::array::from_fn(|k| self.sigma(k))
    }

    /// 1σ of a part in its worst direction, rad or mm.
    pub fn worst_sigma(&self, part: HingePart) -> T {
        let first = match part {
            HingePart::Axis => AXIS,
            HingePart::Place => FOOT,
            HingePart::AxisInPlatform => AXIS_IN_PLATFORM,
            HingePart::PlaceInPlatform => FOOT_IN_PLATFORM,
            HingePart::Along => return non_negative_root(self.entry(ALONG, ALONG)),
        };
        let of = |i: usize, j: usize| self.entry(first + i, first + j);
        let block = Matrix2::new(of(0, 0), of(0, 1), of(1, 0), of(1, 1));
        let (half_trace, determinant) = (block.trace() * T::of(0.5), block.m11 * block.m22 - block.m12 * block.m21);
        non_negative_root(half_trace + non_negative_root(half_trace * half_trace - determinant))
    }

    fn entry(&self, i: usize, j: usize) -> T {
        self.covariance.get((i, j)).copied().unwrap_or_else(T::zero)
    }

    /// Refuses a standard deviation above its limit. `scale`: of the covariance's noise to the rig's.
    ///
    /// # Errors
    /// [`HingeRefusal::Weak`].
    pub(super) fn require_accuracy(&self, settings: &HingeSettings<T>) -> Result<(), HingeRefusal> {
        use HingePart::{Along, Axis, AxisInPlatform, Place, PlaceInPlatform};
        for part in [Axis, Place, AxisInPlatform, PlaceInPlatform, Along] {
            let limit = match part {
                Axis | AxisInPlatform => settings.axis_limit_rad,
                Place | PlaceInPlatform => settings.place_limit_mm,
                Along => settings.along_limit_mm,
            };
            let sigma = self.worst_sigma(part);
            // Also refuses NaN.
            if !(sigma <= limit) {
                return Err(HingeRefusal::Weak { part, sigma: sigma.to_f32() });
            }
        }
        Ok(())
    }
}
