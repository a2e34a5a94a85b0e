//! From a converged fit to a result with its covariance.

use super::fit::Fit;
use crate::identification::gates::{Accuracy, require_accuracy};
use crate::identification::leave_one_out::{Candidates, candidates};
use crate::identification::machine::Machine;
use crate::identification::outcome::Rejected;
use crate::identification::parameters::{CENTRE_UNKNOWNS, MAX_UNKNOWNS};
use crate::identification::pose::Pose;
use crate::identification::refusal::Refusal;
use crate::identification::uncertainty::{ShapeShare, parameters_of, unpacked, worst_direction_of_point};
use crate::linear_algebra::normal_equations::smallest_pivot;
use crate::linear_algebra::{block, inverse_of_eliminated, non_negative_root, unit};
use crate::rig::CABLES;
use crate::scalar::Real;
use nalgebra::{Matrix3, Matrix6, Vector3};

/// Columns of the covariance of O and C a slice.
const COLUMNS_A_SLICE: usize = 2;
/// Offsets whose standard deviations are worked out together.
const OFFSETS_AT_ONCE: usize = 3;

/// What is accepted.
#[derive(Clone, Copy, Debug)]
pub(super) enum Accepted {
    /// A ball joint, once the gate of accuracy is passed. `dominant`: the pose that makes most of the excitation, from 0.
    Ball {
        /// See above.
        dominant: Option<usize>,
    },
    /// A moving centre, whose gates are passed: its place at the mean direction of the arm.
    Moving,
}

/// From a converged fit to its result, a slice at a time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Acceptance<T> {
    of: Accepted,
    columns: usize,
    /// Of O and C, for a noise of 1 mm.
    covariance: Matrix6<T>,
    /// Of the result, and for its standard deviations, mm; known once the gate is passed.
    noise_mm: Option<(T, T)>,
    /// For a noise of 1 mm; so many of them are known.
    offset_sigmas: [T; CABLES],
    offsets: usize,
    has_begun_offsets: bool,
    /// What the platform's shape adds to the covariance, for a noise of 1 mm; so many of its parameters are included.
    of_shape: ShapeShare<T>,
    in_shape: usize,
    /// The covariances of the next one are being computed.
    has_begun_shape: bool,
    /// Of O and C as it is reported, mm².
    reported_mm2: Option<Matrix6<T>>,
    /// The result is written.
    is_written: bool,
}

impl<T: Real> Acceptance<T> {
    /// Begins.
    pub fn new(of: Accepted) -> Self {
        Self {
            of,
            columns: 0,
            covariance: Matrix6::zeros(),
            noise_mm: None,
            offset_sigmas: [T::zero(); CABLES],
            offsets: 0,
            has_begun_offsets: false,
            of_shape: ShapeShare::none(),
            in_shape: 0,
            has_begun_shape: false,
            reported_mm2: None,
            is_written: false,
        }
    }

    /// The next slice: columns of the covariance, then the gate, then the result. Gives what is to be left out in turn, and
    /// the centre's standard deviation in its worst direction for a noise of 1 mm; or a refusal.
    pub fn advance(
        &mut self,
        fit: &mut Fit<T>,
        machine: &Machine<T>,
        poses: &[Pose<T>],
    ) -> Option<Result<(Candidates, T), Refusal>> {
        if self.columns < CENTRE_UNKNOWNS {
            for column in self.columns..CENTRE_UNKNOWNS.min(self.columns + COLUMNS_A_SLICE) {
                fit.put_centre_covariance_column(&mut self.covariance, column);
            }
            self.columns += COLUMNS_A_SLICE;
            return None;
        }
        if let Some(first) = machine.first_offset()
            && self.offsets < CABLES
        {
            self.add_offset_sigmas(fit, first + self.offsets);
            return None;
        }
        let Some((noise_mm, sigma_noise_mm)) = self.noise_mm else {
            self.noise_mm = Some(match self.of {
                Accepted::Ball { .. } => fit.residuals.noise_of_result_mm(fit.settings.noise, poses),
                Accepted::Moving => (fit.residuals.noise_mm, fit.residuals.noise_mm),
            });
            return self.gate(fit, machine).err().map(Err);
        };
        if let Some(index) = machine.platform_shape().nth(self.in_shape).filter(|_| fit.estimate.count() > 0) {
            if !self.has_begun_shape {
                fit.begin_shape_share(machine, index);
                self.has_begun_shape = true;
            } else if fit.solve() {
                fit.add_shape_share(machine, index, &mut self.of_shape);
                self.has_begun_shape = false;
                self.in_shape += 1;
            }
            return None;
        }
        let widened = match self.of {
            Accepted::Ball { .. } => T::one(),
            Accepted::Moving => fit.joint.variance_factor(),
        };
        let variance = sigma_noise_mm * sigma_noise_mm * widened;
        let Some(reported_mm2) = self.reported_mm2 else {
            self.reported_mm2 = Some(self.covariance * variance + fit.joint.askew_covariance_of_centre_mm2());
            return None;
        };
        if !self.is_written {
            fit.write_result(machine, poses, &[reported_mm2, self.of_shape.covariance_mm2 * variance], noise_mm);
            if machine.first_offset().is_some() {
                fit.result.offset_sigmas_mm = self.offset_sigmas.map(|sigma| sigma * sigma_noise_mm);
            }
            self.is_written = true;
            return None;
        }
        let check = match self.of {
            Accepted::Ball { dominant } if fit.settings.require_redundancy => {
                candidates(fit.residuals.used, poses.len(), dominant)
            }
            _ => None,
        };
        // Without candidates the stage is left at once.
        let candidates = check.unwrap_or(Candidates { next: 0, last: 0 });
        Some(Ok((candidates, worst_direction_of_point(&block::<T, 0, 0>(&self.covariance)).0)))
    }

