//! The estimator: from lengths to a hinge with its covariance, or a refusal that names its cause.

use super::fit::Fit;
use super::joint::{HINGE_UNKNOWNS, Hinge};
use super::judge;
use super::machine::MAX_CONSTANTS;
use super::pose::{HingePose, MAX_UNKNOWNS};
use super::refusal::HingeRefusal;
use super::result::IdentifiedHinge;
use super::rig::HingeRig;
use super::settings::HingeSettings;
use super::starts::{STARTS, is_on_platform_side, start};
use crate::identification::settings::Noise;
use crate::kinematics::LengthFault;
use crate::linear_algebra::{Singular, non_negative_root};
use crate::scalar::Real;
use heapless::Vec;
use nalgebra::SMatrix;

/// Fewest poses: four redundant lengths more than a hinge has unknowns, at four cables.
pub const MIN_POSES: usize = 6;
/// Starts that the fit goes on from, the cheapest.
const CANDIDATES: usize = 6;
/// Steps of the fit from a start; from a drawing; with the machine's constants.
const START_TRIALS: usize = 60;
const LAST_TRIALS: usize = 30;
/// Lengths that vary by less than this, in standard deviations of the noise, show no motion.
const NO_MOTION: f64 = 4.0;
/// Another hinge whose χ² is larger by less than this fits as well: once in two million the true one is the worse.
const BOTH_FIT: f64 = 25.0;
/// Two hinges farther apart than this many standard deviations in any unknown are two.
const DISTINCT: f64 = 4.0;
/// A solution this far from the drawing is not the drawn one.
const OFF_DRAWING_RAD: f64 = 0.262;
const OFF_DRAWING_MM: f64 = 30.0;

/// A converged hinge.
#[derive(Clone, Copy, Debug)]
struct Candidate<T: Real> {
    hinge: Hinge<T>,
    values: [T; MAX_CONSTANTS],
    squares_mm2: T,
}

/// The estimator of a hinge.
#[derive(Clone, Debug)]
pub struct HingeEstimator<T: Real> {
    rig: HingeRig<T>,
    settings: HingeSettings<T>,
    fit: Fit<T>,
}

impl<T: Real> HingeEstimator<T> {
    /// An estimator at its beginning.
    pub fn new(rig: &HingeRig<T>, settings: HingeSettings<T>) -> Self {
        let anywhere = Hinge::through(
            &nalgebra::Vector3::x(),
            &nalgebra::Vector3::zeros(),
            &nalgebra::Vector3::x(),
            &nalgebra::Vector3::zeros(),
        );
        Self { rig: rig.clone(), settings, fit: Fit::new(rig, anywhere) }
    }

    /// Identifies the hinge. The poses get their angles, χ² and weights.
    ///
    /// # Errors
    /// The [`HingeRefusal`] that names the cause.
    pub fn run(&mut self, poses: &mut [HingePose<T>]) -> Result<IdentifiedHinge<T>, HingeRefusal> {
        self.require_input(poses)?;
        poses.iter_mut().for_each(|pose| pose.weight = T::one());
        if let Noise::Known(noise) = self.settings.noise {
            self.fit.noise_mm = noise;
        }
        let candidates = self.candidates(poses);
        let Some(best) = candidates.first() else { return Err(HingeRefusal::NotAHinge { residual_mm: f32::INFINITY }) };
        self.go_to(best, poses);
        if !judge::are_noise(&self.fit, poses, self.settings.noise) {
            self.without_outliers(poses)?;
        }
        self.require_flexion(poses)?;
        if let Noise::EstimatedUpTo(_) = self.settings.noise {
            // The priors weigh against the noise that there is.
            self.fit.noise_mm = self.noise_mm(poses);
            self.fit.minimise(poses, LAST_TRIALS, false);
        }
        let found = self.result(poses)?;
        let found = self.the_drawn_one(found, &candidates, poses)?;
        found.require_accuracy(&self.settings)?;
        judge::isolate(&self.fit, poses);
        Ok(found)
    }

    /// Column `unknown` of the covariance of all unknowns, for a noise of 1 mm: the hinge's, then the machine's.
    pub fn covariance_column(&self, unknown: usize) -> [T; MAX_UNKNOWNS] {
        self.fit.equations.covariance_column(unknown, 0)
    }

