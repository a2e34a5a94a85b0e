//! The last fit against any pose: its residuals by χ², the joint centre that the model predicts in it, and the one that
//! its six lengths give.

use super::Estimator;
use super::fit::Fit;
use super::seen_pose::SeenPose;
use crate::identification::joint::Joint;
use crate::identification::machine::Machine;
use crate::identification::marginal_information::MarginalInformation;
use crate::identification::parameters::{CENTRE_UNKNOWNS, Equations, MAX_UNKNOWNS, Rows};
use crate::identification::pose::Pose;
use crate::identification::verification::{CentrePrediction, VerifiedPose};
use crate::kinematics::rotation::{rotation_of, turned};
use crate::kinematics::{AttitudeSearch, AttitudeSolver, AttitudeTrack, CableLengths, CableSet};
use crate::linear_algebra::{dot, inverse_of_positive_definite, rounding, solve_positive_definite};
use crate::scalar::Real;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

/// Gauss-Newton steps with the motion of the centre included, after those about a fixed one.
const TURNS: u8 = 2;

/// The verification of a pose, a slice at a time.
#[derive(Clone, Copy, Debug)]
pub struct PoseVerification<T: Real>(Step<T>);

impl<T: Real> Default for PoseVerification<T> {
    fn default() -> Self {
        Self(Step::Place)
    }
}

#[derive(Clone, Copy, Debug)]
enum Step<T: Real> {
    /// Its rotation about the estimated centre is to be found.
    Place,
    /// From the one that the platform has, or from the best of the search.
    Track { track: AttitudeTrack<T>, start: UnitQuaternion<T>, is_last: bool },
    /// The centre moves with the rotation: so many Gauss-Newton steps more, with that included.
    Turn { attitude: UnitQuaternion<T>, left: u8, is_last: bool },
    /// From nothing. A moving centre is taken where the rotation so far has it.
    Search { before: UnitQuaternion<T>, search: AttitudeSearch<T> },
    /// It is there: what does it say of the centre?
    See(UnitQuaternion<T>),
    /// Its equations go to work.
    Begin(Evidence<T>),
    /// Their columns.
    Columns(Evidence<T>),
    /// Their covariance: they are whitened.
    Whiten(Evidence<T>),
}

/// What a pose says of the centre.
#[derive(Clone, Copy, Debug)]
struct Evidence<T> {
    information: Matrix3<T>,
    gradient_mm: Vector3<T>,
    squares_mm2: T,
}

impl<T: Real> Step<T> {
    fn track(start: UnitQuaternion<T>, is_last: bool) -> Self {
        Self::Track { track: AttitudeTrack::new(start), start, is_last }
    }
}

impl<T: Real> Evidence<T> {
    fn of(seen: &SeenPose<T>) -> Self {
        let (information, gradient_mm) = (seen.marginal.information(), seen.marginal.gradient_mm());
        Self { information, gradient_mm, squares_mm2: seen.squares_mm2 }
    }
}

impl<T: Real> Estimator<T> {
    /// Verifies a pose: its residuals about the estimated centre, tested against the noise and the covariance of the
    /// estimate. `None` when no rotation fits its lengths.
    pub fn verify(&self, machine: &Machine<T>, pose: &Pose<T>) -> Option<VerifiedPose<T>> {
        let fit = &self.fit;
        let seen = fit.seen(machine, &fit.place_about_centre(machine, pose)?)?;
        fit.verified(
            machine.relative_variance(pose.samples),
            &Evidence::of(&seen),
            &fit.covariance_of(&fit.sensitivity(machine, &seen)),
        )
    }

    /// The same a slice at a time; after the last the result, or that no rotation fits.
    pub fn verify_slice(
        &mut self,
        verification: &mut PoseVerification<T>,
        machine: &Machine<T>,
        pose: &Pose<T>,
    ) -> Option<Option<VerifiedPose<T>>> {
        let fit = &mut self.fit;
        let PoseVerification(step) = verification;
        *step = match *step {
            Step::Place => {
                let mut placed = *pose;
                if !pose.is_placed() {
                    placed.place(machine.platform());
                }
                Step::track(*placed.attitude(), false)
            }
            Step::Track { .. } | Step::Turn { .. } | Step::Search { .. } => {
                match fit.place_slice(step, machine, pose.lengths()) {
                    Some(next) => next,
                    None => return Some(None),
                }
            }
            Step::See(attitude) => {
                let mut placed = *pose;
                placed.set_attitude(attitude);
                let Some(seen) = fit.see(machine, &placed) else { return Some(None) };
                Step::Begin(Evidence::of(seen))
            }
            Step::Begin(evidence) => {
                fit.put_to_work();
                Step::Columns(evidence)
            }
            Step::Columns(evidence) => {
                if fit.add_columns(machine) {
                    let Some(in_work) = fit.scratch.pose() else { return Some(None) };
                    let rows = in_work.sensitivity();
                    fit.scratch.put_rows(&rows);
                    Step::Whiten(evidence)
                } else {
                    Step::Columns(evidence)
                }
            }
            Step::Whiten(evidence) if !fit.whiten() => Step::Whiten(evidence),
            Step::Whiten(evidence) => {
                return Some(fit.verified(
                    machine.relative_variance(pose.samples),
                    &evidence,
                    &fit.covariance_of_whitened(),
                ));
            }
        };
        None
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
        let askew = fit.joint.askew_covariance_mm2(rotation);
        let of_pose = inverse_of_positive_definite(&seen.unscattered, rounding())?;
        let variance = fit.result_variance_mm2() * machine.relative_variance(pose.samples);
        Some(CentrePrediction {
            predicted_mm: centre,
            predicted_covariance_mm2: fit.covariance_of(&fit.path_rows(rotation)) * factor
                + Matrix3::from_diagonal_element(lack_of_fit)
                + askew,
            live_mm: centre + seen.own_centre_mm,
            live_covariance_mm2: of_pose * variance
                + fit.covariance_of(&fit.live_rows(&seen, &fit.sensitivity(machine, &seen))?) * factor
                + askew,
        })
    }
}

