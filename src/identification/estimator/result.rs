//! From a converged fit to a result with its covariance.

use super::Stage;
use super::check::Check;
use super::fit::Fit;
use crate::identification::gates::{Accuracy, require_accuracy};
use crate::identification::leave_one_out::{Candidates, candidates};
use crate::identification::machine::Machine;
use crate::identification::outcome::Rejected;
use crate::identification::pose::Pose;
use crate::identification::uncertainty::{parameters_of, worst_direction_of_point};
use crate::linear_algebra::normal_equations::smallest_pivot;
use crate::linear_algebra::{block, inverse_of_eliminated, non_negative_root};
use crate::rig::CABLES;
use crate::scalar::Real;
use nalgebra::{Matrix3, Matrix6};

impl<T: Real> Fit<T> {
    /// The gate of accuracy, then the result. `dominant`: the pose that makes most of the excitation, from 0.
    pub fn accept(&mut self, machine: &Machine<T>, poses: &[Pose<T>], dominant: Option<usize>) -> Stage<T> {
        let (noise_mm, sigma_noise_mm) = self.residuals.noise_of_result_mm(self.settings.noise, poses);
        let covariance = self.centre_covariance();
        let of_centre = block::<T, 0, 0>(&covariance);
        let offset_sigmas = self.offset_sigmas(machine);
        // Also for noise-free lengths: the geometry must give the accuracy with the rig's noise.
        let gate_noise = sigma_noise_mm.max(machine.noise_mm());
        let gate_variance = gate_noise * gate_noise;
        let accuracy = Accuracy {
            centre: &(of_centre * gate_variance),
            centre_alone: centre_alone(&self.centre_information).map(|alone| alone * gate_variance),
            worst_offset: offset_sigmas.map(|sigmas| worst(&sigmas, gate_noise)),
        };
        if let Err(refusal) = require_accuracy(&accuracy, self.settings.sigma_limit_mm) {
            return Stage::Done(Err(refusal));
        }
        self.write_result(machine, poses, &(covariance * (sigma_noise_mm * sigma_noise_mm)), noise_mm);
        if let Some(sigmas) = offset_sigmas {
            self.result.offset_sigmas_mm = sigmas.map(|sigma| sigma * sigma_noise_mm);
        }
        let check = if self.settings.require_redundancy {
            candidates(self.residuals.used, poses.len(), dominant)
        } else {
            None
        };
        // Without candidates the stage is left at once.
        let candidates = check.unwrap_or(Candidates { next: 0, last: 0 });
        Stage::Check(Check::new(candidates, worst_direction_of_point(&of_centre).0))
    }

    /// The result of a moving centre: its place at the mean direction of the arm.
    pub(super) fn accept_moving(&mut self, machine: &Machine<T>, poses: &[Pose<T>]) -> Stage<T> {
        let covariance = self.centre_covariance();
        let noise_mm = self.residuals.noise_mm;
        let offset_sigmas = self.offset_sigmas(machine);
        self.write_result(machine, poses, &(covariance * self.variance_mm2()), noise_mm);
        if let Some(sigmas) = offset_sigmas {
            self.result.offset_sigmas_mm = sigmas.map(|sigma| sigma * noise_mm);
        }
        let of_centre = block::<T, 0, 0>(&covariance);
        let none = Candidates { next: 0, last: 0 };
        Stage::Check(Check::new(none, worst_direction_of_point(&of_centre).0))
    }

    fn write_result(&mut self, machine: &Machine<T>, poses: &[Pose<T>], covariance: &Matrix6<T>, noise_mm: T) {
        let geometry = self.estimate.geometry();
        let result = &mut self.result;
        (result.parameters, result.covariance_mm2) = parameters_of(&self.centre, covariance, geometry);
        result.noise_mm = noise_mm;
        result.iterations = result.rms_residuals_mm.len() as u8;
        result.poses = poses.len() as u32;
        result.offsets_mm = self.estimate.offsets_mm(machine);
        result.machine = self.estimate.deviation(machine);
        result.rejected.clear();
        for (index, pose) in poses.iter().enumerate().filter(|(_, pose)| !pose.is_used()) {
            // The list holds the first; the poses' own states hold all.
            if result.rejected.push(Rejected { pose: index as u32, cables: pose.suspect_cables }).is_err() {
                break;
            }
        }
    }

    /// 1σ of the encoder offsets for a noise of 1 mm; `None` when they take no part.
    fn offset_sigmas(&self, machine: &Machine<T>) -> Option<[T; CABLES]> {
        let first = machine.first_offset()?;
        Some(core::array::from_fn(|k| non_negative_root(self.equations.variance(first + k))))
    }
}

/// The largest of the offsets' standard deviations, and its cable from 0.
fn worst<T: Real>(sigmas: &[T; CABLES], noise_mm: T) -> (usize, T) {
    let worse = |worst: (usize, T), next: (usize, &T)| if *next.1 > worst.1 { (next.0, *next.1) } else { worst };
    let (cable, sigma) = sigmas.iter().enumerate().fold((0, T::zero()), worse);
    (cable, sigma * noise_mm)
}

/// Covariance of O from the information on O and C alone: C eliminated.
fn centre_alone<T: Real>(information: &Matrix6<T>) -> Option<Matrix3<T>> {
    let first = block::<T, 0, 0>(information);
    let mixed = block::<T, 3, 0>(information);
    let second = block::<T, 3, 3>(information);
    let inverse = inverse_of_eliminated(&second, &second, smallest_pivot())?;
    inverse_of_eliminated(&(first - mixed.tr_mul(&(inverse * mixed))), &first, smallest_pivot())
}
