//! What the last fit says of a pose that it has not seen.

use super::Estimator;
use super::fit::Fit;
use super::model::Model;
use crate::identification::machine::Machine;
use crate::identification::marginal_information::MarginalInformation;
use crate::identification::parameters::{MAX_UNKNOWNS, PoseAt, Scattered, sensitivity};
use crate::identification::pose::Pose;
use crate::identification::verification::VerifiedPose;
use crate::kinematics::CableSet;
use crate::linear_algebra::{inverse_of_positive_definite, rounding};
use crate::scalar::Real;
use nalgebra::Matrix3;

impl<T: Real> Estimator<T> {
    /// The residuals of a pose about the estimated centre, held against the noise and what the estimate does not know.
    /// `None` when no rotation fits its lengths.
    ///
    /// With g = S δ̂ of the pose and K the derivative of g with the unknowns, χ² = gᵀ (σ² S + K Σ Kᵀ)⁻¹ g.
    pub fn verify(&self, machine: &Machine<T>, pose: &Pose<T>) -> Option<VerifiedPose<T>> {
        self.fit.verify(machine, pose)
    }
}

impl<T: Real> Fit<T> {
    fn verify(&self, machine: &Machine<T>, pose: &Pose<T>) -> Option<VerifiedPose<T>> {
        let lengths = self.estimate.corrected(machine, pose.lengths());
        let solver = self.attitude_solver();
        let fit = solver.track(*pose.attitude(), &lengths, CableSet::ALL);
        let attitude = fit.or_else(|| solver.solve(&lengths, CableSet::ALL))?.attitude;
        let rotation = crate::kinematics::rotation::rotation_of(&attitude);
        let jacobian = self.jacobian(&rotation, &lengths);
        let information = MarginalInformation::new(&jacobian).ok()?;
        let variance = self.result.noise_mm * self.result.noise_mm * pose.relative_variance;
        let scattered = Scattered::new(&information, self.joint.scatter_mm2() / variance);
        let at = PoseAt { rotation: &rotation, lengths: &lengths, jacobian: &jacobian };
        let features = self.joint.features(&at);
        let model = Model { machine, estimate: &self.estimate, joint: &self.joint, features };
        let rows = sensitivity(&model, &at, &scattered);
        let g = scattered.information.gradient_mm;
        let expected = scattered.information.information * variance + self.covariance_of(&rows);
        let chi_square = g.dot(&(inverse_of_positive_definite(&expected, rounding())? * g));
        Some(VerifiedPose { squares_mm2: information.squares_mm2, chi_square })
    }

    /// Covariance of three linear functions of the unknowns, mm².
    pub fn covariance_of(&self, rows: &[[T; MAX_UNKNOWNS]; 3]) -> Matrix3<T> {
        let mut whitened = *rows;
        whitened.iter_mut().for_each(|row| self.equations.whiten(row));
        let variance = self.result.noise_mm * self.result.noise_mm;
        let product = |a: &[T; MAX_UNKNOWNS], b: &[T; MAX_UNKNOWNS]| {
            a.iter().zip(b).take(self.equations.unknowns()).fold(T::zero(), |sum, (a, b)| sum + *a * *b)
        };
        Matrix3::from_fn(|i, j| product(&whitened[i], &whitened[j]) * variance)
    }
}
