//! The noise of a cable length: as stated, or estimated from the residuals. Pure functions of one pass.

use super::pose::{Pose, PoseState};
use super::settings::{MIN_NOISE_MM, Noise};
use super::statistics::{ChiSquares, FALSE_ALARM, MEDIAN_OF_CHI_SQUARE_3, WIDENING, chi_square_test};
use super::weights::INLIER_LIMIT;
use crate::linear_algebra::non_negative_root;
use crate::scalar::Real;

/// Number of poses from which the median of χ² is good enough to estimate the noise from.
pub const POSES_TO_ESTIMATE: usize = 10;

/// χ² beyond which a pose that is left out is certainly an outlier.
const CLEARLY_OUT: f64 = 100.0;

/// The rig's stated noise counts as this many degrees of freedom where the noise is estimated.
const PRIOR_FREEDOM: f64 = 6.0;

/// Factor on the standard deviation when all residuals may come from one undetected bad reading (external reliability
/// after Baarda).
///
/// A reading with redundancy r that is off by b leaves a square of r b² and moves the centre by b times its share of
/// the variance. Of the 6 m readings of m poses the mean redundancy is freedom / 6 m, the mean share 1 / 6 m. The whole
/// residual, freedom σ², in one reading of mean redundancy and six times the mean share adds 6 σ²: the root of 1 + 6.
const WIDENING_FOR_ONE_BAD_READING: f64 = 2.65;

/// The residuals of a pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residuals<T> {
    /// Weighted sum of squares after the step, mm², priors included.
    pub squares_mm2: T,
    /// Its degrees of freedom, 1 at least.
    pub freedom: T,
    /// Poses that took part.
    pub used: usize,
    /// χ² of the poses, for a noise of `noise_mm`.
    pub chi_squares: ChiSquares<T>,
    /// Noise that χ² is computed with, 1σ, mm.
    pub noise_mm: T,
    /// Noise that the rig states, 1σ, mm.
    pub rig_noise_mm: T,
}

impl<T: Real> Residuals<T> {
    /// Before the first pass.
    pub fn none(noise_mm: T, rig_noise_mm: T) -> Self {
        let (zero, one) = (T::zero(), T::one());
        let chi_squares = ChiSquares::none();
        Self { squares_mm2: zero, freedom: one, used: 0, chi_squares, noise_mm, rig_noise_mm }
    }

    /// Are the residuals no larger than the noise explains? `poses`: number of poses given.
    pub fn are_noise(&self, noise: Noise<T>, poses: usize) -> bool {
        match noise {
            Noise::Known(noise) => chi_square_test(self.squares_mm2, self.freedom, noise * noise, T::of(FALSE_ALARM)),
            Noise::EstimatedUpTo(most) => {
                let estimate = non_negative_root(self.squares_mm2 / self.freedom);
                // A bad reading raises the RMS, and could hide in the noise estimated from it. So the median decides,
                // but not below the noise that the rig states. Few poses have no meaningful median.
                let typical = if poses >= POSES_TO_ESTIMATE {
                    smaller(self.typical_noise_mm(poses).max(self.rig_noise_mm), estimate)
                } else {
                    estimate
                };
                let unit = self.noise_mm / typical.max(T::of(MIN_NOISE_MM));
                estimate <= most && self.chi_squares.worst * unit * unit <= T::of(INLIER_LIMIT)
            }
        }
    }

    /// Does the converged inlier set pass the noise limit?
    pub fn of_inliers_are_noise(&self, noise: Noise<T>, poses: usize) -> bool {
        match noise {
            Noise::Known(_) => self.are_noise(noise, poses),
            Noise::EstimatedUpTo(most) => self.squares_mm2 <= self.freedom * most * most,
        }
    }

    /// The noise, 1σ, mm: a known one as it is, an unknown one from the median of χ².
    pub fn estimated_noise_mm(&self, noise: Noise<T>, poses: usize) -> T {
        match noise {
            Noise::Known(noise) => noise,
            Noise::EstimatedUpTo(most) => smaller(self.typical_noise_mm(poses), most).max(T::of(MIN_NOISE_MM)),
        }
    }

    /// The noise that the median of χ² corresponds to, 1σ, mm.
    fn typical_noise_mm(&self, poses: usize) -> T {
        let poses = T::of_integer(poses as i32);
        let typical = self.chi_squares.median / T::of(MEDIAN_OF_CHI_SQUARE_3) * poses / (poses - T::of(2.0));
        self.noise_mm * non_negative_root(typical)
    }

    /// The noise, and the one behind the reported standard deviation, which is larger where a bad reading may be
    /// hidden; 1σ, mm.
    pub fn noise_of_result_mm(&self, noise: Noise<T>, poses: &[Pose<T>]) -> (T, T) {
        match noise {
            // Residuals that only one sound set in twenty has widen the standard deviation (Birge ratio). Poses that
            // were left out narrowly are included: without the worst of few poses the others look too good.
            Noise::Known(noise) => {
                let variance = noise * noise;
                let is_narrowly_out =
                    |pose: &&Pose<T>| pose.state == PoseState::Placed && pose.chi_square <= T::of(CLEARLY_OUT);
                let add =
                    |(squares, freedom), pose: &Pose<T>| (squares + pose.chi_square * variance, freedom + T::of(3.0));
                let (squares, freedom) =
                    poses.iter().filter(is_narrowly_out).fold((self.squares_mm2, self.freedom), add);
                let fits = chi_square_test(squares, freedom, variance, T::of(WIDENING));
                let noise = if fits { noise } else { non_negative_root(squares / freedom) };
                (noise, noise)
            }
            // A variance estimated from few residuals is too small too often: the rig's own noise is worth a few more.
            // Residuals beyond the rig's noise may also come from one bad reading, which few poses cannot detect.
            Noise::EstimatedUpTo(_) => {
                let prior = T::of(PRIOR_FREEDOM);
                let rig = self.rig_noise_mm * self.rig_noise_mm;
                let pooled = non_negative_root((self.squares_mm2 + prior * rig) / (self.freedom + prior));
                let few = self.used < POSES_TO_ESTIMATE;
                if few && !chi_square_test(self.squares_mm2, self.freedom, rig, T::of(FALSE_ALARM)) {
                    return (pooled, pooled * T::of(WIDENING_FOR_ONE_BAD_READING));
                }
                (pooled, pooled)
            }
        }
    }
}

/// The smaller of two numbers; the second where one is none.
fn smaller<T: Real>(a: T, b: T) -> T {
    if a < b { a } else { b }
}
