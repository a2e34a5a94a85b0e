//! From a settled fit to a result: the gates, in the order in which a cause explains the next.

use super::blame::Blame;
use super::placement::Placement;
use super::settings::Noise;
use super::{FEWEST_AFTER_REJECTION, FEWEST_POSES, Phase, Solver, Weighing, judgement};
use crate::identification::normal_equations::{Factors, PACKED, UNKNOWNS};
use crate::identification::observability::{RotationSum, Sway};
use crate::identification::outcome::{Identified, MOST_REJECTED, Refusal, Rejected, Termination, deviation};
use crate::identification::pose_information::PoseInformation;
use crate::identification::uncertainty::{covariance_of_parameters, worst_centre_direction};
use crate::kinematics::{CableLengths, LengthEquations};
use crate::rig::CABLES;
use crate::scalar::Real;
use heapless::Vec;

impl<T: Real, const N: usize> Solver<T, N> {
    /// Rotations decide why the normal matrix has no inverse.
    pub(super) fn no_inverse(&self) -> Refusal {
        self.degenerate(|p| p.is_placed()).err().unwrap_or(Refusal::Singular)
    }

    /// Refuses poses that turn about one axis or are all alike; else their sway, rad.
    fn degenerate(&self, used: impl Fn(&Placement<T>) -> bool) -> Result<T, Refusal> {
        let mut rotations = RotationSum::default();
        for placement in self.placements.iter().filter(|p| used(p)) {
            rotations.add(&placement.rotation());
        }
        let sway = rotations.sway();
        let supporting = self.poses_that_sway(&used, &sway);
        judgement::refuse_degenerate(&sway, supporting, self.settings.sway_limit_rad, self.settings.spread_limit_rad)?;
        Ok(sway.least_rad)
    }

    /// How many poses move the most common axis, and of how many: a direction that one or two odd poses determine is
    /// not determined, for the others could not contradict them.
    fn poses_that_sway(&self, used: impl Fn(&Placement<T>) -> bool, sway: &Sway<T>) -> (usize, usize) {
        let considerable = sway.least_rad * sway.least_rad * T::of(0.25);
        self.placements.iter().filter(|p| used(p)).fold((0, 0), |(swaying, all), placement| {
            let moved = (placement.rotation() * sway.axis_in_platform - sway.axis).norm_squared();
            (swaying + usize::from(moved > considerable), all + 1)
        })
    }

    /// Are the residuals no larger than the noise explains?
    pub(super) fn residuals_are_noise(&mut self, squares_mm2: T) -> bool {
        let freedom = 3 * self.sum.poses as i32 - UNKNOWNS as i32;
        match self.settings.noise {
            Noise::Known(noise) => {
                let limit = judgement::chi_square_limit(T::of_integer(freedom.max(1)), judgement::FALSE_ALARM);
                squares_mm2 <= noise * noise * limit
            }
            Noise::EstimatedUpTo(most) => {
                let estimate = (squares_mm2 / T::of_integer(freedom.max(1))).root();
                let worst = self.placements.iter().fold(T::zero(), |worst, p| worst.max(p.misfit));
                // `misfit` is in units of the present noise figure; outliers stand out against the others.
                let floor = T::of(judgement::LEAST_NOISE_MM);
                let unit = self.noise_mm / estimate.max(floor);
                estimate <= most && worst * unit * unit <= T::of(judgement::MISFIT_LIMIT)
            }
        }
    }

    /// Poses that the others contradict, or that fit nowhere.
    fn contradicting(&self) -> usize {
        let limit = T::of(judgement::MISFIT_LIMIT);
        self.placements.iter().filter(|p| !(p.is_placed() && p.misfit <= limit)).count()
    }

    /// Is a pose's misfit far beyond those of the others, and beyond noise?
    pub(super) fn stands_out(&mut self) -> bool {
        let median = judgement::median_misfit(&mut self.placements);
        let worst = self.placements.iter().fold(T::zero(), |worst, p| worst.max(p.misfit));
        let typical = median.max(T::of(judgement::MEDIAN_OF_CHI_SQUARE_3));
        worst > typical * T::of(judgement::STANDS_OUT)
    }

