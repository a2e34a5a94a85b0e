//! The normal equations of all logs: the machine's parameters are shared, each log has a joint centre of its own.
//!
//! Of each log the matrix [H X; Xᵀ M] of its joint centre (O, C) and the machine's parameters is summed; the six
//! unknowns of the joint centre are eliminated (Schur complement), and what is left of all logs is added:
//!
//! ```text
//! (prior + Σ (M - Xᵀ H⁻¹ X)) dm = Σ (a - Xᵀ H⁻¹ g),    then of each log    d = H⁻¹ (g - X dm)
//! ```
//!
//! Everything is in units of the noise: for lengths with a variance of 1 mm².

use super::wearing::Wearing;
use glenoid::identification::machine::MachineEstimate;
use glenoid::identification::marginal_information::MarginalInformation;
use glenoid::identification::parameters::{CentreFeatures, Column, Equations, ParameterBlock, PoseAt};
use glenoid::identification::pose::PoseState;
use glenoid::identification::pose_in_work::add_pose;
use glenoid::identification::weights::Weights;
use glenoid::identification::{Machine, Pose};
use glenoid::kinematics::rotation::turned;
use glenoid::kinematics::{AttitudeSolver, CableSet, LengthJacobian};
use glenoid::linear_algebra::packed_index;
use nalgebra::{DMatrix, DVector, Matrix3, Matrix6, Vector3, Vector6};
use rayon::prelude::*;

/// O and C.
const CENTRE_UNKNOWNS: usize = 6;

/// Poses summed by one worker at a time. Fixed, so that sums do not hang on the number of cores.
const CHUNK: usize = 2048;

/// χ² beyond which a pose's rotation itself is in question: the joint centre places it anew.
const HOPELESS: f64 = 100.0;

/// The machine's parameters as the block of parameters that every pose sees.
struct MachineBlock<'a> {
    machine: &'a Machine<f64>,
    estimate: &'a MachineEstimate<f64>,
}

impl ParameterBlock<f64> for MachineBlock<'_> {
    fn constants(&self) -> usize {
        self.estimate.count()
    }

    fn column(&self, index: usize, pose: &PoseAt<'_, f64>) -> Column<f64> {
        self.estimate.column(self.machine, index, pose)
    }

    fn features(&self, _: &Matrix3<f64>) -> CentreFeatures<f64> {
        CentreFeatures::new()
    }

    fn add_prior(&self, equations: &mut Equations<f64>, first: usize, variance_mm2: f64) {
        self.estimate.add_prior(self.machine, equations, first, variance_mm2);
    }
}

/// The sums of one log, and of the priors.
#[derive(Clone, Debug)]
pub struct Sums {
    /// Of the machine's parameters.
    pub machine: DMatrix<f64>,
    /// Of the joint centre with the machine's parameters.
    pub mixed: DMatrix<f64>,
    /// Of the joint centre.
    pub centre: Matrix6<f64>,
    /// Gradients of the same.
    pub machine_gradient: DVector<f64>,
    /// The joint centre's.
    pub centre_gradient: Vector6<f64>,
}

/// A log's joint centre has no solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Undetermined {
    /// Which log, from 0.
    pub log: usize,
}

/// The step of a pass and the covariance after it.
#[derive(Clone, Debug)]
pub struct Solution {
    /// Step of the machine's parameters.
    pub machine_step: DVector<f64>,
    /// Step of each log's joint centre, O then C, mm.
    pub centre_steps: Vec<Vector6<f64>>,
    /// Covariance of the machine's parameters, for a noise of 1 mm.
    pub machine_covariance: DMatrix<f64>,
    /// Covariance of each log's joint centre, for a noise of 1 mm.
    pub centre_covariances: Vec<Matrix6<f64>>,
}

/// Sums the poses of a log at the present estimate and refines their rotations.
pub fn sum(
    machine: &Machine<f64>,
    estimate: &MachineEstimate<f64>,
    wearing: &mut Wearing,
    weights: &Weights<f64>,
    variance_mm2: f64,
    place_anew: bool,
) -> Sums {
    let parameters = estimate.count();
    let block = MachineBlock { machine, estimate };
    let centre = &wearing.centre;
    let solver = AttitudeSolver { geometry: estimate.geometry(), centre };
    let of_chunk = |poses: &mut [Pose<f64>]| {
        let mut equations = Box::new(Equations::new(parameters + CENTRE_UNKNOWNS));
        for pose in poses {
            let lengths = estimate.corrected(machine, pose.lengths());
            if place_anew
                && !(pose.chi_square <= HOPELESS)
                && let Some(fit) = solver.solve(&lengths, CableSet::ALL)
            {
                pose.set_attitude(fit.attitude);
            }
            if !pose.is_placed() {
                continue;
            }
            pose.state = PoseState::Placed;
            let rotation = pose.rotation();
            let jacobian = LengthJacobian::new(estimate.geometry(), centre, &rotation, &lengths);
            let Ok(information) = MarginalInformation::new(&jacobian) else { continue };
            pose.refine_attitude(turned(pose.attitude(), &information.turn));
            pose.chi_square = information.squares_mm2() / (variance_mm2 * machine.relative_variance(pose.samples));
            let weight = weights.weight(0, pose.chi_square, false) / machine.relative_variance(pose.samples);
            // Neither zero nor NaN.
            if weight > 0.0 {
                pose.state = PoseState::Used;
                let at = PoseAt { rotation: &rotation, lengths: &lengths, jacobian: &jacobian };
                add_pose(&mut equations, &block, &at, &information, weight);
            }
        }
        Sums::of(&equations, parameters)
    };
    // Collected in order, then added: the same bits on one core and on many.
    let chunks: Vec<Sums> = wearing.poses.par_chunks_mut(CHUNK).map(of_chunk).collect();
    chunks.into_iter().fold(Sums::none(parameters), Sums::plus)
}

