//! The paper's identification: Fig. 4, iterated least squares from a start estimate.

use super::SixUnknowns;
use super::model::{Contradiction, Model};
use super::pass_sum::PassSum;
use crate::identification::machine::MachineDeviation;
use crate::identification::outcome::{
    Identified, MAX_ITERATIONS, Progress, RESULT_PACKED, RESULT_UNKNOWNS, Refusal, Termination, rms_residual,
};
use crate::identification::uncertainty::packed;
use crate::kinematics::{BaseEdges, CableLengths};
use crate::linear_algebra::Singular;
use crate::rig::{CABLES, Parameters, Rig};
use crate::scalar::Real;
use heapless::Vec;
use nalgebra::{Matrix6, Vector6};

/// Minimum number of poses. The paper's bound of two is not enough: for two poses the centre is free along the axis of
/// their relative rotation.
pub const MIN_POSES: usize = 3;

/// Poses a slice: 25 000 cycles of a Cortex-M4F, 0.15 ms at 170 MHz.
pub const POSES_A_SLICE: usize = 32;

/// When the iteration ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaperSettings<T> {
    /// ε: the iteration ends when δE or the largest change of a parameter falls below it, mm.
    pub tolerance_mm: T,
    /// Maximum number of steps, at most [`MAX_ITERATIONS`].
    pub iteration_cap: u8,
}

impl<T: Real> Default for PaperSettings<T> {
    /// The paper's ε = 1e-3 mm, and a cap of 20 steps (it needs four or five).
    fn default() -> Self {
        Self { tolerance_mm: T::of(1e-3), iteration_cap: 20 }
    }
}

/// The iteration of Fig. 4, resumable: each call of [`advance`](Self::advance) does a bounded slice of work.
#[derive(Clone, Debug)]
pub struct PaperIteration<T> {
    settings: PaperSettings<T>,
    base: BaseEdges<T>,
    parameters: Parameters<T>,
    model: Model<T>,
    sum: PassSum<T>,
    /// Y^T Y of a pass that measures the residuals only, mm²; `sum` is that of the pass before then.
    closing: Option<T>,
    next_pose: usize,
    largest_step_mm: Option<T>,
    rms_residuals_mm: Vec<T, { MAX_ITERATIONS + 1 }>,
}

impl<T: Real> PaperIteration<T> {
    /// An iteration that begins at `start`.
    pub fn new(rig: &Rig<T>, start: Parameters<T>, settings: PaperSettings<T>) -> Self {
        let base = BaseEdges::new(rig);
        Self {
            settings,
            model: Model::new(&base, rig.edges_mm(), &start),
            base,
            parameters: start,
            sum: PassSum::new(),
            closing: None,
            next_pose: 0,
            largest_step_mm: None,
            rms_residuals_mm: Vec::new(),
        }
    }

    /// Runs to the end. `poses` are the cable lengths of the first set.
    ///
    /// # Errors
    /// The [`Refusal`] that names the cause, and the pose where there is one.
    pub fn run(mut self, poses: &[CableLengths<T>]) -> Result<Identified<T>, Refusal> {
        loop {
            match self.advance(poses) {
                Progress::Working => {}
                Progress::Identified(identified) => return Ok(identified),
                Progress::Refused(refusal) => return Err(refusal),
            }
        }
    }

    /// One slice: evaluates the next poses ([`POSES_A_SLICE`] at most) with the model; after the last pose takes a
    /// step. `poses` must be the same in every call.
    pub fn advance(&mut self, poses: &[CableLengths<T>]) -> Progress<Identified<T>> {
        if poses.len() < MIN_POSES {
            return Progress::Refused(Refusal::TooFewPoses { poses: poses.len() as u32 });
        }
        match poses.get(self.next_pose..) {
            Some(left) if !left.is_empty() => match self.add_poses(left) {
                Ok(()) => Progress::Working,
                Err(refusal) => Progress::Refused(refusal),
            },
            _ => self.finish_pass(poses.len()),
        }
    }

    /// Steps taken so far.
    pub fn iterations(&self) -> u8 {
        self.rms_residuals_mm.len() as u8
    }

    fn add_poses(&mut self, left: &[CableLengths<T>]) -> Result<(), Refusal> {
        let slice = left.get(..POSES_A_SLICE).unwrap_or(left);
        for (index, lengths) in slice.iter().enumerate() {
            let Self { base, model, sum, closing, .. } = &mut *self;
            match model.evaluate(base, lengths) {
                Ok(pose) => match closing {
                    Some(squares_mm2) => *squares_mm2 += pose.squares_mm2(),
                    None => sum.add(&pose, &model.edge_jacobian(&pose)),
                },
                Err(contradiction) => {
                    self.next_pose += index;
                    return Err(self.refusal(contradiction));
                }
            }
        }
        self.next_pose += slice.len();
        Ok(())
    }

    fn refusal(&self, contradiction: Contradiction) -> Refusal {
        let pose = self.next_pose as u32;
        match contradiction {
            Contradiction::Length(error) => Refusal::BadLength { pose, cable: error.cable, fault: error.fault },
            Contradiction::NotClosing(error) => {
                Refusal::NotClosing { pose, end_point: error.end_point, iteration: self.iterations() }
            }
        }
    }

