//! The last fit against any pose: its residuals by χ², the joint centre that the model predicts in it, and the one that
//! its six lengths give.

use super::Estimator;
use super::fit::{Fit, SeenPose};
use crate::identification::joint::Joint;
use crate::identification::machine::Machine;
use crate::identification::parameters::{CENTRE_UNKNOWNS, MAX_UNKNOWNS, Rows};
use crate::identification::pose::Pose;
use crate::identification::verification::{CentrePrediction, VerifiedPose};
use crate::linear_algebra::{dot, inverse_of_positive_definite, rounding};
use crate::scalar::Real;
use nalgebra::{Matrix3, Vector3};

impl<T: Real> Estimator<T> {
    /// Verifies a pose: its residuals about the estimated centre, tested against the noise and the covariance of the
    /// estimate. `None` when no rotation fits its lengths.
    ///
    /// With g = S δ̂ of the pose, K the derivative of g with the unknowns and λ² the variance that the joint's model does not
    /// explain, χ² = gᵀ (σ² S + K Σ Kᵀ + λ² S²)⁻¹ g.
    pub fn verify(&self, machine: &Machine<T>, pose: &Pose<T>) -> Option<VerifiedPose<T>> {
        let fit = &self.fit;
        let placed = fit.place_about_centre(machine, pose)?;
        let SeenPose { scattered, sensitivity, squares_mm2, .. } = fit.seen(machine, &placed)?;
        let variance = fit.result_variance_mm2() * machine.relative_variance(pose.samples);
        let g = scattered.gradient_mm();
        let (lack_of_fit, factor) = (fit.joint.lack_of_fit_mm2(), fit.joint.variance_factor());
        let information = scattered.information();
        let expected =
            information * variance + fit.covariance_of(&sensitivity) * factor + information * information * lack_of_fit;
        let chi_square = g.dot(&(inverse_of_positive_definite(&expected, rounding())? * g));
        Some(VerifiedPose { squares_mm2, chi_square })
    }

    /// Where the joint centre is in a pose: by the joint's model from the pose's rotation, and as the pose's six
    /// lengths read it (R C + t). `None` when no rotation fits.
    pub fn predict(&self, machine: &Machine<T>, pose: &Pose<T>) -> Option<CentrePrediction<T>> {
        let fit = &self.fit;
        let placed = fit.place_about_centre(machine, pose)?;
        let seen = fit.seen(machine, &placed)?;
        let rotation = &seen.rotation;
        let centre = fit.joint.centre_at(&fit.centre, rotation).in_base_mm;
        let (lack_of_fit, factor) = (fit.joint.lack_of_fit_mm2(), fit.joint.variance_factor());
        let of_pose = inverse_of_positive_definite(&seen.unscattered, rounding())?;
        let variance = fit.result_variance_mm2() * machine.relative_variance(pose.samples);
        Some(CentrePrediction {
            predicted_mm: centre,
            predicted_covariance_mm2: fit.covariance_of(&fit.path_rows(rotation)) * factor
                + Matrix3::from_diagonal_element(lack_of_fit),
            live_mm: centre + seen.own_centre_mm,
            live_covariance_mm2: of_pose * variance + fit.covariance_of(&fit.live_rows(&seen)?) * factor,
        })
    }
}

impl<T: Real> Fit<T> {
    /// Variance of the noise that the result is reported with, mm².
    fn result_variance_mm2(&self) -> T {
        self.result.noise_mm * self.result.noise_mm
    }

    /// Covariance of three linear functions of the unknowns, mm².
    pub(super) fn covariance_of(&self, rows: &Rows<T>) -> Matrix3<T> {
        let mut whitened = *rows;
        whitened.iter_mut().for_each(|row| self.equations.whiten(row));
        let unknowns = self.equations.unknowns();
        let product = |a: &[T], b: &[T]| dot(a.get(..unknowns).unwrap_or_default(), b);
        let noise_mm = self.result.noise_mm.max(self.residuals.noise_mm);
        Matrix3::from_fn(|i, j| product(&whitened[i], &whitened[j])) * (noise_mm * noise_mm)
    }

    /// Derivative of the predicted centre O0 + A φ(R) with the unknowns.
    pub(super) fn path_rows(&self, rotation: &Matrix3<T>) -> Rows<T> {
        let mut rows = [[T::zero(); MAX_UNKNOWNS]; 3];
        let in_machine = self.estimate.count();
        let first = self.equations.unknowns() - CENTRE_UNKNOWNS;
        if let Joint::Moving(moving) = &self.joint {
            for (j, feature) in moving.frame.features(rotation).into_iter().enumerate() {
                for (axis, row) in rows.iter_mut().enumerate() {
                    set(row, in_machine + 3 * j + axis, feature);
                }
            }
        }
        for (axis, row) in rows.iter_mut().enumerate() {
            set(row, first + axis, T::one());
        }
        rows
    }

    /// Derivative with the unknowns of the centre that a pose's lengths give, R C + t: that of the model's centre plus
    /// δ̂ = S⁻¹ g, where g changes by minus the sensitivity. What moves the model's centre cancels; C and the machine's
    /// constants remain.
    fn live_rows(&self, seen: &SeenPose<T>) -> Option<Rows<T>> {
        let inverse = inverse_of_positive_definite(&seen.scattered.information(), rounding())?;
        let mut rows = self.path_rows(&seen.rotation);
        for unknown in 0..self.equations.unknowns() {
            let changes = seen.sensitivity.each_ref().map(|row| row.get(unknown).copied().unwrap_or_else(T::zero));
            let moved = inverse * Vector3::from(changes);
            for (row, moved) in rows.iter_mut().zip(&moved) {
                if let Some(entry) = row.get_mut(unknown) {
                    *entry -= *moved;
                }
            }
        }
        Some(rows)
    }
}

fn set<T: Real>(row: &mut [T; MAX_UNKNOWNS], unknown: usize, value: T) {
    if let Some(entry) = row.get_mut(unknown) {
        *entry = value;
    }
}
