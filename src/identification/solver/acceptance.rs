//! From a settled fit to a result: the gates, in the order in which a cause explains the next.

use super::accumulation::PassSum;
use super::blame::Blame;
use super::judgement::Misfits;
use super::placement::State;
use super::{FEWEST_AFTER_REJECTION, FEWEST_POSES, Phase, Solver, Weighing, judgement};
use crate::calls::{difference, dot, image, root};
use crate::identification::observability::RotationSum;
use crate::identification::outcome::{MOST_REJECTED, Refusal, Rejected};
use crate::identification::uncertainty::{parameters_of, worst_direction_of_point};
use crate::identification::zeros::Zeros;
use crate::kinematics::CableLengths;
use crate::kinematics::cable_length::cable_number;
use crate::scalar::Real;
use crate::symmetric::Symmetric;

/// There will be no result, and the solver's state says why.
struct Refused;

impl<T: Real, const N: usize, Z: Zeros<T>> Solver<T, N, Z> {
    /// Rotations decide why the normal matrix has no inverse.
    #[inline(never)]
    pub(super) fn refuse_no_inverse(&mut self) {
        if self.refuse_degenerate(State::Placed).is_ok() {
            self.refuse(Refusal::Singular);
        }
    }

    /// Refuses poses that are all alike, that turn about one axis, or of which hardly any (fewer than two and a tenth of
    /// them) does not: a direction that one or two odd poses determine is not determined, for the others could not
    /// contradict them. Else keeps how they sway, and tells which pose makes most of it, if one does. `least`: only of
    /// the poses that have come so far.
    #[inline(never)]
    fn refuse_degenerate(&mut self, least: State) -> Result<Option<usize>, Refused> {
        let mut rotations = RotationSum::default();
        for placement in &self.placements {
            if placement.state >= least {
                rotations.add(&placement.rotation());
            }
        }
        let sway = rotations.sway();
        let square_of_sway = sway.least_rad * sway.least_rad;
        let (mut swaying, mut all, mut largest, mut most) = (0_usize, 0_usize, T::zero(), 0);
        for (pose, placement) in self.placements.iter().enumerate() {
            if placement.state >= least {
                let moved = difference(&image(&placement.rotation(), &sway.axis_in_platform), &sway.axis);
                let square = dot(&moved, &moved);
                all += 1;
                swaying += usize::from(square > square_of_sway * T::of(0.25));
                if square > largest {
                    (largest, most) = (square, pose);
                }
            }
        }
        self.result.sway_rad = sway.least_rad;
        if sway.second_rad < self.settings.spread_limit_rad {
            self.refuse(Refusal::TooAlike { spread_rad: sway.second_rad.to_f32() });
            return Err(Refused);
        }
        if sway.least_rad < self.settings.sway_limit_rad || 10 * swaying <= all + 10 {
            let axis = judgement::to_f32(&sway.axis);
            self.refuse(Refusal::OneAxis { axis, sway_rad: sway.least_rad.to_f32() });
            return Err(Refused);
        }
        // The sway is the root of the squares' mean.
        let sum = square_of_sway * T::of_integer(all as i32);
        Ok((largest > sum * T::of(judgement::MOST_OF_THE_SWAY)).then_some(most))
    }

    /// Poses that the others contradict, or that fit nowhere.
    #[inline(never)]
    fn contradicting(&self) -> usize {
        self.placements.len() - judgement::fitting(&self.placements, T::of(judgement::MISFIT_LIMIT))
    }

    /// Near the octahedron's fold two assemblies fit to within the noise. Where the residuals of the other poses vanish
    /// (noise-free lengths), one that stands in the wrong one stands out though it is no outlier: once a run, such poses
    /// are placed anew by the known centre.
    #[inline(never)]
    pub(super) fn accept_unless_beside(&mut self) {
        let limit = self.misfits.median * T::of(judgement::STANDS_OUT);
        let beside = judgement::fitting(&self.placements, limit) < self.sum.poses;
        if !beside || self.doubted {
            return self.accept();
        }
        self.begin_pass();
        (self.doubt, self.doubted) = (limit, true);
    }

    /// Is a pose's misfit far beyond those of the others, and beyond noise?
    pub(super) fn stands_out(&self) -> bool {
        let Misfits { median, worst } = self.misfits;
        worst > median.max(T::of(judgement::MEDIAN_OF_CHI_SQUARE_3)) * T::of(judgement::STANDS_OUT)
    }

    /// After the selection: are enough poses left, and is what they leave noise?
    pub(super) fn judge_selection(&mut self) {
        let rejected = self.placements.len() - self.sum.poses;
        let fewest = if rejected > 0 { FEWEST_AFTER_REJECTION } else { FEWEST_POSES };
        let too_many = rejected * 5 > self.placements.len() || rejected > MOST_REJECTED || self.sum.poses < fewest;
        if too_many || !self.selection_is_noise() {
            return self.look_for_wander();
        }
        self.accept_unless_beside();
    }

    /// Acceptance is lost; one question is left, whether a few poses are to blame or the joint.
    #[inline(never)]
    pub(super) fn look_for_wander(&mut self) {
        let rejected = self.contradicting() as u16;
        // What is wrong may still be the poses rather than the joint.
        if self.refuse_degenerate(State::Placed).is_ok() {
            self.begin_weighing(Weighing::Wander { rejected });
        }
    }

