//! The fit of all logs: Gauss-Newton on the machine's parameters and each log's joint centre, with outliers weighted down
//! (graduated non-convexity) and then left out.

use super::normal_equations::{self, Solution, Undetermined};
use super::wearing::Wearing;
use glenoid::identification::Machine;
use glenoid::identification::machine::{MAX_MACHINE, MachineEstimate};
use glenoid::identification::statistics::MEDIAN_OF_CHI_SQUARE_3;
use glenoid::identification::weights::{FINAL_SCALE, INLIER_LIMIT, Weights};
use nalgebra::{Vector3, Vector6};

/// Largest step at which the fit has settled, mm.
const SETTLED_MM: f64 = 1e-5;

/// Passes from the start: offsets of ±10 mm settle in six to eight.
const START_PASSES: usize = 12;
/// Step at which the start has settled, mm.
const START_SETTLED_MM: f64 = 1e-2;
/// Poses that those passes count for, when there are more.
const START_POSES: f64 = 200.0;
/// Scale of the Geman-McClure weights in those passes, in units of the median χ²: nearly equal for sound poses, next to
/// nothing for one that was placed in another assembly mode.
const START_SCALE: f64 = 9.0;
/// Passes with poses in or out.
const INLIER_PASSES: usize = 15;
/// Passes at the final scale of the weights.
const FINAL_SCALE_PASSES: usize = 3;

/// A median χ² this many times that of the stated noise says that the noise is larger than stated.
const LARGER_NOISE: f64 = 1.3;
/// Noise beyond this many times the stated one is not noise.
const MAX_TIMES_STATED_NOISE: f64 = 6.0;

/// Poses from which on the passes are told.
const LONG_RUN: usize = 50_000;

/// The fit under way.
#[derive(Clone, Debug)]
pub struct Fit<'a> {
    /// The machine as stated.
    pub machine: &'a Machine<f64>,
    /// As it is estimated.
    pub estimate: MachineEstimate<f64>,
    /// The logs.
    pub wearings: Vec<Wearing>,
    /// Standard deviation of a length, mm.
    pub noise_mm: f64,
    /// That is known.
    noise_is_known: bool,
    /// The places of the balls take part.
    uses_known_centres: bool,
    /// How many times the tolerances count.
    prior_weight: f64,
    passes: usize,
}

impl<'a> Fit<'a> {
    /// Nothing known yet. `noise_mm`: standard deviation of a length where it is known.
    pub fn new(machine: &'a Machine<f64>, wearings: Vec<Wearing>, noise_mm: Option<f64>) -> Self {
        Self {
            machine,
            estimate: MachineEstimate::new(machine),
            wearings,
            noise_mm: noise_mm.unwrap_or(machine.noise_mm()),
            noise_is_known: noise_mm.is_some(),
            uses_known_centres: false,
            prior_weight: 1.0,
            passes: 0,
        }
    }

    /// The same machine with other logs, from the start.
    pub fn without(&self, wearings: Vec<Wearing>) -> Self {
        Self::new(self.machine, wearings, self.noise_is_known.then_some(self.noise_mm))
    }

    /// Fits all logs without the known places.
    ///
    /// # Errors
    /// [`Undetermined`].
    pub fn run(&mut self) -> Result<Solution, Undetermined> {
        // As if there were few poses: what a start several millimetres off leaves is no noise, and in what hardly any pose
        // tells apart a hundred thousand of them would outvote the tolerances with it.
        let poses: usize = self.wearings.iter().map(|wearing| wearing.poses.len()).sum();
        self.prior_weight = (poses as f64 / START_POSES).max(1.0);
        // No step yet: what the start leaves says how large residuals are that count as usual.
        self.pass(&Weights::Equal, false, 0.0)?;
        for _ in 0..START_PASSES {
            let scale = (START_SCALE * self.median_chi_square()).max(FINAL_SCALE);
            let (_, largest_mm) = self.pass(&Weights::GemanMcClure(scale), false, 1.0)?;
            if largest_mm < START_SETTLED_MM {
                break;
            }
        }
        self.prior_weight = 1.0;
        self.estimate_noise();
        for _ in 0..FINAL_SCALE_PASSES {
            let scale = self.median_chi_square().max(FINAL_SCALE);
            self.pass(&Weights::GemanMcClure(scale), true, 1.0)?;
            self.estimate_noise();
        }
        self.settle()
    }