    fn require_input(&self, poses: &[HingePose<T>]) -> Result<(), HingeRefusal> {
        let cables = self.rig.cables().len();
        for (index, pose) in poses.iter().enumerate() {
            for (cable, length) in pose.lengths_mm.iter().enumerate().take(cables) {
                let fault = if !length.is_a_number() {
                    LengthFault::NotFinite
                } else if *length <= T::zero() {
                    LengthFault::NotPositive
                } else {
                    continue;
                };
                return Err(HingeRefusal::BadLength { pose: index as u32, cable: cable as u8 + 1, fault });
            }
        }
        if self.fit.prior().is_none() && cables < 4 {
            // Two cables determine five combinations of the nine, three determine eight.
            let determined = if cables == 2 { 5 } else { 8 };
            return Err(HingeRefusal::TooFewCables { cables: cables as u8, determined });
        }
        if poses.len() < MIN_POSES {
            return Err(HingeRefusal::TooFewPoses { poses: poses.len() as u32, wanted: MIN_POSES as u32 });
        }
        let spread = (0..cables).map(|cable| spread(poses, cable)).fold(T::zero(), |most, next| most.max(next));
        let noise = match self.settings.noise {
            Noise::Known(noise) => noise,
            Noise::EstimatedUpTo(_) => self.rig.length_noise_mm(),
        };
        if spread < noise * T::of(NO_MOTION) {
            return Err(HingeRefusal::TooLittleFlexion { range_rad: 0.0 });
        }
        Ok(())
    }

    /// The hinges that the starts lead to, the best first; from a drawing with priors the one that it leads to.
    fn candidates(&mut self, poses: &mut [HingePose<T>]) -> Vec<Candidate<T>, CANDIDATES> {
        let mut starts = Vec::<(Hinge<T>, T), CANDIDATES>::new();
        if let (Some(_), Some(drawing)) = (self.fit.prior(), self.rig.drawing()) {
            let _ = starts.push((drawing.hinge, T::zero()));
        } else {
            let mean = mean_length(poses, self.rig.cables().len());
            for index in 0..STARTS {
                let hinge = start(&self.fit.machine, mean, index);
                self.fit.hinge = hinge;
                insert(&mut starts, (hinge, self.fit.place(poses, true)));
            }
        }
        let mut rough = Vec::<Candidate<T>, CANDIDATES>::new();
        for (hinge, _) in &starts {
            self.fit.hinge = *hinge;
            self.fit.constants = false;
            self.fit.machine.set_values([T::zero(); MAX_CONSTANTS]);
            self.fit.minimise(poses, START_TRIALS, true);
            let is_new = |known: &Candidate<T>| {
                let (angle, distance) = judge::apart(&self.fit, &known.hinge, &self.fit.hinge);
                angle > T::of(0.02) || distance > T::of(3.0)
            };
            if is_on_platform_side(&self.fit.machine, &self.fit.hinge) && rough.iter().all(is_new) {
                let _ = rough.push(self.candidate());
            }
        }
        if self.fit.machine.constants().is_empty() {
            sort(&mut rough);
            return rough;
        }
        let mut candidates = Vec::new();
        self.fit.constants = true;
        for start in &rough {
            self.fit.hinge = start.hinge;
            self.fit.machine.set_values(start.values);
            self.fit.minimise(poses, LAST_TRIALS, true);
            let _ = candidates.push(self.candidate());
        }
        sort(&mut candidates);
        candidates
    }

    fn candidate(&self) -> Candidate<T> {
        Candidate {
            hinge: self.fit.hinge,
            values: *self.fit.machine.values(),
            squares_mm2: self.fit.squares_mm2,
        }
    }

    fn go_to(&mut self, candidate: &Candidate<T>, poses: &mut [HingePose<T>]) {
        self.fit.hinge = candidate.hinge;
        self.fit.machine.set_values(candidate.values);
        self.fit.minimise(poses, LAST_TRIALS, true);
        self.fit.settle(poses);
    }

    /// Leaves out the poses that contradict the others; refuses by name when those that are left still do.
    fn without_outliers(&mut self, poses: &mut [HingePose<T>]) -> Result<(), HingeRefusal> {
        let before = self.candidate();
        let outcome = judge::leave_out(&mut self.fit, poses, MIN_POSES);
        if outcome.is_ok() && judge::are_noise(&self.fit, poses, self.settings.noise) {
            return Ok(());
        }
        poses.iter_mut().for_each(|pose| pose.weight = T::one());
        self.go_to(&before, poses);
        self.require_flexion(poses)?;
        match judge::no_hinge(&self.fit, poses, self.settings.noise) {
            // A few wild poses look like anything but a second axis.
            HingeRefusal::NotAHinge { .. } if outcome.is_err() && judge::is_mostly_sound(&self.fit, poses) => outcome,
            refusal => Err(refusal),
        }
    }

    fn require_flexion(&self, poses: &[HingePose<T>]) -> Result<(), HingeRefusal> {
        let range = judge::flexion_rad(poses);
        if range < self.settings.flexion_limit_rad {
            return Err(HingeRefusal::TooLittleFlexion { range_rad: range.to_f32() });
        }
        Ok(())
    }

    fn noise_mm(&self, poses: &[HingePose<T>]) -> T {
        judge::noise_of_result_mm(&self.fit, poses, self.settings.noise, self.rig.length_noise_mm())
    }

