//! The evidence of a suspicious stretch of motion, fitted with each possible cause.

use super::warning::{Cause, Explanation, Squares, Warning, best_cable};
use crate::identification::marginal_information::MarginalInformation;
use crate::linear_algebra::{NormalEquations, dot, solve_positive_definite};
use crate::rig::CABLES;
use crate::scalar::Real;
use nalgebra::{Matrix3, Vector3};

/// Lengths to spare: three of six are explained by the rotation.
const SPARE: i32 = 3;

/// Sums over the samples of a stretch of motion.
#[derive(Clone, Debug)]
pub(super) struct Evidence<T> {
    squares: Squares<T>,
    /// δO, and (rows 3..6) δO per radian of elevation.
    drift: NormalEquations<T, 6, 21>,
    /// Information on δO (no unit) and its gradient, mm, in {B}.
    strap: (Matrix3<T>, Vector3<T>),
    /// The same of δC in {P}.
    cuff: (Matrix3<T>, Vector3<T>),
    /// Weight and gradient of each cable's own error.
    cables: [(T, T); CABLES],
}

impl<T: Real> Evidence<T> {
    /// Of no sample yet.
    pub fn new() -> Self {
        Self {
            squares: Squares::none(SPARE),
            drift: NormalEquations::new(6),
            strap: (Matrix3::zeros(), Vector3::zeros()),
            cuff: (Matrix3::zeros(), Vector3::zeros()),
            cables: [(T::zero(), T::zero()); CABLES],
        }
    }

    /// Samples added.
    pub fn samples(&self) -> u16 {
        self.squares.samples()
    }

    /// Adds a sample with the arm's rotation ({P} to {B}), without what it says of single cables.
    #[cfg_attr(feature = "ccm", unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
    pub fn add(&mut self, rotation: &Matrix3<T>, pose: &MarginalInformation<T>) {
        self.squares.add(pose.squares_mm2());
        let (information, gradient) = (&pose.information(), &pose.gradient_mm());
        self.strap.0 += information;
        self.strap.1 += gradient;
        self.cuff.0 += rotation.tr_mul(&(information * rotation));
        self.cuff.1 -= rotation.tr_mul(gradient);
        self.add_growing(information, gradient, elevation(rotation));
    }

    /// Adds what the same sample says of single cables.
    pub fn add_cables(&mut self, pose: &MarginalInformation<T>) {
        for ((weight, gradient), column) in self.cables.iter_mut().zip(&pose.projector()) {
            *weight += column.norm_squared();
            *gradient += column.dot(&pose.residuals_mm);
        }
    }

    /// Adds a sample to the normal equations of δO = a + b t, unknowns a and b, for a known t.
    fn add_growing(&mut self, information: &Matrix3<T>, gradient: &Vector3<T>, t: T) {
        for i in 0..3 {
            for j in 0..3 {
                self.drift.add_to_entry(3 + i, j, information[(i, j)] * t);
                if j <= i {
                    self.drift.add_to_entry(i, j, information[(i, j)]);
                    self.drift.add_to_entry(3 + i, 3 + j, information[(i, j)] * (t * t));
                }
            }
            self.drift.add_to_gradient(i, gradient[i]);
            self.drift.add_to_gradient(3 + i, gradient[i] * t);
        }
    }

    /// The cause that explains the evidence; `None` when there is nothing to explain. `usual`: χ² per degree of
    /// freedom before the suspicion, 1 or more. `drift`: what [`drift`](Self::drift) found before.
    pub fn judge(&self, variance_mm2: T, suspicious: T, usual: T, drift: Explanation<T>) -> Option<Warning<T>> {
        self.squares.judge(
            variance_mm2,
            suspicious,
            usual,
            &[best_cable(&self.cables), self.strap(), self.cuff(), drift],
        )
    }

    fn strap(&self) -> Explanation<T> {
        let (moved, explained) = moved(&self.strap.0, &self.strap.1)?;
        Some((Cause::StrapSlipped(moved), explained, 3))
    }

    fn cuff(&self) -> Explanation<T> {
        let (moved, explained) = moved(&self.cuff.0, &self.cuff.1)?;
        Some((Cause::CuffSlipped(moved), explained, 3))
    }

    /// A centre that moves with the arm's elevation as the cause; half of the work of judging.
    pub fn drift(&self) -> Explanation<T> {
        let mut drift = self.drift;
        drift.factor().ok()?;
        let step = drift.step();
        let explained = dot(&step, drift.gradient());
        // A radian of elevation to 10 degrees.
        let per_ten_degrees = Vector3::new(step[3], step[4], step[5]) * T::of(0.174_532_925_199_432_95);
        Some((Cause::NotABall(per_ten_degrees), explained, 6))
    }
}

/// The displacement that fits best, mm, and the squares that it explains, mm².
fn moved<T: Real>(information: &Matrix3<T>, gradient: &Vector3<T>) -> Option<(Vector3<T>, T)> {
    let moved = solve_positive_definite(information, gradient, T::default_epsilon())?;
    Some((moved, moved.dot(gradient)))
}

/// Angle between the arm's long axis (z of {P}) and z of {B}, rad, from its sine and cosine.
fn elevation<T: Real>(rotation: &Matrix3<T>) -> T {
    let (x, y, z) = (rotation.m13, rotation.m23, rotation.m33);
    (x * x + y * y).root().atan2(z)
}