impl<T: Real> Fit<T> {
    /// A slice of what [`place_about_centre`](Self::place_about_centre) does; `None` when no rotation fits.
    fn place_slice(&self, now: &Step<T>, machine: &Machine<T>, lengths: &CableLengths<T>) -> Option<Step<T>> {
        let lengths = self.estimate.corrected(machine, lengths);
        let geometry = self.estimate.geometry();
        // What comes when one start has led to nothing.
        let without = |before: UnitQuaternion<T>, is_last: bool| {
            (!is_last).then(|| Step::Search { before, search: AttitudeSearch::new() })
        };
        match *now {
            Step::Track { mut track, start, is_last } => {
                let centre = self.joint.centre_at(&self.centre, &rotation_of(&start));
                let solver = AttitudeSolver { geometry, centre: &centre };
                match track.advance(&solver, &lengths, CableSet::ALL) {
                    None => Some(Step::Track { track, start, is_last }),
                    Some(None) => without(start, is_last),
                    Some(Some(fit)) => Some(match self.joint {
                        Joint::Moving(_) => Step::Turn { attitude: fit.attitude, left: TURNS, is_last },
                        Joint::Ball | Joint::Held(_) => Step::See(fit.attitude),
                    }),
                }
            }
            Step::Turn { attitude, left, is_last } => {
                let jacobian = self.jacobian(&rotation_of(&attitude), &lengths);
                let Ok(information) = MarginalInformation::new(&jacobian) else { return without(attitude, is_last) };
                let attitude = turned(&attitude, &information.turn);
                Some(match left {
                    0 | 1 => Step::See(attitude),
                    _ => Step::Turn { attitude, left: left - 1, is_last },
                })
            }
            Step::Search { before, mut search } => {
                let centre = self.joint.centre_at(&self.centre, &rotation_of(&before));
                if search.advance(&AttitudeSolver { geometry, centre: &centre }, &lengths, CableSet::ALL) {
                    return Some(Step::track(search.best()?.attitude, true));
                }
                Some(Step::Search { before, search })
            }
            done => Some(done),
        }
    }

    /// With g = S δ̂ of the pose, K Σ Kᵀ the covariance of what g loses to the estimate and λ² the variance that the joint's
    /// model does not explain, χ² = gᵀ (σ² S + K Σ Kᵀ + λ² S²)⁻¹ g. `relative_variance`: of the pose's lengths.
    fn verified(
        &self,
        relative_variance: T,
        evidence: &Evidence<T>,
        covariance: &Matrix3<T>,
    ) -> Option<VerifiedPose<T>> {
        let Evidence { information, gradient_mm: g, squares_mm2 } = *evidence;
        let (lack_of_fit, factor) = (self.joint.lack_of_fit_mm2(), self.joint.variance_factor());
        let expected = information * (self.result_variance_mm2() * relative_variance)
            + covariance * factor
            + information * information * lack_of_fit;
        let chi_square = g.dot(&solve_positive_definite(&expected, &g, rounding())?);
        Some(VerifiedPose { squares_mm2, chi_square })
    }

    /// Variance of the noise that the result is reported with, mm².
    fn result_variance_mm2(&self) -> T {
        self.result.noise_mm * self.result.noise_mm
    }

    /// Covariance of three linear functions of the unknowns, mm².
    pub(super) fn covariance_of(&self, rows: &Rows<T>) -> Matrix3<T> {
        self.covariance_by(&self.equations, rows)
    }

    /// The same by equations that know more.
    pub(super) fn covariance_by(&self, equations: &Equations<T>, rows: &Rows<T>) -> Matrix3<T> {
        let mut whitened = *rows;
        whitened.iter_mut().for_each(|row| equations.whiten(row));
        self.covariance_of_rows(&whitened)
    }

    /// The same of the first three rows that are at work, once they are whitened.
    pub(super) fn covariance_of_whitened(&self) -> Matrix3<T> {
        self.covariance_of_rows(self.scratch.rows())
    }

    fn covariance_of_rows(&self, whitened: &[[T; MAX_UNKNOWNS]]) -> Matrix3<T> {
        let noise_mm = self.result.noise_mm.max(self.residuals.noise_mm);
        Matrix3::from_fn(|i, j| self.product_of_rows(whitened, i, j)) * (noise_mm * noise_mm)
    }

    /// The product of two rows.
    pub(super) fn product_of_rows(&self, rows: &[[T; MAX_UNKNOWNS]], i: usize, j: usize) -> T {
        let (Some(a), Some(b)) = (rows.get(i), rows.get(j)) else { return T::zero() };
        dot(a.get(..self.equations.unknowns()).unwrap_or_default(), b)
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
    fn live_rows(&self, seen: &SeenPose<T>, sensitivity: &Rows<T>) -> Option<Rows<T>> {
        let inverse = inverse_of_positive_definite(&seen.marginal.information(), rounding())?;
        let mut rows = self.path_rows(&seen.rotation);
        for unknown in 0..self.equations.unknowns() {
            let changes = sensitivity.each_ref().map(|row| row.get(unknown).copied().unwrap_or_else(T::zero));
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