    /// Whitens three unit vectors at a time, of the offsets from unknown `first` on: their lengths are the standard deviations.
    fn add_offset_sigmas(&mut self, fit: &mut Fit<T>, first: usize) {
        if !self.has_begun_offsets {
            let mut units = [[T::zero(); MAX_UNKNOWNS]; OFFSETS_AT_ONCE];
            for (index, unit) in units.iter_mut().enumerate() {
                if let Some(entry) = unit.get_mut(first + index) {
                    *entry = T::one();
                }
            }
            fit.scratch.put_rows(&units);
            self.has_begun_offsets = true;
        } else if fit.whiten() {
            let sigmas = self.offset_sigmas.iter_mut().skip(self.offsets);
            for (index, sigma) in sigmas.enumerate().take(OFFSETS_AT_ONCE) {
                *sigma = non_negative_root(fit.product_of_rows(fit.scratch.rows(), index, index));
            }
            self.offsets += OFFSETS_AT_ONCE;
            self.has_begun_offsets = false;
        }
    }

    /// The gate of accuracy of a ball joint.
    fn gate(&self, fit: &Fit<T>, machine: &Machine<T>) -> Result<(), Refusal> {
        let (Accepted::Ball { .. }, Some((_, sigma_noise_mm))) = (self.of, self.noise_mm) else { return Ok(()) };
        // Also for noise-free lengths: the geometry must give the accuracy with the rig's noise.
        let gate_noise = sigma_noise_mm.max(machine.noise_mm());
        let gate_variance = gate_noise * gate_noise;
        let accuracy = Accuracy {
            centre: &(block::<T, 0, 0>(&self.covariance) * gate_variance),
            centre_alone: centre_alone(&unpacked(&fit.centre_information)).map(|alone| alone * gate_variance),
            worst_offset: machine.first_offset().map(|_| worst(&self.offset_sigmas, gate_noise)),
        };
        require_accuracy(&accuracy, fit.settings.sigma_limit_mm)
    }
}

impl<T: Real> Fit<T> {
    /// The covariances of one parameter of the platform's shape go to work.
    fn begin_shape_share(&mut self, machine: &Machine<T>, index: usize) {
        let mut unit = [T::zero(); MAX_UNKNOWNS];
        if let Some(entry) = unit.get_mut(index) {
            *entry = T::one();
        }
        self.scratch.put_right(&unit, machine.platform_shape().start);
    }

    /// Adds what that parameter does to the covariance of centre and radii, once they are known.
    fn add_shape_share(&self, machine: &Machine<T>, index: usize, share: &mut ShapeShare<T>) {
        let shape = machine.platform_shape();
        let column = self.scratch.solution();
        let entry = |unknown: usize| column.get(unknown).copied().unwrap_or_else(T::zero);
        let first = self.equations.unknowns() - CENTRE_UNKNOWNS;
        let point = |at: usize| Vector3::new(entry(at), entry(at + 1), entry(at + 2));
        let end_points = self.estimate.geometry().end_points_mm();
        let directions = end_points.map(|end_point| unit(&(end_point - self.centre.in_platform_mm)));
        let all_moved = shape.map(|other| (machine.end_points_moved(other), entry(other)));
        let moved = machine.end_points_moved(index);
        share.add(&directions, &moved, all_moved, &[point(first), point(first + 3)]);
    }

    fn write_result(&mut self, machine: &Machine<T>, poses: &[Pose<T>], covariances: &[Matrix6<T>; 2], noise_mm: T) {
        let geometry = self.estimate.geometry();
        let result = &mut self.result;
        (result.parameters, result.covariance_mm2) =
            parameters_of(&self.centre, &covariances[0], &covariances[1], geometry);
        result.noise_mm = noise_mm;
        result.iterations = result.rms_residuals_mm.len() as u8;
        result.poses = poses.len() as u32;
        result.offsets_mm = self.estimate.offsets_mm();
        result.machine = self.estimate.deviation(machine);
        result.rejected.clear();
        for (index, pose) in poses.iter().enumerate().filter(|(_, pose)| !pose.is_used()) {
            // The list holds the first; the poses' own states hold all.
            if result.rejected.push(Rejected { pose: index as u32, cables: pose.suspect_cables }).is_err() {
                break;
            }
        }
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
