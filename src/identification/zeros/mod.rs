//! The encoder zeros: known, or six more unknowns, each with a prior.
//!
//! An incremental encoder wakes with an unknown zero, so a measured length is L + z with the same z in every pose. The
//! deviation cannot see a common error: 1 mm on all cables moves the centre by 0.7 mm with hardly any residual. The
//! zeros are identifiable from the same poses all the same. A prior standard deviation says how well the machine was
//! homed: 0 means that the zeros are known, 10 mm that nobody homed it; the error bar of the centre is honest about it.
//!
//! A machine that always homes takes [`KnownZeros`]: the solver then holds nothing of them, neither code nor memory.

mod equations;

use core::fmt::Debug;

use self::equations::ZeroEquations;
use super::blocks::{BlockEquations, Blocks};
use super::normal_equations::{Singular, UNKNOWNS};
use super::outcome::Identified;
use super::pose_information::PoseInformation;
use crate::kinematics::{CableLengths, LengthEquations};
use crate::rig::CABLES;
use crate::scalar::Real;
use crate::symmetric::Symmetric;
use nalgebra::Matrix3;

/// A Gauss-Newton step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step<T> {
    /// Of O and C, mm.
    pub pivot: [T; UNKNOWNS],
    /// Largest move of any unknown, mm.
    pub largest_mm: T,
    /// Sum of squares that the step leaves, mm² (of the linear problem, exact at convergence).
    pub squares_left_mm2: T,
}

/// What a solver does about the encoder zeros.
pub trait Zeros<T: Real>: Clone + Debug {
    /// Zeros known to `prior_mm`, 1σ; 0 = exactly.
    fn new(prior_mm: T) -> Self;

    /// A pass over the poses begins, with a noise of `noise_mm`.
    fn begin_pass(&mut self, noise_mm: T);

    /// The zeros are left as they are from now on.
    fn hold(&mut self);

    /// Are they among the unknowns of this pass?
    fn take_part(&self) -> bool;

    /// What each length reads too much by the present estimate, mm; `None` when nothing.
    fn estimate_mm(&self) -> Option<&[T; CABLES]>;

    /// Adds a pose with its rotation ({P} to {B}) and weight.
    fn add_pose(&mut self, rotation: &Matrix3<T>, lengths: &LengthEquations<T>, pose: &PoseInformation<T>, weight: T);

    /// The step of all unknowns; the zeros take theirs.
    ///
    /// # Errors
    /// [`Singular`] when the poses leave O and C undetermined.
    fn step(&mut self, equations: &BlockEquations<T>) -> Result<Step<T>, Singular>;

    /// Covariance of O for a noise of 1 mm.
    ///
    /// # Errors
    /// As [`step`](Self::step).
    fn centre_covariance(&self, equations: &BlockEquations<T>) -> Result<Symmetric<T>, Singular>;

    /// Covariance of O and C for a noise of 1 mm. That of the zeros is remembered.
    ///
    /// # Errors
    /// As [`step`](Self::step).
    fn covariance(&mut self, equations: &BlockEquations<T>) -> Result<Blocks<T>, Singular>;

    /// The zero known worst (cable from 0) and its 1σ for a noise of 1 mm; `None` when they take no part.
    fn worst(&self) -> Option<(usize, T)>;

    /// Puts the zeros and their error bar into the result, for a noise of `noise_mm`.
    fn write(&self, noise_mm: T, result: &mut Identified<T>);

    /// The lengths less the estimated zeros; as they are, if nothing is left of one.
    fn corrected(&self, lengths: &CableLengths<T>) -> CableLengths<T> {
        self.estimate_mm().and_then(|zeros_mm| lengths.less(zeros_mm).ok()).unwrap_or(*lengths)
    }
}

/// Zeros that the machine's homing has found, whatever the prior says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KnownZeros;

/// Zeros that are found with the centre.
#[derive(Clone, Debug, PartialEq)]
pub struct UnknownZeros<T> {
    prior_mm: T,
    estimate_mm: [T; CABLES],
    /// 1σ of each for a noise of 1 mm.
    sigmas: [T; CABLES],
    /// Of the present pass; none where they do not take part.
    equations: Option<ZeroEquations<T>>,
}

impl<T: Real> Step<T> {
    /// The step of O and C alone.
    #[inline(never)]
    fn of_pivot(equations: &BlockEquations<T>) -> Result<Self, Singular> {
        let Ok(pivot) = &equations.solve() else { return Err(Singular) };
        let squares_left_mm2 = (equations.squares - equations.gained(pivot)).max(T::zero());
        Ok(Self { pivot: *pivot, largest_mm: largest(pivot), squares_left_mm2 })
    }
}