    /// How far the centre wanders, or that a few poses alone are to blame.
    pub(super) fn refuse_wander(&mut self, rejected: u16) {
        let variance = self.sum.squares_left_mm2 / self.freedom();
        let median = self.misfits.median;
        // A normal scatter in space has a mean of its squares 1.27 times their median; a few poses far off, much more.
        if variance * T::of(3.0) <= median * T::of(judgement::SCATTER_RATIO) {
            self.refuse(Refusal::NotABall { wander_mm: root(variance).to_f32() });
        } else {
            self.refuse_outliers(rejected);
        }
    }

    pub(super) fn refuse_outliers(&mut self, rejected: u16) {
        self.refuse(Refusal::TooManyOutliers { rejected, poses: self.placements.len() as u16 });
    }

    /// The last gates, then the result; poses left out are explained next.
    #[inline(never)]
    pub(super) fn accept(&mut self) {
        let Ok(most) = self.refuse_degenerate(State::Used) else { return };
        let (noise_mm, bar_mm) = self.noise_of_error_bar();
        let Ok(of_pivot) = &self.zeros.covariance(&self.sum.equations) else { return self.refuse(Refusal::Singular) };
        // Noise-free lengths must not pass a geometry that noise would ruin.
        if self.refuse_weak(&of_pivot.first, bar_mm.max(self.placer.rig_noise_mm)).is_err() {
            return;
        }
        let (result, points) = (&mut self.result, &self.placer.points);
        let (parameters, covariance) = (&mut result.parameters, &mut result.covariance_mm2);
        parameters_of(&self.pivot, of_pivot, bar_mm * bar_mm, points, parameters, covariance);
        result.noise_mm = noise_mm;
        result.iterations = result.deviations_mm.len() as u8;
        result.poses = self.placements.len() as u16;
        self.zeros.write(bar_mm, result);
        result.rejected.clear();
        for (pose, placement) in self.placements.iter().enumerate() {
            if !placement.is_used() {
                let _ = result.rejected.push(Rejected { pose: pose as u16, cables: placement.broken_cables });
            }
        }
        self.begin_check(most);
    }

    /// Which poses are to be doubted: all of a few, or the one that makes most of the sway.
    fn begin_check(&mut self, most: Option<usize>) {
        (self.phase, self.blame) = (Phase::Blame, Blame::new());
        if !self.settings.refuse_hanging {
            return;
        }
        if self.sum.poses <= judgement::FEW_POSES {
            (self.phase, self.next) = (Phase::Check { last: self.placements.len() }, 0);
        } else if let Some(pose) = most {
            (self.phase, self.next) = (Phase::Check { last: pose + 1 }, pose);
        }
    }

    /// Takes the next pose away from the result: the centre must still be determined, though worse.
    #[inline(never)]
    pub(super) fn check_without(&mut self, lengths: &CableLengths<T>) {
        let pose = self.next;
        self.next += 1;
        // Nothing reads the placement after acceptance: it may settle once more.
        let Some(placement) = self.placements.get_mut(pose).filter(|p| p.is_used()) else { return };
        let lengths = self.zeros.corrected(lengths);
        let (mut without, mut zeros) = (self.sum, self.zeros.clone());
        let at = (&self.placer.points, &self.pivot);
        without.add(placement, &mut zeros, at, &lengths, self.noise_mm, &Weighing::Without);
        // Four poses hardly contradict each other when there are zeros to be found as well, and the prior hides it: it
        // alone bounds the error bar of what is left. So few poses get no more indulgence than many.
        let fewest = if zeros.take_part() { judgement::FEW_POSES } else { 0 };
        let limit = judgement::limit_without_one_pose::<T>(self.sum.poses.max(fewest));
        let stands = centre_sigma(&zeros, &without) <= centre_sigma(&self.zeros, &self.sum) * limit;
        if !stands {
            self.refuse(Refusal::HangsOnOnePose { pose: pose as u16 });
        }
    }

    /// Refuses an error bar that is too wide, and says when it is the unknown zeros that widen it.
    #[inline(never)]
    fn refuse_weak(&mut self, unit: &Symmetric<T>, noise_mm: T) -> Result<(), Refused> {
        let limit = self.settings.sigma_limit_mm;
        let (sigma, direction) = worst_direction_of_point(unit);
        let sigma_mm = sigma * noise_mm;
        // Also refuses NaN, and what is infinite where no limit is set.
        if sigma_mm <= limit && sigma_mm.is_a_number() {
            return Ok(());
        }
        let mut refusal = Refusal::Weak { direction: direction.map(Real::to_f32), sigma_mm: sigma_mm.to_f32() };
        if let Some((worst, sigma)) = self.zeros.worst()
            && let Ok(known) = self.sum.equations.matrix.first_inverse()
            && worst_direction_of_point(&known).0 * noise_mm <= limit
        {
            let sigma_mm = (sigma * noise_mm).to_f32();
            refusal = Refusal::ZeroNotDetermined { cable: cable_number(worst), sigma_mm };
        }
        self.refuse(refusal);
        Err(Refused)
    }
}

/// 1σ of the centre in its worst direction for a noise of 1 mm; infinite where it is not determined.
#[inline(never)]
fn centre_sigma<T: Real>(zeros: &impl Zeros<T>, sum: &PassSum<T>) -> T {
    let covariance = zeros.centre_covariance(&sum.equations);
    covariance.map_or(T::of(f64::INFINITY), |covariance| worst_direction_of_point(&covariance).0)
}