/// The priors of the machine's parameters.
pub fn prior(machine: &Machine<f64>, estimate: &MachineEstimate<f64>, variance_mm2: f64) -> Sums {
    let parameters = estimate.count();
    let mut equations = Box::new(Equations::new(parameters + CENTRE_UNKNOWNS));
    estimate.add_prior(machine, &mut equations, 0, variance_mm2);
    Sums::of(&equations, parameters)
}

impl Sums {
    /// Nothing known.
    pub fn none(parameters: usize) -> Self {
        Self {
            machine: DMatrix::zeros(parameters, parameters),
            mixed: DMatrix::zeros(CENTRE_UNKNOWNS, parameters),
            centre: Matrix6::zeros(),
            machine_gradient: DVector::zeros(parameters),
            centre_gradient: Vector6::zeros(),
        }
    }

    fn of(equations: &Equations<f64>, parameters: usize) -> Self {
        let entry = |i: usize, j: usize| equations.matrix()[packed_index(i.max(j), i.min(j))];
        let first = parameters;
        Self {
            machine: DMatrix::from_fn(parameters, parameters, entry),
            mixed: DMatrix::from_fn(CENTRE_UNKNOWNS, parameters, |i, j| entry(first + i, j)),
            centre: Matrix6::from_fn(|i, j| entry(first + i, first + j)),
            machine_gradient: DVector::from_fn(parameters, |i, _| equations.gradient()[i]),
            centre_gradient: Vector6::from_fn(|i, _| equations.gradient()[first + i]),
        }
    }

    fn plus(mut self, other: Self) -> Self {
        self.machine += other.machine;
        self.mixed += other.mixed;
        self.centre += other.centre;
        self.machine_gradient += other.machine_gradient;
        self.centre_gradient += other.centre_gradient;
        self
    }

    /// As if there were so many times as many poses.
    #[must_use]
    pub fn times(mut self, factor: f64) -> Self {
        self.machine *= factor;
        self.mixed *= factor;
        self.centre *= factor;
        self.machine_gradient *= factor;
        self.centre_gradient *= factor;
        self
    }

    /// Adds that the joint centre was measured to lie `off_mm` from where it is estimated, with this precision against
    /// that of a length.
    pub fn add_known_centre(&mut self, off_mm: &Vector3<f64>, precision: f64) {
        for i in 0..3 {
            self.centre[(i, i)] += precision;
            self.centre_gradient[i] += off_mm[i] * precision;
        }
    }
}

/// Eliminates each log's joint centre and solves for all.
///
/// # Errors
/// [`Undetermined`] names the log whose joint centre has no solution.
pub fn solve(prior: &Sums, logs: &[Sums]) -> Result<Solution, Undetermined> {
    let mut matrix = prior.machine.clone();
    let mut gradient = prior.machine_gradient.clone();
    let mut inverses = Vec::with_capacity(logs.len());
    for (log, sums) in logs.iter().enumerate() {
        let inverse = sums.centre.cholesky().ok_or(Undetermined { log })?.inverse();
        matrix += &sums.machine - sums.mixed.tr_mul(&(inverse * &sums.mixed));
        gradient += &sums.machine_gradient - sums.mixed.tr_mul(&(inverse * sums.centre_gradient));
        inverses.push(inverse);
    }
    // Positive definite by its priors.
    let machine_covariance = matrix.cholesky().ok_or(Undetermined { log: 0 })?.inverse();
    let machine_step = &machine_covariance * gradient;
    let of_log = |(sums, inverse): (&Sums, &Matrix6<f64>)| {
        let gain = inverse * &sums.mixed;
        let step = inverse * sums.centre_gradient - &gain * &machine_step;
        let spread = &gain * &machine_covariance * gain.transpose();
        (Vector6::from_column_slice(step.as_slice()), inverse + Matrix6::from_column_slice(spread.as_slice()))
    };
    let (centre_steps, centre_covariances) = logs.iter().zip(&inverses).map(of_log).unzip();
    Ok(Solution { machine_step, centre_steps, machine_covariance, centre_covariances })
}