    /// First scale of the annealing; with an unknown noise, its robust estimate too.
    pub(super) fn begin_annealing(&mut self) -> T {
        let median = judgement::median_misfit(&mut self.placements);
        if let Noise::EstimatedUpTo(most) = self.settings.noise {
            let poses = T::of_integer(self.placements.len() as i32);
            let typical = median / T::of(judgement::MEDIAN_OF_CHI_SQUARE_3) * poses / (poses - T::of(2.0));
            let noise = (self.noise_mm * typical.root()).clamp(T::of(judgement::LEAST_NOISE_MM), most);
            self.noise_mm = noise;
            return T::of(judgement::ANNEALED_SCALE * 8.0);
        }
        (median * T::of(3.0)).max(T::of(judgement::ANNEALED_SCALE))
    }

    /// After the selection: are enough poses left, and is what they leave noise?
    pub(super) fn judge_selection(&mut self, poses: usize, squares_mm2: T) -> Result<(), Refusal> {
        let rejected = self.contradicting();
        let fewest = if rejected > 0 { FEWEST_AFTER_REJECTION } else { FEWEST_POSES };
        let too_many = rejected * 5 > poses || rejected > MOST_REJECTED || self.sum.poses < fewest;
        let noise_fits = match self.settings.noise {
            Noise::Known(_) => self.residuals_are_noise(squares_mm2),
            Noise::EstimatedUpTo(most) => {
                let freedom = 3 * self.sum.poses as i32 - UNKNOWNS as i32;
                (squares_mm2 / T::of_integer(freedom.max(1))).root() <= most
            }
        };
        if too_many || !noise_fits {
            return self.look_for_wander(poses);
        }
        self.accept(poses, squares_mm2)
    }

    /// Acceptance is lost; one question is left, whether a few poses are to blame or the joint.
    pub(super) fn look_for_wander(&mut self, poses: usize) -> Result<(), Refusal> {
        let rejected = self.contradicting();
        // What is wrong may still be the poses rather than the joint.
        self.degenerate(|p| p.is_placed())?;
        match self.placements.iter().filter(|p| p.is_placed()).count() {
            0..FEWEST_POSES => Err(Refusal::TooManyOutliers { rejected: rejected as u16, poses: poses as u16 }),
            _ => {
                self.begin_pass(Weighing::Wander { left: 1, rejected: rejected as u16 });
                Ok(())
            }
        }
    }

