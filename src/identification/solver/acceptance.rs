//! From a settled fit to a result: the gates, in the order in which a cause explains the next.

use super::blame::Blame;
use super::judgement::Misfits;
use super::placement::Placement;
use super::{FEWEST_AFTER_REJECTION, FEWEST_POSES, Phase, Solver, Weighing, judgement};
use crate::calls::{difference, dot, image};
use crate::identification::observability::{RotationSum, Sway};
use crate::identification::outcome::{MOST_REJECTED, Refusal, Rejected, deviation};
use crate::identification::pose_information::PoseInformation;
use crate::identification::uncertainty::{covariance_of_parameters, pack, worst_direction_of_point};
use crate::identification::zeros::Zeros;
use crate::kinematics::cable_length::cable_number;
use crate::kinematics::{CableLengths, LengthEquations};
use crate::scalar::Real;
use crate::symmetric::Symmetric;

/// How a set of poses moves its most common axis.
pub(super) struct Support<T> {
    sway: Sway<T>,
    /// The pose that makes most of the sway, if one does.
    most: Option<usize>,
}

impl<T: Real, const N: usize, Z: Zeros<T>> Solver<T, N, Z> {
    /// Rotations decide why the normal matrix has no inverse.
    pub(super) fn no_inverse(&self) -> Refusal {
        self.refuse_degenerate(false).err().unwrap_or(Refusal::Singular)
    }

    /// Refuses poses that are all alike, that turn about one axis, or of which hardly any (fewer than two and a tenth of
    /// them) does not: a direction that one or two odd poses determine is not determined, for the others could not
    /// contradict them. Else tells how they sway. `used`: only those that took part in the last pass.
    #[inline(never)]
    fn refuse_degenerate(&self, used: bool) -> Result<Support<T>, Refusal> {
        let takes_part = |placement: &Placement<T>| placement.is_used() || placement.is_placed() && !used;
        let mut rotations = RotationSum::default();
        for placement in &self.placements {
            if takes_part(placement) {
                rotations.add(&placement.rotation());
            }
        }
        let sway = rotations.sway();
        let square_of_sway = sway.least_rad * sway.least_rad;
        let (mut swaying, mut all, mut largest, mut most) = (0, 0, T::zero(), 0);
        for (pose, placement) in self.placements.iter().enumerate() {
            if takes_part(placement) {
                let moved = difference(&image(&placement.rotation(), &sway.axis_in_platform), &sway.axis);
                let square = dot(&moved, &moved);
                all += 1;
                swaying += usize::from(square > square_of_sway * T::of(0.25));
                if square > largest {
                    (largest, most) = (square, pose);
                }
            }
        }
        if sway.second_rad < self.settings.spread_limit_rad {
            return Err(Refusal::TooAlike { spread_rad: sway.second_rad.to_f32() });
        }
        if sway.least_rad < self.settings.sway_limit_rad || swaying < 2 + all / 10 {
            return Err(Refusal::OneAxis { axis: judgement::to_f32(&sway.axis), sway_rad: sway.least_rad.to_f32() });
        }
        // The sway is the root of the squares' mean.
        let sum = square_of_sway * T::of_integer(all as i32);
        let most = (largest > sum * T::of(judgement::MOST_OF_THE_SWAY)).then_some(most);
        Ok(Support { sway, most })
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
        let limit = judgement::misfits(&self.placements).median * T::of(judgement::STANDS_OUT);
        let beside = self.placements.iter().any(|p| p.is_used() && p.misfit > limit);
        if !beside || self.doubted {
            return self.accept(poses, squares_mm2);
        }
        self.begin_pass(weighing);
        (self.doubt, self.doubted) = (limit, true);
        Ok(())
    }

    /// Is a pose's misfit far beyond those of the others, and beyond noise?
    pub(super) fn stands_out(&self) -> bool {
        let Misfits { median, worst } = judgement::misfits(&self.placements);
        worst > median.max(T::of(judgement::MEDIAN_OF_CHI_SQUARE_3)) * T::of(judgement::STANDS_OUT)
    }

    /// After the selection: are enough poses left, and is what they leave noise?
    pub(super) fn judge_selection(&mut self, poses: usize, squares_mm2: T) -> Result<(), Refusal> {
        let rejected = self.contradicting();
        let fewest = if rejected > 0 { FEWEST_AFTER_REJECTION } else { FEWEST_POSES };
        let too_many = rejected * 5 > poses || rejected > MOST_REJECTED || self.sum.poses < fewest;
        if too_many || !self.selection_is_noise(squares_mm2) {
            return self.look_for_wander(poses);
        }
        self.accept_unless_beside(Weighing::Selected, poses, squares_mm2)
    }