    /// Takes the known places of the balls in, and fits again.
    ///
    /// # Errors
    /// [`Undetermined`].
    pub fn run_with_known_centres(&mut self) -> Result<Solution, Undetermined> {
        self.uses_known_centres = true;
        self.settle()
    }

    /// Passes with poses in or out, until neither they nor the estimate change.
    fn settle(&mut self) -> Result<Solution, Undetermined> {
        let weights = Weights::Inliers(INLIER_LIMIT);
        let mut used_before = 0;
        let (mut solution, mut largest_mm) = self.pass(&weights, true, 1.0)?;
        for pass in 1..INLIER_PASSES {
            let used = self.wearings.iter().map(Wearing::used).sum();
            if largest_mm < SETTLED_MM && used == used_before {
                break;
            }
            used_before = used;
            (solution, largest_mm) = self.pass(&weights, pass == 1, 1.0)?;
        }
        Ok(solution)
    }

    /// One step of Gauss-Newton, `length` of it taken; the largest move of any unknown, mm.
    fn pass(&mut self, weights: &Weights<f64>, place_anew: bool, length: f64) -> Result<(Solution, f64), Undetermined> {
        let variance = self.noise_mm * self.noise_mm;
        let (machine, estimate) = (self.machine, &self.estimate);
        let prior = normal_equations::prior(machine, estimate, variance).times(self.prior_weight);
        let mut logs = Vec::with_capacity(self.wearings.len());
        for wearing in &mut self.wearings {
            let mut sums = normal_equations::sum(machine, estimate, wearing, weights, variance, place_anew);
            if let (true, Some(known)) = (self.uses_known_centres, &wearing.known) {
                let off_mm = known.in_base_mm - wearing.centre.in_base_mm;
                sums.add_known_centre(&off_mm, variance / (known.sigma_mm * known.sigma_mm));
            }
            logs.push(sums);
        }
        let solution = normal_equations::solve(&prior, &logs)?;
        let mut step = [0.0; MAX_MACHINE];
        step.iter_mut().zip(&solution.machine_step).for_each(|(step, value)| *step = *value * length);
        self.estimate.apply(machine, &step);
        for (wearing, step) in self.wearings.iter_mut().zip(&solution.centre_steps) {
            let [x, y, z, u, v, w]: [f64; 6] = (step * length).into();
            wearing.centre.in_base_mm += Vector3::new(x, y, z);
            wearing.centre.in_platform_mm += Vector3::new(u, v, w);
        }
        let largest_mm = solution.centre_steps.iter().map(Vector6::amax).fold(solution.machine_step.amax(), f64::max);
        self.passes += 1;
        self.tell(largest_mm);
        Ok((solution, largest_mm))
    }

    fn tell(&self, largest_mm: f64) {
        let poses: usize = self.wearings.iter().map(|wearing| wearing.poses.len()).sum();
        if poses >= LONG_RUN {
            eprintln!("pass {} over {poses} poses: largest step {largest_mm:.2e} mm", self.passes);
        }
    }

    /// Median χ² of the poses, of the quieter half of the logs.
    fn median_chi_square(&self) -> f64 {
        let mut medians: Vec<f64> = self.wearings.iter().map(Wearing::median_chi_square).collect();
        medians.sort_unstable_by(f64::total_cmp);
        medians.get((medians.len().max(1) - 1) / 2).copied().unwrap_or(0.0)
    }

    /// An unknown noise, from the typical χ² of the logs that fit best: a bad log does not make itself look good.
    fn estimate_noise(&mut self) {
        if self.noise_is_known {
            return;
        }
        let stated_mm = self.machine.noise_mm();
        let in_stated = self.median_chi_square() * (self.noise_mm / stated_mm).powi(2) / MEDIAN_OF_CHI_SQUARE_3;
        let times = if in_stated > LARGER_NOISE { in_stated.sqrt().min(MAX_TIMES_STATED_NOISE) } else { 1.0 };
        let before = self.noise_mm;
        self.noise_mm = stated_mm * times;
        let scale = (before / self.noise_mm).powi(2);
        for pose in self.wearings.iter_mut().flat_map(|wearing| &mut wearing.poses) {
            pose.chi_square *= scale;
        }
    }
}
