//! The estimator: from lengths to a hinge with its covariance, or a refusal that names its cause.

use super::candidates::{Candidate, LAST_TRIALS, SAME, are_near};
use super::fit::Fit;
use super::joint::{AXIS, AXIS_IN_PLATFORM, FOOT, FOOT_IN_PLATFORM, HINGE_UNKNOWNS, Hinge};
use super::judge;
use super::pose::{HingePose, MAX_UNKNOWNS};
use super::profile;
use super::refusal::{HingePart, HingeRefusal};
use super::result::IdentifiedHinge;
use super::rig::HingeRig;
use super::settings::HingeSettings;
use crate::identification::settings::Noise;
use crate::kinematics::LengthFault;
use crate::linear_algebra::{Singular, non_negative_root};
use crate::scalar::Real;
use nalgebra::SMatrix;

/// Minimum number of poses: four redundant lengths more than a hinge has unknowns, at four cables.
pub const MIN_POSES: usize = 6;
/// Lengths that vary by less than this, in standard deviations of the noise, show no motion.
const NO_MOTION: f64 = 4.0;
/// Fewer than four cables follow a drawing, which must be as good as this, 1σ: about a vaguer one the problem is too far from
/// linear for a standard deviation to be true.
const VAGUE_RAD: f64 = 0.07;
const VAGUE_MM: f64 = 4.0;
/// Another hinge whose χ² is larger by less than this fits as well: at the most once in 250 000 the true one is worse by more.
const BOTH_FIT: f64 = 20.0;
/// Candidates beside which a second axis is looked for, the cheapest.
const CANDIDATES_WITH_SECOND_AXIS: usize = 6;
/// Two hinges farther apart than this many standard deviations in any unknown are two.
const DISTINCT: f64 = 4.0;
/// A hinge within this of the drawing is the drawn one when the other that fits is farther than twice this from it.
const AT_DRAWING_RAD: f64 = 0.262;
const AT_DRAWING_MM: f64 = 30.0;
/// Sums of the poses' χ², each cut off where it is left out, that differ by less than this do not tell two hinges apart.
const BOTH_FIT_WITHOUT_OUTLIERS: f64 = 50.0;

