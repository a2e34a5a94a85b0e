//! What stands between a fit and a result: residuals, outliers, and which cable was wrong.

use super::fit::Fit;
use super::joint::{HINGE_UNKNOWNS, Hinge};
use super::pose::{HingePose, PoseAt};
use super::refusal::HingeRefusal;
use super::second_axis::{SECOND_UNKNOWNS, SecondAxis};
use super::settings::HingeSettings;
use crate::identification::settings::Noise;
use crate::identification::statistics::{FALSE_ALARM, WIDENING, chi_square_quantile, chi_square_test};
use crate::identification::weights::INLIER_LIMIT;
use crate::linear_algebra::non_negative_root;
use crate::scalar::Real;

/// Minimum number of poses: four redundant lengths more than a hinge has unknowns, at four cables.
pub const MIN_POSES: usize = 6;
/// The rig's stated noise counts as this many degrees of freedom where the noise is estimated.
const PRIOR_FREEDOM: f64 = 6.0;
/// χ² of one pose with a redundancy of two, beyond which leaving out a cable does not explain it: once in 10 000.
const EXPLAINED: f64 = 18.4;

/// Degrees of freedom of the residuals of the poses that take part, 1 at least: with priors every unknown brings an
/// equation of its own.
pub(super) fn freedom<T: Real>(fit: &Fit<T>, poses: &[HingePose<T>]) -> T {
    let used = poses.iter().filter(|pose| pose.is_used()).count();
    let equations = used * (fit.machine.cables() - 1);
    let unknowns = if fit.prior().is_some() { 0 } else { HINGE_UNKNOWNS };
    T::of_integer(equations.saturating_sub(unknowns).max(1) as i32)
}

/// Are the residuals no larger than the noise explains?
pub(super) fn are_noise<T: Real>(fit: &Fit<T>, poses: &[HingePose<T>], noise: Noise<T>) -> bool {
    let freedom = freedom(fit, poses);
    match noise {
        Noise::Known(noise) => chi_square_test(fit.squares_mm2, freedom, noise * noise, T::of(FALSE_ALARM)),
        Noise::EstimatedUpTo(most) => fit.squares_mm2 <= freedom * most * most,
    }
}

/// The noise behind the covariance, 1σ, mm: a known one, wider where only one sound set in twenty leaves so much (Birge
/// ratio); or the residuals', with the rig's as a few more degrees of freedom.
pub(super) fn noise_of_result_mm<T: Real>(fit: &Fit<T>, poses: &[HingePose<T>], noise: Noise<T>, rig_mm: T) -> T {
    let freedom = freedom(fit, poses);
    match noise {
        Noise::Known(noise) if chi_square_test(fit.squares_mm2, freedom, noise * noise, T::of(WIDENING)) => noise,
        Noise::Known(_) => non_negative_root(fit.squares_mm2 / freedom),
        Noise::EstimatedUpTo(_) => {
            let prior = T::of(PRIOR_FREEDOM);
            non_negative_root((fit.squares_mm2 + prior * rig_mm * rig_mm) / (freedom + prior))
        }
    }
}

/// χ² of a single pose beyond which it contradicts the others, with one redundant length less than there are cables: as
/// rare as the limit of the shoulder's poses.
pub(super) fn inlier_limit<T: Real>(cables: usize) -> T {
    T::of(INLIER_LIMIT) * chi_square_quantile(T::of_integer(cables as i32 - 1), T::of(4.2))
        / chi_square_quantile(T::of(3.0), T::of(4.2))
}

/// Refuses to leave out so many.
///
/// # Errors
/// [`HingeRefusal::TooManyOutliers`] when more than a fifth are out, or too few are left.
pub(super) fn require_most<T: Real>(poses: &[HingePose<T>]) -> Result<(), HingeRefusal> {
    let rejected = poses.iter().filter(|pose| !pose.is_used()).count();
    if 5 * rejected > poses.len() || poses.len() - rejected < MIN_POSES {
        return Err(HingeRefusal::TooManyOutliers { rejected: rejected as u32, poses: poses.len() as u32 });
    }
    Ok(())
}

/// The squares, mm², with a pose that is left out counted at the limit.
pub(super) fn cut_off_squares<T: Real>(fit: &Fit<T>, poses: &[HingePose<T>]) -> T {
    let out = T::of_integer(poses.iter().filter(|pose| !pose.is_used()).count() as i32);
    fit.squares_mm2 + out * inlier_limit::<T>(fit.machine.cables()) * fit.noise_mm * fit.noise_mm
}

/// Two different hinges fit.
pub(super) fn two_axes<T: Real>(fit: &Fit<T>, one: &Hinge<T>, other: &Hinge<T>) -> HingeRefusal {
    let (angle, distance) = apart(fit, one, other);
    HingeRefusal::TwoAxesFit { angle_rad: angle.to_f32(), distance_mm: distance.to_f32() }
}

/// Rounds for the angle of a pose without a cable.
const ISOLATING_ROUNDS: usize = 8;

/// Fault isolation under way: for every pose that is left out, the cables without any one of which it fits.
#[derive(Clone, Copy, Debug)]
pub(super) struct Isolation {
    pose: usize,
    /// From 0.
    cable: usize,
    round: usize,
}

impl Isolation {
    /// Before the first pose.
    pub const fn new() -> Self {
        Self { pose: 0, cable: 0, round: 0 }
    }