    /// The last gates, then the result; poses left out are explained next.
    pub(super) fn accept(&mut self, poses: usize, squares_mm2: T) -> Result<(), Refusal> {
        let sway_rad = self.degenerate(|p| p.is_used())?;
        let reduced = self.sum.reduced().map_err(|_| Refusal::Singular)?;
        let equations = reduced.as_ref().map_or(&self.sum.equations, |reduced| &reduced.equations);
        let factors = Factors::of(&equations.matrix).map_err(|_| Refusal::Singular)?;
        let freedom = T::of_integer((3 * self.sum.poses as i32 - UNKNOWNS as i32).max(1));
        let noise_mm = match self.settings.noise {
            // Residuals that sound sets leave only once in twenty widen the error bar (Birge's ratio).
            Noise::Known(noise)
                if squares_mm2 > noise * noise * judgement::chi_square_limit(freedom, judgement::WIDENING) =>
            {
                (squares_mm2 / freedom).root()
            }
            Noise::Known(noise) => noise,
            // A variance estimated from few residuals is too small too often: the rig's own noise is worth a few more.
            Noise::EstimatedUpTo(_) => {
                let prior = T::of(judgement::PRIOR_FREEDOM);
                let rig = self.placer.rig_noise_mm;
                ((squares_mm2 + prior * rig * rig) / (freedom + prior)).root()
            }
        };
        let of_pivot = factors.inverse();
        let unit = covariance_of_parameters(&of_pivot, &self.pivot, &self.placer.points);
        // Noise-free lengths must not pass a geometry that noise would ruin.
        let gate = noise_mm.max(self.placer.rig_noise_mm);
        let zeros_variance = reduced.map_or([T::zero(); CABLES], |reduced| reduced.zeros_variance(&of_pivot));
        self.refuse_weak(&unit, &zeros_variance, gate)?;
        let mut rejected = Vec::new();
        for (pose, placement) in self.placements.iter().enumerate() {
            if !placement.is_used() {
                let _ = rejected.push(Rejected { pose: pose as u16, cables: placement.broken_cables() });
            }
        }
        self.result = Some(Identified {
            parameters: self.pivot.parameters(&self.placer.points),
            covariance_mm2: unit.map(|entry| entry * noise_mm * noise_mm),
            noise_mm,
            deviation_mm: deviation(squares_mm2, self.sum.poses),
            deviations_mm: self.deviations_mm.clone(),
            iterations: self.iterations(),
            termination: Termination::Settled,
            poses: poses as u16,
            rejected,
            sway_rad,
            zeros_mm: self.zeros_mm,
            zero_sigmas_mm: zeros_variance.map(|variance| variance.max(T::zero()).root() * noise_mm),
        });
        self.next = 0;
        self.phase = if self.settings.refuse_hanging && self.sum.poses <= judgement::FEW_POSES {
            Phase::Check
        } else {
            Phase::Blame(Blame::new())
        };
        Ok(())
    }

    /// Takes the next pose away from the result: the centre must still be determined, though worse.
    pub(super) fn check_without(&mut self, lengths: &CableLengths<T>) -> Result<(), Refusal> {
        let pose = self.next as u16;
        let placement = self.placements.get(self.next).filter(|p| p.is_used());
        self.next += 1;
        let (Some(placement), Ok(lengths)) = (placement, lengths.less(&self.zeros_mm)) else { return Ok(()) };
        let rotation = placement.rotation();
        let equations = LengthEquations::new(&self.placer.points, &self.pivot, &rotation, &lengths);
        let Some(known) = PoseInformation::of(&equations) else { return Ok(()) };
        let mut without = self.sum.equations;
        without.add_information(&rotation, &-known.information, &-known.gradient_mm);
        let all = Factors::of(&self.sum.equations.matrix).map_err(|_| Refusal::Singular)?;
        let (limit, _) = worst_centre_direction(&all.inverse());
        let limit = limit * T::of(judgement::WITHOUT_ONE_POSE);
        let stands = Factors::of(&without.matrix).is_ok_and(|rest| worst_centre_direction(&rest.inverse()).0 <= limit);
        if stands { Ok(()) } else { Err(Refusal::HangsOnOnePose { pose }) }
    }

    /// Refuses an error bar that is too wide, and says when it is the unknown zeros that widen it.
    fn refuse_weak(&self, unit: &[T; PACKED], zeros_variance: &[T; CABLES], noise_mm: T) -> Result<(), Refusal> {
        let limit = self.settings.sigma_limit_mm;
        let refused = judgement::refuse_weak(unit, noise_mm, limit);
        if refused.is_err() && self.sum.zeros.is_some() {
            let known = Factors::of(&self.sum.equations.matrix).map_err(|_| Refusal::Singular)?.inverse();
            let known = covariance_of_parameters(&known, &self.pivot, &self.placer.points);
            if judgement::refuse_weak(&known, noise_mm, limit).is_ok() {
                let worst = (0..CABLES).fold(0, |w, k| if zeros_variance[k] > zeros_variance[w] { k } else { w });
                return Err(Refusal::ZeroNotDetermined {
                    cable: worst as u8 + 1,
                    sigma_mm: (zeros_variance[worst].max(T::zero()).root() * noise_mm).to_f32(),
                });
            }
        }
        refused
    }
}