/// The estimator of a hinge.
#[derive(Clone, Debug)]
pub struct HingeEstimator<T: Real> {
    rig: HingeRig<T>,
    settings: HingeSettings<T>,
    pub(super) fit: Fit<T>,
    /// Of the last result, 1σ, mm.
    pub(super) noise_mm: T,
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
        Self { rig: rig.clone(), settings, fit: Fit::new(rig, anywhere), noise_mm: rig.length_noise_mm() }
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
        let candidates = self.fit.candidates(poses);
        let Some(best) = candidates.first() else { return Err(HingeRefusal::NotAHinge { residual_mm: f32::INFINITY }) };
        self.go_to(best, poses);
        if !judge::are_noise(&self.fit, poses, self.settings.noise) {
            self.without_outliers(&candidates, poses)?;
        }
        self.require_flexion(poses)?;
        if let Noise::EstimatedUpTo(_) = self.settings.noise {
            // The priors weigh against the noise that there is.
            self.fit.noise_mm = self.result_noise_mm(poses);
            self.fit.minimise(poses, LAST_TRIALS, false);
        }
        let found = self.result(poses)?;
        let found = self.the_drawn_one(found, &candidates, poses)?;
        found.require_accuracy(&self.settings)?;
        let finished = self.fit.clone();
        let are_true = profile::require_true_sigmas(&finished, &found, poses);
        self.return_to(finished, poses);
        are_true?;
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
        if let Some((_, sigma)) = self.fit.prior().filter(|_| cables < 4) {
            let vague = |part, of: usize, limit: f64| {
                let sigma = sigma.get(of).copied().unwrap_or_else(T::zero);
                if sigma > T::of(limit) { Err(HingeRefusal::Weak { part, sigma: sigma.to_f32() }) } else { Ok(()) }
            };
            vague(HingePart::Axis, AXIS, VAGUE_RAD)?;
            vague(HingePart::AxisInPlatform, AXIS_IN_PLATFORM, VAGUE_RAD)?;
            vague(HingePart::Place, FOOT, VAGUE_MM)?;
            vague(HingePart::PlaceInPlatform, FOOT_IN_PLATFORM, VAGUE_MM)?;
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

    fn go_to(&mut self, candidate: &Candidate<T>, poses: &mut [HingePose<T>]) {
        self.fit.hinge = candidate.hinge;
        self.fit.machine.set_values(candidate.values);
        self.fit.minimise(poses, LAST_TRIALS, true);
        self.fit.settle(poses);
    }

    /// Leaves out the poses that contradict the others, from the candidate that leaves least; refuses by name when none
    /// leaves few enough, or two different ones do.
    fn without_outliers(
        &mut self,
        candidates: &[Candidate<T>],
        poses: &mut [HingePose<T>],
    ) -> Result<(), HingeRefusal> {
        let mut outcome = Ok(());
        let mut best: Option<Candidate<T>> = None;
        let mut rival: Option<(Hinge<T>, T)> = None;
        for candidate in candidates {
            let left_out = self.leave_out_from(candidate, poses);
            if left_out.is_ok() && judge::are_noise(&self.fit, poses, self.settings.noise) {
                let squares_mm2 = judge::cut_off_squares(&self.fit, poses);
                let found = Candidate { squares_mm2, ..self.fit.candidate() };
                let is_better = best.as_ref().is_none_or(|best| found.squares_mm2 < best.squares_mm2);
                let other = if is_better { best.replace(found) } else { Some(found) };
                let is_rival = |other: &Candidate<T>| {
                    best.as_ref().is_some_and(|best| !are_near(&best.hinge, &other.hinge, SAME))
                        && rival.is_none_or(|rival| other.squares_mm2 < rival.1)
                };
                rival = other.filter(is_rival).map(|other| (other.hinge, other.squares_mm2)).or(rival);
            } else if left_out.is_err() && outcome.is_ok() {
                outcome = left_out;
            }
        }
        if let Some(best) = best {
            let window = T::of(BOTH_FIT_WITHOUT_OUTLIERS) * self.fit.noise_mm * self.fit.noise_mm;
            if let Some((rival, _)) = rival.filter(|rival| rival.1 < best.squares_mm2 + window) {
                return Err(judge::two_axes(&self.fit, &best.hinge, &rival));
            }
            self.leave_out_from(&best, poses)?;
            return if judge::are_noise(&self.fit, poses, self.settings.noise) {
                Ok(())
            } else {
                Err(judge::no_hinge(&self.fit, poses, self.settings.noise))
            };
        }
        poses.iter_mut().for_each(|pose| pose.weight = T::one());
        self.why_not(outcome, candidates, poses)
    }

    /// Why no candidate is a hinge that explains the poses: a second axis beside one of them, a few wild poses, or another
    /// joint.
    fn why_not(
        &mut self,
        outliers: Result<(), HingeRefusal>,
        candidates: &[Candidate<T>],
        poses: &mut [HingePose<T>],
    ) -> Result<(), HingeRefusal> {
        for candidate in candidates.iter().take(CANDIDATES_WITH_SECOND_AXIS) {
            self.go_to(candidate, poses);
            self.require_flexion(poses)?;
            let refusal = judge::no_hinge(&self.fit, poses, self.settings.noise);
            if matches!(refusal, HingeRefusal::SecondAxis { .. }) {
                return Err(refusal);
            }
        }
        if let Some(first) = candidates.first() {
            self.go_to(first, poses);
        }
        // A few wild poses leave the others nearly sound.
        if outliers.is_err() && judge::is_mostly_sound(&self.fit, poses) {
            return outliers;
        }
        Err(judge::not_a_hinge(&self.fit, poses))
    }

    fn leave_out_from(&mut self, from: &Candidate<T>, poses: &mut [HingePose<T>]) -> Result<(), HingeRefusal> {
        poses.iter_mut().for_each(|pose| pose.weight = T::one());
        self.go_to(from, poses);
        judge::leave_out(&mut self.fit, poses, MIN_POSES)
    }

    fn require_flexion(&self, poses: &[HingePose<T>]) -> Result<(), HingeRefusal> {
        let range = judge::flexion_rad(poses);
        if range < self.settings.flexion_limit_rad {
            return Err(HingeRefusal::TooLittleFlexion { range_rad: range.to_f32() });
        }
        Ok(())
    }

    fn result_noise_mm(&self, poses: &[HingePose<T>]) -> T {
        judge::noise_of_result_mm(&self.fit, poses, self.settings.noise, self.rig.length_noise_mm())
    }

    fn result(&mut self, poses: &mut [HingePose<T>]) -> Result<IdentifiedHinge<T>, HingeRefusal> {
        let weak = |_: Singular| HingeRefusal::Weak { part: HingePart::Axis, sigma: f32::INFINITY };
        self.fit.finish(poses).map_err(weak)?;
        let noise_mm = self.result_noise_mm(poses);
        self.noise_mm = noise_mm;
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
                self.return_to(best, poses);
                continue;
            }
            let (one, two) = (self.off_drawing(&best.hinge), self.off_drawing(&self.fit.hinge));
            match (one, two) {
                (Some(one), Some(two)) if one < T::one() && two > T::of(2.0) => {
                    self.return_to(best, poses);
                }
                (Some(one), Some(two)) if two < T::one() && one > T::of(2.0) => found = self.result(poses)?,
                _ => return Err(judge::two_axes(&self.fit, &best.hinge, &self.fit.hinge)),
            }
        }
        Ok(found)
    }

    /// Back to a finished fit; the poses have the angles of another one.
    fn return_to(&mut self, finished: Fit<T>, poses: &mut [HingePose<T>]) {
        self.fit = finished;
        self.fit.place(poses, true);
        self.fit.settle(poses);
    }

    /// How far a hinge is from the drawing, the limit of what counts as drawn being 1. A drawing that is a prior already
    /// has its say in the squares.
    fn off_drawing(&self, hinge: &Hinge<T>) -> Option<T> {
        let drawing = self.rig.drawing().filter(|drawing| drawing.sigma.is_none())?;
        let (angle, distance) = judge::apart(&self.fit, &drawing.hinge, hinge);
        Some((angle / T::of(AT_DRAWING_RAD)).max(distance / T::of(AT_DRAWING_MM)))
    }
}

/// Standard deviation of the lengths of a cable (from 0), mm.
fn spread<T: Real>(poses: &[HingePose<T>], cable: usize) -> T {
    let count = T::of_integer(poses.len().max(1) as i32);
    let length = |pose: &HingePose<T>| pose.lengths_mm.get(cable).copied().unwrap_or_else(T::zero);
    let mean = poses.iter().fold(T::zero(), |sum, pose| sum + length(pose)) / count;
    let squares = poses.iter().fold(T::zero(), |sum, pose| sum + (length(pose) - mean) * (length(pose) - mean));
    non_negative_root(squares / count)
}