    fn result(&mut self, poses: &mut [HingePose<T>]) -> Result<IdentifiedHinge<T>, HingeRefusal> {
        let weak = |_: Singular| HingeRefusal::Weak { part: super::HingePart::Axis, sigma: f32::INFINITY };
        self.fit.finish(poses).map_err(weak)?;
        let noise_mm = self.noise_mm(poses);
        let mut covariance = SMatrix::<T, HINGE_UNKNOWNS, HINGE_UNKNOWNS>::zeros();
        for (j, mut column) in covariance.column_iter_mut().enumerate() {
            let entries = self.fit.equations.covariance_column(j, 0);
            column.iter_mut().zip(entries).for_each(|(entry, value)| *entry = value * noise_mm * noise_mm);
        }
        let freedom = judge::freedom(&self.fit, poses);
        Ok(IdentifiedHinge {
            hinge: self.fit.hinge,
            covariance,
            machine: self.fit.machine.clone(),
            noise_mm,
            rms_residual_mm: non_negative_root(self.fit.squares_mm2 / freedom),
            flexion_rad: judge::flexion_rad(poses),
            poses: poses.len() as u32,
            rejected: poses.iter().filter(|pose| !pose.is_used()).count() as u32,
        })
    }

    /// The result, unless another hinge fits as well: then the one that the drawing means, or a refusal.
    fn the_drawn_one(
        &mut self,
        found: IdentifiedHinge<T>,
        candidates: &[Candidate<T>],
        poses: &mut [HingePose<T>],
    ) -> Result<IdentifiedHinge<T>, HingeRefusal> {
        let limit = self.fit.squares_mm2 + T::of(BOTH_FIT) * found.noise_mm * found.noise_mm;
        let sigmas = found.sigmas();
        let mut found = found;
        for other in candidates {
            let difference = found.hinge.difference(&other.hinge);
            let is_other = difference.iter().zip(&sigmas).any(|(x, sigma)| x.abs() > *sigma * T::of(DISTINCT));
            if !is_other {
                continue;
            }
            // Without the poses that are left out it may fit better than it did.
            let best = self.fit.clone();
            self.fit.hinge = other.hinge;
            self.fit.machine.set_values(other.values);
            self.fit.minimise(poses, LAST_TRIALS, true);
            let difference = found.hinge.difference(&self.fit.hinge);
            let is_other = difference.iter().zip(&sigmas).any(|(x, sigma)| x.abs() > *sigma * T::of(DISTINCT));
            if !(is_other && self.fit.squares_mm2 < limit) {
                self.fit = best;
                let _ = self.fit.finish(poses);
                continue;
            }
            match (self.is_drawn(&best.hinge), self.is_drawn(&self.fit.hinge)) {
                (true, false) => {
                    self.fit = best;
                    let _ = self.fit.finish(poses);
                }
                (false, true) => found = self.result(poses)?,
                _ => {
                    let (angle, distance) = judge::apart(&self.fit, &best.hinge, &self.fit.hinge);
                    return Err(HingeRefusal::TwoAxesFit {
                        angle_rad: angle.to_f32(),
                        distance_mm: distance.to_f32(),
                    });
                }
            }
        }
        Ok(found)
    }

    /// Is a hinge near the drawing's? Nothing is without one.
    fn is_drawn(&self, hinge: &Hinge<T>) -> bool {
        self.rig.drawing().is_some_and(|drawing| {
            let (angle, distance) = judge::apart(&self.fit, &drawing.hinge, hinge);
            angle < T::of(OFF_DRAWING_RAD) && distance < T::of(OFF_DRAWING_MM)
        })
    }
}

/// Keeps the cheapest hinges, in order.
fn insert<T: Real>(starts: &mut Vec<(Hinge<T>, T), CANDIDATES>, new: (Hinge<T>, T)) {
    if starts.is_full() {
        let is_cheaper = starts.last().is_some_and(|last| new.1 < last.1);
        if !is_cheaper {
            return;
        }
        starts.pop();
    }
    let place = starts.iter().position(|known| new.1 < known.1).unwrap_or(starts.len());
    let _ = starts.insert(place, new);
}

fn sort<T: Real>(candidates: &mut Vec<Candidate<T>, CANDIDATES>) {
    candidates.sort_unstable_by(|a, b| {
        a.squares_mm2.partial_cmp(&b.squares_mm2).unwrap_or(core::cmp::Ordering::Equal)
    });
}

fn mean_length<T: Real>(poses: &[HingePose<T>], cables: usize) -> T {
    let lengths = poses.iter().flat_map(|pose| pose.lengths_mm.iter().take(cables));
    let (sum, count) = lengths.fold((T::zero(), 0), |(sum, count), length| (sum + *length, count + 1));
    sum / T::of_integer(count.max(1))
}

/// Standard deviation of the lengths of a cable (from 0), mm.
fn spread<T: Real>(poses: &[HingePose<T>], cable: usize) -> T {
    let count = T::of_integer(poses.len().max(1) as i32);
    let length = |pose: &HingePose<T>| pose.lengths_mm.get(cable).copied().unwrap_or_else(T::zero);
    let mean = poses.iter().fold(T::zero(), |sum, pose| sum + length(pose)) / count;
    let squares = poses.iter().fold(T::zero(), |sum, pose| sum + (length(pose) - mean) * (length(pose) - mean));
    non_negative_root(squares / count)
}