    /// Acceptance is lost; one question is left, whether a few poses are to blame or the joint.
    pub(super) fn look_for_wander(&mut self, poses: usize) -> Result<(), Refusal> {
        let rejected = self.contradicting();
        // What is wrong may still be the poses rather than the joint.
        self.refuse_degenerate(false)?;
        match self.placements.iter().filter(|p| p.is_placed()).count() {
            0..FEWEST_POSES => Err(Refusal::TooManyOutliers { rejected: rejected as u16, poses: poses as u16 }),
            _ => {
                self.begin_pass(Weighing::Wander { left: 1, rejected: rejected as u16 });
                Ok(())
            }
        }
    }

    /// The last gates, then the result; poses left out are explained next.
    #[inline(never)]
    pub(super) fn accept(&mut self, poses: usize, squares_mm2: T) -> Result<(), Refusal> {
        let Support { sway, most } = self.refuse_degenerate(true)?;
        let (noise_mm, widening) = self.noise_of_error_bar(squares_mm2);
        let Ok(of_pivot) = &self.zeros.covariance(&self.sum.equations) else { return Err(Refusal::Singular) };
        let bar_mm = noise_mm * widening;
        // Noise-free lengths must not pass a geometry that noise would ruin.
        self.refuse_weak(&of_pivot.first, bar_mm.max(self.placer.rig_noise_mm))?;
        let covariance = covariance_of_parameters(of_pivot, &self.pivot, &self.placer.points);
        let result = &mut self.result;
        result.parameters = self.pivot.parameters(&self.placer.points);
        pack(&covariance, bar_mm * bar_mm, &mut result.covariance_mm2);
        result.noise_mm = noise_mm;
        result.deviation_mm = deviation(squares_mm2, self.sum.poses);
        result.iterations = result.deviations_mm.len() as u8;
        result.poses = poses as u16;
        result.sway_rad = sway.least_rad;
        self.zeros.write(bar_mm, result);
        result.rejected.clear();
        for (pose, placement) in self.placements.iter().enumerate() {
            if !placement.is_used() {
                let _ = result.rejected.push(Rejected { pose: pose as u16, cables: placement.broken_cables() });
            }
        }
        self.begin_check(most)
    }

    /// Which poses are to be doubted: all of a few, or the one that makes most of the sway.
    fn begin_check(&mut self, most: Option<usize>) -> Result<(), Refusal> {
        (self.phase, self.blame) = (Phase::Blame, Blame::new());
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
        } else if let Some(pose) = most {
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
        let mut known = PoseInformation::empty();
        if known.set(&equations).is_err() {
            return Ok(());
        }
        let refused = Refusal::HangsOnOnePose { pose };
        let all = self.zeros.centre_covariance(&self.sum.equations).map_err(|_| refused)?;
        let mut without = self.sum.equations;
        without.add_pose(&rotation, &known.information, &known.gradient_mm, -T::one());
        let mut zeros = self.zeros.clone();
        zeros.add_pose(&rotation, &equations, &known, -T::one());
        // Four poses hardly contradict each other when there are zeros to be found as well, and the prior hides it: it
        // alone bounds the error bar of what is left. So few poses get no more indulgence than many.
        let fewest = if zeros.take_part() { judgement::FEW_POSES } else { 0 };
        let limit = worst_direction_of_point(&all).0 * judgement::limit_without_one_pose(self.sum.poses.max(fewest));
        let stands = zeros.centre_covariance(&without).is_ok_and(|rest| worst_direction_of_point(&rest).0 <= limit);
        if stands { Ok(()) } else { Err(refused) }
    }

    /// Refuses an error bar that is too wide, and says when it is the unknown zeros that widen it.
    #[inline(never)]
    fn refuse_weak(&self, unit: &Symmetric<T>, noise_mm: T) -> Result<(), Refusal> {
        let limit = self.settings.sigma_limit_mm;
        let refused = judgement::refuse_weak(unit, noise_mm, limit);
        if refused.is_err()
            && let Some((worst, sigma)) = self.zeros.worst()
        {
            let known = self.sum.equations.matrix.first_inverse().map_err(|_| Refusal::Singular)?;
            if judgement::refuse_weak(&known, noise_mm, limit).is_ok() {
                let sigma_mm = (sigma * noise_mm).to_f32();
                return Err(Refusal::ZeroNotDetermined { cable: cable_number(worst), sigma_mm });
            }
        }
        refused
    }
}
