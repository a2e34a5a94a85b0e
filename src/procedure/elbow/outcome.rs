//! What an elbow's run hands out: the new hinge.

use crate::identification::hinge::{HINGE_UNKNOWNS, Hinge, IdentifiedHinge, MAX_CONSTANTS};
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
    /// By how much each of the machine's constants differs from what is stated.
    pub constants: [f32; MAX_CONSTANTS],
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
            constants: *found.machine.values(),
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
        core::array::from_fn(|index| self.number(index))
    }

    /// One of them, from 0; zeros past the last.
    pub fn number(&self, index: usize) -> [f32; 2] {
        let hinge = &self.hinge;
        let (body, component) = (index / 6, index % 3);
        let (axis, foot) = match body {
            0 => (*hinge.axis(), hinge.foot_mm()),
            1 => (hinge.axis_in_platform(), hinge.foot_in_platform_mm()),
            _ if index < SHOWN_NUMBERS => return [hinge.along_mm(), self.sigma(HINGE_UNKNOWNS - 1, &[1.0])],
            _ => return [0.0; 2],
        };
        let of = |vector: &Vector3<f32>| vector.get(component).copied().unwrap_or_default();
        let [e1, e2] = crate::identification::hinge::across(&axis);
        // How this component follows the body's four unknowns; a foot point stays at a right angle to its axis.
        let (value, follows) = if index % 6 < 3 {
            (of(&axis), [of(&e1), of(&e2), 0.0, 0.0])
        } else {
            let along = -of(&axis);
            (of(foot), [along * e1.dot(foot), along * e2.dot(foot), of(&e1), of(&e2)])
        };
        [value, self.sigma(body * BODY_UNKNOWNS, &follows)]
    }

    /// A component of the point of the axis in {B} at which the platform's foot point stands, mm, with its 1σ: with the axes and
    /// the platform's foot point it says all about the hinge.
    pub fn common_point(&self, component: usize) -> [f32; 2] {
        let (axis, foot, along) = (self.hinge.axis(), self.hinge.foot_mm(), self.hinge.along_mm());
        let of = |vector: &Vector3<f32>| vector.get(component).copied().unwrap_or_default();
        let [e1, e2] = crate::identification::hinge::across(axis);
        // The point is foot + along · axis, and the foot point stays at a right angle to the axis.
        let turned = |e: &Vector3<f32>| along * of(e) - of(axis) * e.dot(foot);
        let follows = [turned(&e1), turned(&e2), of(&e1), of(&e2), 0.0, 0.0, 0.0, 0.0, of(axis)];
        [of(foot) + along * of(axis), self.sigma(0, &follows)]
    }

    /// 1σ of a linear function of the unknowns from `first` on. By the lower triangle, which is what a record holds.
    fn sigma(&self, first: usize, follows: &[f32]) -> f32 {
        let mut variance = 0.0;
        for (i, a) in follows.iter().enumerate() {
            for (j, b) in follows.iter().enumerate() {
                variance +=
                    a * b * self.covariance.get((first + i.max(j), first + i.min(j))).copied().unwrap_or_default();
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
