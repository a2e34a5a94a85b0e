//! What stands between a fit and a result: residuals, outliers, and which cable was wrong.

use super::fit::Fit;
use super::joint::{HINGE_UNKNOWNS, Hinge};
use super::pose::{HingePose, PoseAt};
use super::refusal::HingeRefusal;
use super::second_axis;
use crate::identification::settings::Noise;
use crate::identification::statistics::{FALSE_ALARM, WIDENING, chi_square_quantile, chi_square_test};
use crate::identification::weights::{FINAL_SCALE, INLIER_LIMIT};
use crate::linear_algebra::non_negative_root;
use crate::scalar::Real;

/// The rig's stated noise counts as this many degrees of freedom where the noise is estimated.
const PRIOR_FREEDOM: f64 = 6.0;
/// Steps of the fit in a pass of weights, and once the weights stand.
const PASS_TRIALS: usize = 12;
const LAST_TRIALS: usize = 20;
/// Passes of weights at most.
const MAX_PASSES: usize = 30;
/// The scale of the weights is lowered by this factor a pass: a hinge has weak directions, and follows slowly.
const SCALE_STEP: f64 = 0.5;
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
fn inlier_limit<T: Real>(cables: usize) -> T {
    T::of(INLIER_LIMIT) * chi_square_quantile(T::of_integer(cables as i32 - 1), T::of(4.2))
        / chi_square_quantile(T::of(3.0), T::of(4.2))
}

/// Weights down the poses that contradict the others until they stand out, and leaves them out.
///
/// # Errors
/// [`HingeRefusal::TooManyOutliers`] when more than a fifth would have to be.
pub(super) fn leave_out<T: Real>(
    fit: &mut Fit<T>,
    poses: &mut [HingePose<T>],
    min_poses: usize,
) -> Result<(), HingeRefusal> {
    let mut scale = poses.iter().fold(T::of(FINAL_SCALE), |worst, pose| worst.max(pose.chi_square));
    for _ in 0..MAX_PASSES {
        for pose in poses.iter_mut() {
            let root = scale / (scale + pose.chi_square);
            pose.weight = root * root;
        }
        fit.minimise(poses, PASS_TRIALS, false);
        fit.settle(poses);
        if scale <= T::of(FINAL_SCALE) {
            break;
        }
        scale = (scale * T::of(SCALE_STEP)).max(T::of(FINAL_SCALE));
    }
    let limit = inlier_limit::<T>(fit.machine.cables());
    for _ in 0..3 {
        for pose in poses.iter_mut() {
            pose.weight = if pose.chi_square <= limit { T::one() } else { T::zero() };
        }
        let rejected = poses.iter().filter(|pose| !pose.is_used()).count();
        if 5 * rejected > poses.len() || poses.len() - rejected < min_poses {
            return Err(HingeRefusal::TooManyOutliers { rejected: rejected as u32, poses: poses.len() as u32 });
        }
        fit.minimise(poses, LAST_TRIALS, false);
        fit.settle(poses);
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

/// For every pose that is left out, the cables without any one of which it fits.
pub(super) fn isolate<T: Real>(fit: &Fit<T>, poses: &mut [HingePose<T>]) {
    let cables = fit.machine.cables();
    let limit = T::of(EXPLAINED) * fit.noise_mm * fit.noise_mm;
    for pose in poses.iter_mut().filter(|pose| !pose.is_used()) {
        pose.suspect_cables = 0;
        // Two cables always fit an angle.
        for cable in 0..if cables > 3 { cables } else { 0 } {
            let at = PoseAt { cables: !(1 << cable), ..PoseAt::new(&fit.hinge, &fit.machine) };
            if at.best_angle(&pose.lengths_mm, pose.angle_rad, 8).1 <= limit {
                pose.suspect_cables |= 1 << cable;
            }
        }
    }
}

/// Why poses refuse a hinge: a second axis that explains them, or the hinge at all.
pub(super) fn no_hinge<T: Real>(fit: &Fit<T>, poses: &mut [HingePose<T>], noise: Noise<T>) -> HingeRefusal {
    let most_mm = match noise {
        Noise::Known(noise) => noise,
        Noise::EstimatedUpTo(most) => most,
    };
    // One more angle a pose, less its zero, which is nobody's; and the second axis.
    let left = freedom(fit, poses) - T::of_integer(poses.len() as i32 - 1 + second_axis::SECOND_UNKNOWNS as i32);
    match second_axis::find(fit, poses) {
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

/// From the smallest to the largest angle of the poses used, rad. Angles stand on a circle: the largest gap between two
/// neighbours is what the joint does not reach.
pub(super) fn flexion_rad<T: Real>(poses: &[HingePose<T>]) -> T {
    let turn = T::two_pi();
    let within = |angle: T| angle - turn * (angle / turn).floor();
    let mut largest_gap = T::zero();
    for pose in poses.iter().filter(|pose| pose.is_used()) {
        let others = poses.iter().filter(|other| other.is_used());
        let ahead = others.map(|other| within(other.angle_rad - pose.angle_rad)).filter(|gap| *gap > T::of(1e-6));
        let gap = ahead.fold(turn, |least, gap| if gap < least { gap } else { least });
        largest_gap = largest_gap.max(gap);
    }
    turn - largest_gap
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
