//! From a settled fit to a result: the gates, in the order in which a cause explains the next.

use super::blame::Blame;
use super::placement::Placement;
use super::settings::Noise;
use super::{FEWEST_AFTER_REJECTION, FEWEST_POSES, Phase, Solver, Weighing, judgement};
use crate::calls::{difference, image};
use crate::identification::blocks::Blocks;
use crate::identification::normal_equations::UNKNOWNS;
use crate::identification::observability::{RotationSum, Sway};
use crate::identification::outcome::{Identified, MOST_REJECTED, Refusal, Rejected, Termination, deviation};
use crate::identification::pose_information::PoseInformation;
use crate::identification::uncertainty::{covariance_of_parameters, packed, worst_direction_of_point};
use crate::identification::zeros::Zeros;
use crate::kinematics::{CableLengths, LengthEquations};
use crate::rig::CABLES;
use crate::scalar::Real;
use crate::symmetric::Symmetric;
use crate::vector::square;
use heapless::Vec;

/// Square of the way that a pose moves the most common axis.
fn moves<T: Real>(placement: &Placement<T>, sway: &Sway<T>) -> T {
    square(&difference(&image(&placement.rotation(), &sway.axis_in_platform), &sway.axis))
}

impl<T: Real, const N: usize, Z: Zeros<T>> Solver<T, N, Z> {
    /// Rotations decide why the normal matrix has no inverse.
    pub(super) fn no_inverse(&self) -> Refusal {
        self.refuse_degenerate(|p| p.is_placed()).err().unwrap_or(Refusal::Singular)
    }

    /// Refuses poses that turn about one axis or are all alike; else tells how they sway.
    #[inline(never)]
    fn refuse_degenerate(&self, used: fn(&Placement<T>) -> bool) -> Result<Sway<T>, Refusal> {
        let mut rotations = RotationSum::default();
        for placement in self.placements.iter().filter(|p| used(p)) {
            rotations.add(&placement.rotation());
        }
        let sway = rotations.sway();
        let supporting = self.poses_that_sway(used, &sway);
        judgement::refuse_degenerate(&sway, supporting, self.settings.sway_limit_rad, self.settings.spread_limit_rad)?;
        Ok(sway)
    }

    /// How many poses move the most common axis, and of how many: a direction that one or two odd poses determine is
    /// not determined, for the others could not contradict them.
    fn poses_that_sway(&self, used: fn(&Placement<T>) -> bool, sway: &Sway<T>) -> (usize, usize) {
        let considerable = sway.least_rad * sway.least_rad * T::of(0.25);
        self.placements.iter().filter(|p| used(p)).fold((0, 0), |(swaying, all), placement| {
            (swaying + usize::from(moves(placement, sway) > considerable), all + 1)
        })
    }

