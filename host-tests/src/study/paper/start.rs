//! One run of the paper's plain iteration from a start that is off.

use crate::study::scene::{Reach, Scene, symmetric, with_noise};
use crate::study::solve::{Precision, lengths_in};
use glenoid::identification::Refusal;
use glenoid::kinematics::CableLengths;
use glenoid::paper::{PaperIteration, PaperSettings};
use glenoid::rig::Parameters;
use glenoid::scalar::Real;
use nalgebra::Rotation3;
use rand::Rng;

/// The paper's ε, mm.
pub const TOLERANCE_MM: f64 = 1e-3;
/// Steps after which the iteration is given up. The paper needs four or five.
const STEP_CAP: u8 = 20;
/// A run that ends further off than this has ended elsewhere than at the truth, mm.
pub const ELSEWHERE_MM: f64 = 1.0;

/// A converged run.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// x, y, z, p1, p2, p3, mm.
    pub parameters_mm: [f64; 6],
    /// δE before each step and after the last, mm.
    pub deviations_mm: Vec<f64>,
}

impl Run {
    /// Steps taken.
    pub fn steps(&self) -> usize {
        self.deviations_mm.len() - 1
    }

    /// δE at the end, mm.
    pub fn deviation_mm(&self) -> f64 {
        self.deviations_mm[self.steps()]
    }

    /// Largest error of any of the six parameters, mm.
    pub fn largest_error_mm(&self, scene: &Scene) -> f64 {
        largest_difference(&self.parameters_mm, &scene.truth().to_array())
    }
}

/// Largest difference of any of six parameters.
pub fn largest_difference(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    a.iter().zip(b).fold(0.0, |most, (x, y)| most.max((x - y).abs()))
}

/// The true parameters with each off by a number uniform within `limit_mm` to either side, mm.
pub fn random_start(scene: &Scene, random: &mut impl Rng, limit_mm: f64) -> [f64; 6] {
    scene.truth().to_array().map(|value| value + symmetric(random, limit_mm))
}

/// Random rotations of the usual reach.
pub fn random_rotations(random: &mut impl Rng, poses: usize) -> Vec<Rotation3<f64>> {
    (0..poses).map(|_| Reach::USUAL.rotation(random)).collect()
}

/// Lengths at these rotations with noise uniform within `noise_mm` to either side, in a precision.
///
/// # Errors
/// None in practice: when a length is not positive.
pub fn measured<T: Precision>(
    scene: &Scene,
    rotations: &[Rotation3<f64>],
    random: &mut impl Rng,
    noise_mm: f64,
) -> Result<Vec<CableLengths<T>>, Refusal> {
    let lengths: Vec<_> =
        rotations.iter().map(|rotation| with_noise(scene.lengths(rotation), random, noise_mm)).collect();
    lengths_in(&lengths)
}

/// The plain iteration from `start_mm` until δE or the step falls below `tolerance_mm`.
///
/// # Errors
/// Why it did not converge.
pub fn run<T: Precision>(
    scene: &Scene,
    start_mm: &[f64; 6],
    poses: &[CableLengths<T>],
    tolerance_mm: f64,
) -> Result<Run, Refusal> {
    steps(scene, start_mm, poses, tolerance_mm, STEP_CAP)
}

/// One more step from where a run has ended; the run itself when that does not lessen δE (nothing but rounding is left).
pub fn one_more_step<T: Precision>(scene: &Scene, run: Run, poses: &[CableLengths<T>]) -> Run {
    steps(scene, &run.parameters_mm, poses, run.deviation_mm() / 2.0, 1).unwrap_or(run)
}

fn steps<T: Precision>(
    scene: &Scene,
    start_mm: &[f64; 6],
    poses: &[CableLengths<T>],
    tolerance_mm: f64,
    iteration_cap: u8,
) -> Result<Run, Refusal> {
    let start = Parameters::from_array(start_mm.map(T::of));
    let settings = PaperSettings { tolerance_mm: T::of(tolerance_mm), iteration_cap };
    let identified = PaperIteration::new(T::rig(scene), start, settings).run(poses)?;
    Ok(Run {
        parameters_mm: identified.parameters.to_array().map(Real::to_f64),
        deviations_mm: identified.rms_residuals_mm.iter().map(|deviation| deviation.to_f64()).collect(),
    })
}