    /// One slice: a round for the angle of a pose without a cable; true at the end.
    pub fn advance<T: Real>(&mut self, fit: &Fit<T>, poses: &mut [HingePose<T>]) -> bool {
        let Some(pose) = poses.get_mut(self.pose) else { return true };
        let cables = fit.machine.cables();
        // Two cables always fit an angle.
        if pose.is_used() || self.cable >= cables || cables <= 3 {
            if !pose.is_used() && cables <= 3 {
                pose.suspect_cables = 0;
            }
            (self.pose, self.cable, self.round) = (self.pose + 1, 0, 0);
            return false;
        }
        if self.round == 0 {
            pose.trial_rad = pose.angle_rad;
            pose.suspect_cables = if self.cable == 0 { 0 } else { pose.suspect_cables };
        }
        let at = PoseAt { cables: !(1 << self.cable), ..PoseAt::new(&fit.hinge, &fit.machine) };
        pose.trial_rad = at.turned(&pose.lengths_mm, pose.trial_rad, 1);
        self.round += 1;
        if self.round == ISOLATING_ROUNDS {
            let limit = T::of(EXPLAINED) * fit.noise_mm * fit.noise_mm;
            if at.squares(&pose.lengths_mm, pose.trial_rad) <= limit {
                pose.suspect_cables |= 1 << self.cable;
            }
            (self.cable, self.round) = (self.cable + 1, 0);
        }
        false
    }
}

/// Why poses refuse a hinge: a second axis that explains them, or the hinge at all. `second`: the best one.
pub(super) fn no_hinge<T: Real>(
    fit: &Fit<T>,
    poses: &[HingePose<T>],
    noise: Noise<T>,
    second: Option<&SecondAxis<T>>,
) -> HingeRefusal {
    let most_mm = match noise {
        Noise::Known(noise) => noise,
        Noise::EstimatedUpTo(most) => most,
    };
    // One more angle a pose, less its zero, which is nobody's; and the second axis.
    let left = freedom(fit, poses) - T::of_integer(poses.len() as i32 - 1 + SECOND_UNKNOWNS as i32);
    match second {
        Some(second)
            if left >= T::one() && chi_square_test(second.squares_mm2, left, most_mm * most_mm, T::of(FALSE_ALARM)) =>
        {
            let axis = second.axis_in_platform;
            HingeRefusal::SecondAxis {
                axis_in_platform: [axis.x.to_f32(), axis.y.to_f32(), axis.z.to_f32()],
                size_rad: second.size_rad.to_f32(),
            }
        }
        _ => not_a_hinge(fit, poses),
    }
}

/// The hinge does not explain the poses.
pub(super) fn not_a_hinge<T: Real>(fit: &Fit<T>, poses: &[HingePose<T>]) -> HingeRefusal {
    HingeRefusal::NotAHinge { residual_mm: non_negative_root(fit.squares_mm2 / freedom(fit, poses)).to_f32() }
}

/// From the smallest to the largest angle of the poses used, rad, a pose a slice. Angles stand on a circle: the largest gap
/// between two neighbours is what the joint does not reach.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flexion<T> {
    next: usize,
    largest_gap: T,
}

impl<T: Real> Flexion<T> {
    /// Before the first pose.
    pub fn new() -> Self {
        Self { next: 0, largest_gap: T::zero() }
    }

    /// One slice; the range at the end.
    pub fn advance(&mut self, poses: &[HingePose<T>]) -> Option<T> {
        let turn = T::two_pi();
        let Some(pose) = poses.get(self.next) else { return Some(turn - self.largest_gap) };
        self.next += 1;
        if pose.is_used() {
            let within = |angle: T| angle - turn * (angle / turn).floor();
            let others = poses.iter().filter(|other| other.is_used());
            let ahead = others.map(|other| within(other.angle_rad - pose.angle_rad)).filter(|gap| *gap > T::of(1e-6));
            let gap = ahead.fold(turn, |least, gap| if gap < least { gap } else { least });
            self.largest_gap = self.largest_gap.max(gap);
        }
        None
    }
}

/// Refuses a joint that hardly bends.
///
/// # Errors
/// [`HingeRefusal::TooLittleFlexion`].
pub(super) fn require_flexion<T: Real>(range_rad: T, settings: &HingeSettings<T>) -> Result<(), HingeRefusal> {
    if range_rad < settings.flexion_limit_rad {
        return Err(HingeRefusal::TooLittleFlexion { range_rad: range_rad.to_f32() });
    }
    Ok(())
}

/// Angle between two hinges' axes in the base, rad, and the distance between their places next to the middle of the
/// base's points, mm.
pub(super) fn apart<T: Real>(fit: &Fit<T>, one: &Hinge<T>, other: &Hinge<T>) -> (T, T) {
    let points = fit.machine.base_mm();
    let count = T::of_integer(points.len().max(1) as i32);
    let middle = points.iter().fold(nalgebra::Vector3::zeros(), |sum, point| sum + point) / count;
    let sine = one.axis().cross(other.axis()).norm_squared().root();
    let angle = sine.atan2(one.axis().dot(other.axis()).abs());
    let distance = (one.nearest_mm(&middle) - other.nearest_mm(&middle)).norm_squared().root();
    (angle, distance)
}

/// Do most poses fit the hinge nearly as well as noise allows?
pub(super) fn is_mostly_sound<T: Real>(fit: &Fit<T>, poses: &[HingePose<T>]) -> bool {
    let mean = fit.squares_mm2 / (fit.noise_mm * fit.noise_mm) / T::of_integer(poses.len().max(1) as i32);
    let below = poses.iter().filter(|pose| pose.chi_square * T::of(4.0) < mean).count();
    2 * below > poses.len()
}