    /// The pose that makes most of the sway, if one does.
    fn makes_most_of_the_sway(&self, sway: &Sway<T>) -> Option<usize> {
        let used = || self.placements.iter().enumerate().filter(|(_, p)| p.is_used());
        let all = used().fold(T::zero(), |sum, (_, p)| sum + moves(p, sway));
        used().find(|(_, p)| moves(p, sway) > all * T::of(judgement::MOST_OF_THE_SWAY)).map(|(pose, _)| pose)
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
                // A bad reading must not hide behind the noise that it pretends: the typical misfit is the measure,
                // unless it is finer than the noise that the rig states. A handful has no typical misfit.
                let typical = if self.placements.len() >= judgement::POSES_TO_ESTIMATE {
                    self.typical_noise_mm().max(self.placer.rig_noise_mm).min(estimate)
                } else {
                    estimate
                };
                let unit = self.noise_mm / typical.max(T::of(judgement::LEAST_NOISE_MM));
                estimate <= most && worst * unit * unit <= T::of(judgement::MISFIT_LIMIT)
            }
        }
    }

    /// Poses that the others contradict, or that fit nowhere.
    fn contradicting(&self) -> usize {
        let limit = T::of(judgement::MISFIT_LIMIT);
        self.placements.iter().filter(|p| !(p.is_placed() && p.misfit <= limit)).count()
    }

    /// Near the octahedron's fold two assemblies fit to within the noise. Where the residuals of the other poses vanish
    /// (noise-free lengths), one that stands in the wrong one stands out though it is no outlier: once a run, such poses
    /// are placed anew by the known centre.
    pub(super) fn accept_unless_beside(
        &mut self,
        weighing: Weighing<T>,
        poses: usize,
        squares_mm2: T,
    ) -> Result<(), Refusal> {
        let limit = judgement::median_misfit(&self.placements) * T::of(judgement::STANDS_OUT);
        let beside = self.placements.iter().any(|p| p.is_used() && p.misfit > limit);
        if !beside || self.doubted {
            return self.accept(poses, squares_mm2);
        }
        self.begin_pass(weighing);
        (self.doubt, self.doubted) = (limit, true);
        Ok(())
    }

    /// Is a pose's misfit far beyond those of the others, and beyond noise?
    pub(super) fn stands_out(&mut self) -> bool {
        let median = judgement::median_misfit(&self.placements);
        let worst = self.placements.iter().fold(T::zero(), |worst, p| worst.max(p.misfit));
        let typical = median.max(T::of(judgement::MEDIAN_OF_CHI_SQUARE_3));
        worst > typical * T::of(judgement::STANDS_OUT)
    }

    /// An unknown noise, estimated from the typical misfit. Bad poses spoil all misfits until they are weighed down, so
    /// the first estimates are too large: true while they fall by a fifth.
    pub(super) fn noise_shrinks(&mut self) -> bool {
        let Noise::EstimatedUpTo(most) = self.settings.noise else { return false };
        let before = self.noise_mm;
        self.noise_mm = self.typical_noise_mm().clamp(T::of(judgement::LEAST_NOISE_MM), most);
        self.noise_mm < before * T::of(0.8)
    }

    /// The noise that the typical misfit speaks of, mm.
    fn typical_noise_mm(&mut self) -> T {
        let poses = T::of_integer(self.placements.len() as i32);
        let median = judgement::median_misfit(&self.placements);
        let typical = median / T::of(judgement::MEDIAN_OF_CHI_SQUARE_3) * poses / (poses - T::of(2.0));
        self.noise_mm * typical.root()
    }

    /// First scale of the annealing; with an unknown noise, its robust estimate too.
    pub(super) fn begin_annealing(&mut self) -> T {
        let median = judgement::median_misfit(&self.placements);
        if let Noise::EstimatedUpTo(_) = self.settings.noise {
            self.noise_shrinks();
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
        self.accept_unless_beside(Weighing::Selected, poses, squares_mm2)
    }

    /// Acceptance is lost; one question is left, whether a few poses are to blame or the joint.
    pub(super) fn look_for_wander(&mut self, poses: usize) -> Result<(), Refusal> {
        let rejected = self.contradicting();
        // What is wrong may still be the poses rather than the joint.
        self.refuse_degenerate(|p| p.is_placed())?;
        match self.placements.iter().filter(|p| p.is_placed()).count() {
            0..FEWEST_POSES => Err(Refusal::TooManyOutliers { rejected: rejected as u16, poses: poses as u16 }),
            _ => {
                self.begin_pass(Weighing::Wander { left: 1, rejected: rejected as u16 });
                Ok(())
            }
        }
    }

    /// The noise, mm, and how much wider than it alone the error bar must be.
    fn noise_of_error_bar(&self, squares_mm2: T) -> (T, T) {
        let freedom = T::of_integer((3 * self.sum.poses as i32 - UNKNOWNS as i32).max(1));
        match self.settings.noise {
            // Residuals that sound sets leave only once in twenty widen the error bar (Birge's ratio). Poses that were
            // left out by a close call are counted in: of few poses, the worst leaves the others looking too good.
            Noise::Known(noise) => {
                let (squares, freedom) =
                    self.close_calls().fold((squares_mm2, freedom), |(squares, freedom), misfit| {
                        (squares + misfit * self.noise_mm * self.noise_mm, freedom + T::of(3.0))
                    });
                let limit = noise * noise * judgement::chi_square_limit(freedom, judgement::WIDENING);
                (if squares > limit { (squares / freedom).root() } else { noise }, T::one())
            }
            // A variance estimated from few residuals is too small too often: the rig's own noise is worth a few more.
            // Residuals beyond the rig's noise may also be one bad reading's that few poses cannot show as such.
            Noise::EstimatedUpTo(_) => {
                let prior = T::of(judgement::PRIOR_FREEDOM);
                let rig = self.placer.rig_noise_mm;
                let pooled = ((squares_mm2 + prior * rig * rig) / (freedom + prior)).root();
                let beyond = squares_mm2 > rig * rig * judgement::chi_square_limit(freedom, judgement::FALSE_ALARM);
                let few = self.sum.poses < judgement::POSES_TO_ESTIMATE;
                let widening = if beyond && few { T::of(judgement::WIDENING_FOR_ONE_BAD_READING) } else { T::one() };
                (pooled, widening)
            }
        }
    }

    /// The misfits of the poses that were left out, but not by far.
    fn close_calls(&self) -> impl Iterator<Item = T> {
        let clear = T::of(judgement::CLEARLY_OUT);
        self.placements.iter().filter(move |p| p.is_placed() && !p.is_used() && p.misfit <= clear).map(|p| p.misfit)
    }

    /// The last gates, then the result; poses left out are explained next.
    #[inline(never)]
    pub(super) fn accept(&mut self, poses: usize, squares_mm2: T) -> Result<(), Refusal> {
        let sway = self.refuse_degenerate(|p| p.is_used())?;
        let (noise_mm, widening) = self.noise_of_error_bar(squares_mm2);
        let mut zero_variances = [T::zero(); CABLES];
        let covariance = self.zeros.covariance(&self.sum.equations, &mut zero_variances);
        let Ok(of_pivot) = &covariance else { return Err(Refusal::Singular) };
        // Noise-free lengths must not pass a geometry that noise would ruin.
        let bar = noise_mm * widening;
        let gate = bar.max(self.placer.rig_noise_mm);
        self.refuse_weak(&of_pivot.first, &zero_variances, gate)?;
        let deviation_mm = deviation(squares_mm2, self.sum.poses);
        let covariance = covariance_of_parameters(of_pivot, &self.pivot, &self.placer.points);
        self.write_result(poses, deviation_mm, noise_mm, bar, &covariance, &zero_variances, sway.least_rad);
        self.begin_check(&sway)
    }

    /// The result, with `bar` as the noise of its error bar, mm.
    #[inline(never)]
    #[allow(clippy::too_many_arguments)]
    fn write_result(
        &mut self,
        poses: usize,
        deviation_mm: T,
        noise_mm: T,
        bar: T,
        unit: &Blocks<T>,
        zero_variances: &[T; CABLES],
        sway_rad: T,
    ) {
        // Written where it stays: on the stack it would be the largest thing there.
        let result = self.result.insert(Identified {
            parameters: self.pivot.parameters(&self.placer.points),
            covariance_mm2: packed(unit, bar * bar),
            noise_mm,
            deviation_mm,
            deviations_mm: Vec::new(),
            iterations: self.deviations_mm.len() as u8,
            termination: Termination::Settled,
            poses: poses as u16,
            rejected: Vec::new(),
            sway_rad,
            zeros_mm: self.zeros.estimate_mm().copied().unwrap_or([T::zero(); CABLES]),
            zero_sigmas_mm: zero_variances.map(|variance| variance.max(T::zero()).root() * bar),
        });
        result.deviations_mm.clone_from(&self.deviations_mm);
        for (pose, placement) in self.placements.iter().enumerate() {
            if !placement.is_used() {
                let _ = result.rejected.push(Rejected { pose: pose as u16, cables: placement.broken_cables() });
            }
        }
    }

    /// Which poses are to be doubted: all of a few, or the one that makes most of the sway.
    fn begin_check(&mut self, sway: &Sway<T>) -> Result<(), Refusal> {
        self.phase = Phase::Blame(Blame::new());
        if !self.settings.refuse_hanging {
            return Ok(());
        }
        if self.sum.poses <= FEWEST_POSES {
            // Two poses never suffice; rounding may hide that in the equations that are left.
            let first = self.placements.iter().position(Placement::is_used).unwrap_or(0);
            return Err(Refusal::HangsOnOnePose { pose: first as u16 });
        }
        if self.sum.poses <= judgement::FEW_POSES {
            (self.phase, self.next) = (Phase::Check { last: self.placements.len() }, 0);
        } else if let Some(pose) = self.makes_most_of_the_sway(sway) {
            (self.phase, self.next) = (Phase::Check { last: pose + 1 }, pose);
        }
        Ok(())
    }

    /// Takes the next pose away from the result: the centre must still be determined, though worse.
    #[inline(never)]
    pub(super) fn check_without(&mut self, lengths: &CableLengths<T>) -> Result<(), Refusal> {
        let pose = self.next as u16;
        let placement = self.placements.get(self.next).filter(|p| p.is_used());
        self.next += 1;
        let Some(placement) = placement else { return Ok(()) };
        let lengths = self.zeros.corrected(lengths);
        let rotation = placement.rotation();
        let equations = LengthEquations::new(&self.placer.points, &self.pivot, &rotation, &lengths);
        let Some(known) = &PoseInformation::of(&equations) else { return Ok(()) };
        let refused = Refusal::HangsOnOnePose { pose };
        let all = self.zeros.centre_covariance(&self.sum.equations).map_err(|_| refused)?;
        let mut without = self.sum.equations;
        without.add_pose(&rotation, &known.eliminated.rest, &known.gradient_mm, -T::one());
        let mut zeros = self.zeros.clone();
        zeros.add_pose(&rotation, &equations, known, -T::one());
        // Four poses hardly contradict each other when there are zeros to be found as well, and the prior hides it: it
        // alone bounds the error bar of what is left. So few poses get no more indulgence than many.
        let fewest = if zeros.take_part() { judgement::FEW_POSES } else { 0 };
        let limit = worst_direction_of_point(&all).0 * judgement::limit_without_one_pose(self.sum.poses.max(fewest));
        let stands = zeros.centre_covariance(&without).is_ok_and(|rest| worst_direction_of_point(&rest).0 <= limit);
        if stands { Ok(()) } else { Err(refused) }
    }

    /// Refuses an error bar that is too wide, and says when it is the unknown zeros that widen it.
    #[inline(never)]
    fn refuse_weak(&self, unit: &Symmetric<T>, zero_variances: &[T; CABLES], noise_mm: T) -> Result<(), Refusal> {
        let limit = self.settings.sigma_limit_mm;
        let refused = judgement::refuse_weak(unit, noise_mm, limit);
        if refused.is_err() && self.zeros.take_part() {
            let known = self.sum.equations.matrix.first_inverse().map_err(|_| Refusal::Singular)?;
            if judgement::refuse_weak(&known, noise_mm, limit).is_ok() {
                let worst = (0..CABLES).fold(0, |w, k| if zero_variances[k] > zero_variances[w] { k } else { w });
                return Err(Refusal::ZeroNotDetermined {
                    cable: worst as u8 + 1,
                    sigma_mm: (zero_variances[worst].max(T::zero()).root() * noise_mm).to_f32(),
                });
            }
        }
        refused
    }
}