fn largest<T: Real>(step: &[T; UNKNOWNS]) -> T {
    step.iter().fold(T::zero(), |largest, x| if x.abs() > largest { x.abs() } else { largest })
}

impl<T: Real> Zeros<T> for KnownZeros {
    fn new(_: T) -> Self {
        Self
    }

    fn begin_pass(&mut self, _: T) {}

    fn hold(&mut self) {}

    fn take_part(&self) -> bool {
        false
    }

    fn estimate_mm(&self) -> Option<&[T; CABLES]> {
        None
    }

    fn add_pose(&mut self, _: &Matrix3<T>, _: &LengthEquations<T>, _: &PoseInformation<T>, _: T) {}

    fn step(&mut self, equations: &BlockEquations<T>) -> Result<Step<T>, Singular> {
        Step::of_pivot(equations)
    }

    fn centre_covariance(&self, equations: &BlockEquations<T>) -> Result<Symmetric<T>, Singular> {
        equations.matrix.first_inverse()
    }

    fn covariance(&mut self, equations: &BlockEquations<T>) -> Result<Blocks<T>, Singular> {
        inverse(equations)
    }

    fn worst(&self) -> Option<(usize, T)> {
        None
    }

    fn write(&self, _: T, _: &mut Identified<T>) {}
}

impl<T: Real> Zeros<T> for UnknownZeros<T> {
    fn new(prior_mm: T) -> Self {
        Self { prior_mm, estimate_mm: [T::zero(); CABLES], sigmas: [T::zero(); CABLES], equations: None }
    }

    fn begin_pass(&mut self, noise_mm: T) {
        if self.prior_mm > T::zero() {
            let ratio = noise_mm / self.prior_mm;
            self.equations = Some(ZeroEquations::new(ratio * ratio, &self.estimate_mm));
        }
    }

    fn hold(&mut self) {
        self.equations = None;
    }

    fn take_part(&self) -> bool {
        self.equations.is_some()
    }

    fn estimate_mm(&self) -> Option<&[T; CABLES]> {
        (self.prior_mm > T::zero()).then_some(&self.estimate_mm)
    }

    fn add_pose(&mut self, rotation: &Matrix3<T>, lengths: &LengthEquations<T>, pose: &PoseInformation<T>, weight: T) {
        if let Some(equations) = &mut self.equations {
            equations.add(rotation, lengths, pose, weight);
        }
    }

    // Not inlined: with unknown zeros a step takes four times the stack.
    #[inline(never)]
    fn step(&mut self, equations: &BlockEquations<T>) -> Result<Step<T>, Singular> {
        let Some(zeros) = &self.equations else { return Step::of_pivot(equations) };
        let reduced = zeros.reduce(equations)?;
        let mut step = Step::of_pivot(&reduced.equations)?;
        let moved = reduced.zeros_step(&step.pivot);
        step.largest_mm = step.largest_mm.max(largest(&moved));
        self.estimate_mm.iter_mut().zip(moved).for_each(|(zero, moved)| *zero += moved);
        Ok(step)
    }

    #[inline(never)]
    fn centre_covariance(&self, equations: &BlockEquations<T>) -> Result<Symmetric<T>, Singular> {
        match &self.equations {
            Some(zeros) => zeros.reduce(equations)?.equations.matrix.first_inverse(),
            None => equations.matrix.first_inverse(),
        }
    }

    fn covariance(&mut self, equations: &BlockEquations<T>) -> Result<Blocks<T>, Singular> {
        let Some(zeros) = &self.equations else { return inverse(equations) };
        let (covariance, variances) = zeros.covariance(equations)?;
        self.sigmas = variances.map(|variance| variance.max(T::zero()).root());
        Ok(covariance)
    }

    fn worst(&self) -> Option<(usize, T)> {
        self.equations.as_ref()?;
        let worse = |worst: (usize, T), next: (usize, &T)| if *next.1 > worst.1 { (next.0, *next.1) } else { worst };
        Some(self.sigmas.iter().enumerate().fold((0, T::zero()), worse))
    }

    fn write(&self, noise_mm: T, result: &mut Identified<T>) {
        result.zeros_mm = self.estimate_mm;
        result.zero_sigmas_mm = self.sigmas.map(|sigma| sigma * noise_mm);
    }
}

#[inline(never)]
fn inverse<T: Real>(equations: &BlockEquations<T>) -> Result<Blocks<T>, Singular> {
    let mut covariance = equations.matrix;
    covariance.invert()?;
    Ok(covariance)
}
