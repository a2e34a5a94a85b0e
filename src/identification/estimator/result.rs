//! From a converged fit to a result, and the explanation of the poses that were left out.

use super::Stage;
use super::check::Check;
use super::fit::Fit;
use crate::identification::fault_isolation::Isolation;
use crate::identification::gates::{Accuracy, require_accuracy};
use crate::identification::leave_one_out::{Candidates, candidates};
use crate::identification::machine::Machine;
use crate::identification::outcome::{MAX_REJECTED, Rejected};
use crate::identification::pose::Pose;
use crate::identification::uncertainty::{parameters_of, worst_direction_of_point};
use crate::kinematics::AttitudeSolver;
use crate::linear_algebra::{inverse_of_eliminated, non_negative_root};
use crate::linear_algebra::normal_equations::smallest_pivot;
use crate::rig::CABLES;
use crate::scalar::Real;
use nalgebra::{Matrix3, Matrix6};

impl<T: Real> Fit<T> {
    /// The gate of accuracy, then the result; `dominant`: the pose that makes most of the excitation.
    pub fn accept(&mut self, machine: &Machine<T>, poses: &[Pose<T>], dominant: Option<usize>) -> Stage<T> {
        let (noise_mm, sigma_noise_mm) = self.residuals.noise_of_result_mm(self.settings.noise, poses);
        let covariance = self.centre_covariance();
        let of_centre = covariance.fixed_view::<3, 3>(0, 0).into_owned();
        let offset_sigmas = self.offset_sigmas(machine);
        // Noise-free lengths must not pass a geometry that noise would ruin.
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
            self.result.offsets_mm = self.estimate.offsets_mm(machine);
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
        let of_centre = covariance.fixed_view::<3, 3>(0, 0).into_owned();
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
        result.rejected.clear();
        for (index, pose) in poses.iter().enumerate().filter(|(_, pose)| !pose.is_used()) {
            // The first of them; the poses themselves tell of all.
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
    let first = information.fixed_view::<3, 3>(0, 0).into_owned();
    let mixed = information.fixed_view::<3, 3>(3, 0).into_owned();
    let second = information.fixed_view::<3, 3>(3, 3).into_owned();
    let inverse = inverse_of_eliminated(&second, &second, smallest_pivot())?;
    inverse_of_eliminated(&(first - mixed.tr_mul(&(inverse * mixed))), &first, smallest_pivot())
}

/// The poses left out, one after the other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Isolate<T: Real> {
    /// The next pose, from 0.
    next: usize,
    /// How many of those left out are explained.
    explained: usize,
    isolation: Isolation<T>,
}

impl<T: Real> Default for Isolate<T> {
    fn default() -> Self {
        Self { next: 0, explained: 0, isolation: Isolation::default() }
    }
}

impl<T: Real> Isolate<T> {
    /// One attempt at one question about the next pose left out.
    pub fn advance(&mut self, fit: &mut Fit<T>, machine: &Machine<T>, poses: &mut [Pose<T>]) -> Option<Stage<T>> {
        let left_out = |(_, pose): &(usize, &mut Pose<T>)| !pose.is_used();
        let Some((index, pose)) = poses.iter_mut().enumerate().skip(self.next).find(left_out) else {
            return Some(Stage::Done(Ok(())));
        };
        let noise = fit.result.noise_mm.max(machine.noise_mm());
        let variance_mm2 = noise * noise * pose.relative_variance;
        let lengths = fit.estimate.corrected(machine, pose.lengths());
        let centre = fit.joint.centre_at(&fit.centre, &pose.rotation());
        let solver = AttitudeSolver { geometry: fit.estimate.geometry(), centre: &centre };
        let cables = self.isolation.advance(&solver, pose.attitude(), &lengths, variance_mm2)?;
        if cables != 0 {
            pose.suspect_cables = cables;
        }
        if let Some(rejected) = fit.result.rejected.get_mut(self.explained).filter(|_| self.explained < MAX_REJECTED) {
            *rejected = Rejected { pose: index as u32, cables: pose.suspect_cables };
        }
        *self = Self { next: index + 1, explained: self.explained + 1, isolation: Isolation::default() };
        None
    }
}
