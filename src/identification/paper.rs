//! The paper's identification: Fig. 4, iterated least squares from a start estimate.

use super::model::{Contradiction, Model};
use super::normal_equations::{Factors, UNKNOWNS};
use super::outcome::{Identified, MOST_ITERATIONS, Progress, Refusal, Termination, deviation};
use super::pass_sum::PassSum;
use crate::kinematics::{BaseEdges, CableLengths};
use crate::rig::{CABLES, POINTS, Parameters, Rig};
use crate::scalar::Real;
use heapless::Vec;

/// Fewest poses that can determine the centre. The paper's bound of two is not enough: for two poses the centre is
/// free along the axis of their relative rotation.
pub const FEWEST_POSES: usize = 3;

/// Poses of a slice: 25 000 cycles of a Cortex-M4F, 0.15 ms at 170 MHz. Beginning one takes as long as half a pose.
pub const POSES_A_SLICE: usize = 32;

/// When the iteration ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaperSettings<T> {
    /// ε: the iteration ends when δE or the largest change of a parameter falls below it, mm.
    pub tolerance_mm: T,
    /// Steps after which it gives up, at most [`MOST_ITERATIONS`].
    pub iteration_cap: u8,
}

impl<T: Real> Default for PaperSettings<T> {
    /// The paper's ε = 1e-3 mm, and a cap of 20 steps (it needs four or five).
    fn default() -> Self {
        Self { tolerance_mm: T::of(1e-3), iteration_cap: 20 }
    }
}

/// The iteration of Fig. 4, resumable: each call of [`advance`](Self::advance) does the work of one pose.
#[derive(Clone, Debug)]
pub struct PaperIteration<T> {
    settings: PaperSettings<T>,
    base: BaseEdges<T>,
    edges_mm: [T; POINTS],
    parameters: Parameters<T>,
    model: Model<T>,
    sum: PassSum<T>,
    next_pose: usize,
    largest_step_mm: Option<T>,
    deviations_mm: Vec<T, { MOST_ITERATIONS + 1 }>,
}

impl<T: Real> PaperIteration<T> {
    /// An iteration that begins at `start`.
    pub fn new(rig: &Rig<T>, start: Parameters<T>, settings: PaperSettings<T>) -> Self {
        let base = BaseEdges::new(rig);
        let edges_mm = *rig.edges_mm();
        Self {
            settings,
            model: Model::new(&base, &edges_mm, &start),
            base,
            edges_mm,
            parameters: start,
            sum: PassSum::new(),
            next_pose: 0,
            largest_step_mm: None,
            deviations_mm: Vec::new(),
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

    /// One slice: lays the next poses against the model ([`POSES_A_SLICE`] at most), and after the last pose takes a
    /// step. `poses` must be the same in every call.
    pub fn advance(&mut self, poses: &[CableLengths<T>]) -> Progress<T> {
        if poses.len() < FEWEST_POSES {
            return Progress::Refused(Refusal::TooFewPoses { poses: poses.len() as u16 });
        }
        let outcome = match poses.get(self.next_pose..) {
            Some(left) if !left.is_empty() => self.add_poses(left).map(|()| None),
            _ => self.finish_pass(poses.len()),
        };
        match outcome {
            Ok(None) => Progress::Working,
            Ok(Some(identified)) => Progress::Identified(identified),
            Err(refusal) => Progress::Refused(refusal),
        }
    }

    /// Steps taken so far.
    pub fn iterations(&self) -> u8 {
        self.deviations_mm.len() as u8
    }

    #[inline(never)]
    fn add_poses(&mut self, left: &[CableLengths<T>]) -> Result<(), Refusal> {
        // The sums by value: in place, each of them would be stored twice a pose.
        let mut sum = self.sum;
        for lengths in left.iter().take(POSES_A_SLICE) {
            let equations = self.model.pose(&self.base, lengths).map_err(|error| self.refusal(error))?;
            sum.add(&equations);
            self.next_pose += 1;
        }
        self.sum = sum;
        Ok(())
    }

    #[cold]
    fn refusal(&self, contradiction: Contradiction) -> Refusal {
        let pose = self.next_pose as u16;
        match contradiction {
            Contradiction::Length(error) => Refusal::BadLength { pose, cable: error.cable, fault: error.fault },
            Contradiction::NotClosing(error) => {
                Refusal::NotClosing { pose, end_point: error.end_point, iteration: self.iterations() }
            }
        }
    }

    /// δE of this pass; then either the end or the next step (Eq. 15, 16).
    fn finish_pass(&mut self, poses: usize) -> Result<Option<Identified<T>>, Refusal> {
        let deviation_mm = deviation(self.sum.squares(), poses);
        let iterations = self.iterations();
        let termination = if deviation_mm < self.settings.tolerance_mm {
            Some(Termination::DeviationBelowTolerance)
        } else if self.largest_step_mm.is_some_and(|step| step < self.settings.tolerance_mm) {
            Some(Termination::Settled)
        } else {
            None
        };
        let cap_reached = iterations >= self.settings.iteration_cap;
        if self.deviations_mm.push(deviation_mm).is_err() || (termination.is_none() && cap_reached) {
            return Err(Refusal::IterationCap);
        }
        if let Some(termination) = termination {
            return self.identified(deviation_mm, termination, poses).map(Some);
        }
        let step = self.sum.normal_equations(&self.base, &self.parameters.radii_mm).solve().map_err(|_| Refusal::Singular)?;
        self.largest_step_mm = Some(step.iter().fold(T::zero(), |largest, x| largest.max(x.abs())));
        self.parameters = self.parameters.moved_by(&step);
        self.model = Model::new(&self.base, &self.edges_mm, &self.parameters);
        self.sum = PassSum::new();
        self.next_pose = 0;
        Ok(None)
    }

    /// The result, with the classical covariance of unweighted least squares, s² (DᵀD)⁻¹ with s² = YᵀY / (3m - 6).
    fn identified(&self, deviation_mm: T, termination: Termination, poses: usize) -> Result<Identified<T>, Refusal> {
        let equations = self.sum.normal_equations(&self.base, &self.parameters.radii_mm);
        let factors = Factors::of(equations.matrix()).map_err(|_| Refusal::Singular)?;
        let freedom = T::of_integer(3 * poses as i32 - UNKNOWNS as i32);
        let variance = self.sum.squares() / freedom;
        let mut covariance_mm2 = factors.inverse();
        for entry in &mut covariance_mm2 {
            *entry *= variance;
        }
        Ok(Identified {
            parameters: self.parameters,
            covariance_mm2,
            noise_mm: variance.root(),
            deviation_mm,
            deviations_mm: self.deviations_mm.clone(),
            iterations: self.iterations() - 1,
            termination,
            poses: poses as u16,
            rejected: Vec::new(),
            sway_rad: T::of(f64::INFINITY),
            zeros_mm: [T::zero(); CABLES],
            zero_sigmas_mm: [T::zero(); CABLES],
        })
    }
}
