//! What an elbow's run hands out: the new hinge.

use crate::identification::hinge::{HINGE_UNKNOWNS, Hinge, IdentifiedHinge};
use crate::linear_algebra::non_negative_root;
use crate::procedure::outcome::Verification;
use nalgebra::{SMatrix, Vector3};

/// A hinge with its standard deviations and how it was found.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundHinge {
    /// The hinge.
    pub hinge: Hinge<f32>,
    /// Covariance of its unknowns in the order of [`HINGE_UNKNOWNS`], rad and mm.
    pub covariance: SMatrix<f32, HINGE_UNKNOWNS, HINGE_UNKNOWNS>,
    /// 1σ of one length that the covariance is computed with, mm.
    pub noise_mm: f32,
    /// What is left of the residuals, root mean square over the redundant lengths, mm.
    pub rms_residual_mm: f32,
    /// From the smallest to the largest angle of the poses used, rad.
    pub flexion_rad: f32,
    /// Poses given, and those left out.
    pub poses: u8,
    /// Poses left out.
    pub rejected: u8,
}

/// Numbers of a hinge as it is shown: direction of the axis in the base (3), its foot point there (3, mm), the same in the
/// platform (6), the offset along the axis (1, mm).
pub const SHOWN_NUMBERS: usize = 13;

impl FoundHinge {
    /// What a run keeps of the estimator's result.
    pub fn of(found: &IdentifiedHinge<f32>) -> Self {
        Self {
            hinge: found.hinge,
            covariance: found.covariance,
            noise_mm: found.noise_mm,
            rms_residual_mm: found.rms_residual_mm,
            flexion_rad: found.flexion_rad,
            // No set has more than a byte counts.
            poses: found.poses as u8,
            rejected: found.rejected as u8,
        }
    }

    /// Is every number one?
    pub fn is_finite(&self) -> bool {
        self.shown().iter().flatten().chain(&self.covariance).all(|number| number.is_finite())
    }

    /// The numbers that describe the hinge, each with its 1σ.
    pub fn shown(&self) -> [[f32; 2]; SHOWN_NUMBERS] {
        let hinge = &self.hinge;
        let axis_in_platform = hinge.axis_in_platform();
        let bodies =
            [(hinge.axis(), hinge.foot_mm(), 0), (&axis_in_platform, hinge.foot_in_platform_mm(), BODY_UNKNOWNS)];
        let mut shown = [[0.0; 2]; SHOWN_NUMBERS];
        let mut places = shown.iter_mut();
        for (axis, foot, first) in bodies {
            let across = crate::identification::hinge::across(axis);
            for (vector, is_place) in [(axis, false), (foot, true)] {
                for (component, value) in vector.iter().enumerate() {
                    // How this component follows the body's four unknowns; a foot point stays at a right angle to its axis.
                    let [e1, e2] = across.map(|e: Vector3<f32>| e.get(component).copied().unwrap_or_default());
                    let along = axis.get(component).copied().unwrap_or_default();
                    let [f1, f2] = across.map(|e: Vector3<f32>| -along * e.dot(foot));
                    let follows = if is_place { [f1, f2, e1, e2] } else { [e1, e2, 0.0, 0.0] };
                    if let Some(place) = places.next() {
                        *place = [*value, self.sigma(first, &follows)];
                    }
                }
            }
        }
        if let Some(place) = places.next() {
            *place = [hinge.along_mm(), self.sigma(HINGE_UNKNOWNS - 1, &[1.0])];
        }
        shown
    }

    /// 1σ of a linear function of the unknowns from `first` on.
    fn sigma(&self, first: usize, follows: &[f32]) -> f32 {
        let mut variance = 0.0;
        for (i, a) in follows.iter().enumerate() {
            for (j, b) in follows.iter().enumerate() {
                variance += a * b * self.covariance.get((first + i, first + j)).copied().unwrap_or_default();
            }
        }
        non_negative_root(variance)
    }
}

/// Unknowns of a hinge in one body: direction and place of the axis.
const BODY_UNKNOWNS: usize = 4;

/// A hinge that passed identification and the second set. It comes into use when it is accepted.
#[derive(Debug, Clone, PartialEq)]
pub struct ElbowCandidate {
    /// The run that found it.
    pub run_id: u16,
    /// The boot in which it ran, modulo 2^16. Boot and run together never repeat.
    pub boot: u16,
    /// Whose arm it was made for; 0 = not said.
    pub wearer: u16,
    /// The hinge.
    pub found: FoundHinge,
    /// What the second set said.
    pub verification: Verification,
}