    /// δE of this pass; then either the end or the next step (Eq. 15, 16).
    fn finish_pass(&mut self, poses: usize) -> Progress<Identified<T>> {
        let closing = self.closing.take();
        let squares_mm2 = closing.unwrap_or(self.sum.squares());
        let rms_residual_mm = rms_residual(squares_mm2, poses);
        let tolerance_mm = self.settings.tolerance_mm;
        let termination = if rms_residual_mm < tolerance_mm {
            Some(Termination::DeviationBelowTolerance)
        } else if self.largest_step_mm.is_some_and(|step| step < tolerance_mm) {
            Some(Termination::Settled)
        } else {
            None
        };
        if closing.is_some() && termination.is_none() {
            // It is not the last pass after all: once more, in full.
            self.begin_pass();
            return Progress::Working;
        }
        let cap_reached = self.iterations() >= self.settings.iteration_cap;
        if self.rms_residuals_mm.push(rms_residual_mm).is_err() || (termination.is_none() && cap_reached) {
            return Progress::Refused(Refusal::IterationCap);
        }
        if let Some(termination) = termination {
            return self.identified(squares_mm2, termination, poses);
        }
        match self.step(poses) {
            Ok(()) => Progress::Working,
            Err(Singular) => Progress::Refused(Refusal::Singular),
        }
    }

    fn equations(&self) -> SixUnknowns<T> {
        self.sum.normal_equations(&self.base, &self.parameters.radii_mm)
    }

    /// Takes a step and makes everything ready for the next pass.
    fn step(&mut self, poses: usize) -> Result<(), Singular> {
        let (step, squares_after_mm2, pivot_ratio) = self.solve()?;
        let largest_mm = step.iter().fold(T::zero(), |largest, x| largest.max(x.abs()));
        self.largest_step_mm = Some(largest_mm);
        self.parameters = self.parameters.moved_by(&step);
        self.model.move_to(&self.base, &self.parameters);
        if self.will_be_last(poses, pivot_ratio, squares_after_mm2, largest_mm) {
            self.next_pose = 0;
            self.closing = Some(T::zero());
        } else {
            self.begin_pass();
        }
        Ok(())
    }

    /// The step, mm, YᵀY that it leaves, mm², and the pivot ratio of the equations.
    fn solve(&self) -> Result<([T; RESULT_UNKNOWNS], T, T), Singular> {
        let mut equations = self.equations();
        equations.factor()?;
        let step = equations.step();
        Ok((step, equations.squares_after(&step), equations.pivot_ratio()))
    }

    fn begin_pass(&mut self) {
        self.sum = PassSum::new();
        self.next_pose = 0;
    }

    /// Will the next pass end the iteration? It needs no D then: a step this small changes the normal matrix by less
    /// than a hundredth, and the covariance is computed from the last one. Saves a tenth of the whole time.
    fn will_be_last(&self, poses: usize, pivot_ratio: T, predicted_mm2: T, largest_mm: T) -> bool {
        let tolerance_mm = self.settings.tolerance_mm;
        if largest_mm < tolerance_mm {
            return true;
        }
        // What the step leaves: the residuals that it does not explain, and about its square over the rig's size.
        let explained = rms_residual(predicted_mm2, poses) < tolerance_mm * T::of(0.5);
        let size_mm = self.parameters.radii_mm.iter().fold(T::zero(), |size, p| size.max(*p));
        let straight = largest_mm * largest_mm < tolerance_mm * size_mm * T::of(0.25);
        // Whether poses about one axis determine the centre is only seen at the end: those get the whole pass.
        explained && straight && pivot_ratio < T::of(1e4)
    }

    /// The classical covariance of unweighted least squares, s² (DᵀD)⁻¹.
    fn covariance(&self, variance_mm2: T) -> Result<[T; RESULT_PACKED], Singular> {
        let mut equations = self.equations();
        equations.factor()?;
        let columns: [Vector6<T>; RESULT_UNKNOWNS] =
            core::array::from_fn(|column| equations.covariance_column(column, 0).into());
        Ok(packed(&(Matrix6::from_columns(&columns) * variance_mm2)))
    }

    /// The result, with s² = YᵀY / (3m - 6).
    fn identified(&self, squares_mm2: T, termination: Termination, poses: usize) -> Progress<Identified<T>> {
        let variance_mm2 = squares_mm2 / T::of_integer(3 * poses as i32 - RESULT_UNKNOWNS as i32);
        let Ok(covariance_mm2) = self.covariance(variance_mm2) else { return Progress::Refused(Refusal::Singular) };
        Progress::Identified(Identified {
            parameters: self.parameters,
            covariance_mm2,
            noise_mm: variance_mm2.root(),
            rms_residual_mm: rms_residual(squares_mm2, poses),
            rms_residuals_mm: self.rms_residuals_mm.clone(),
            iterations: self.iterations() - 1,
            termination,
            poses: poses as u32,
            rejected: Vec::new(),
            excitation_rad: T::of(f64::INFINITY),
            offsets_mm: [T::zero(); CABLES],
            offset_sigmas_mm: [T::zero(); CABLES],
            machine: MachineDeviation::none(),
        })
    }
}
