//! χ² tests and the median of the poses' χ².

use super::pose::Pose;
use crate::linear_algebra::non_negative_root;
use crate::scalar::Real;

/// Median of χ² with three degrees of freedom.
pub const MEDIAN_OF_CHI_SQUARE_3: f64 = 2.366;

/// Quantile of the normal distribution behind a refusal: one false alarm in 10 000 sound sets.
pub const FALSE_ALARM: f64 = 3.72;

/// Quantile behind the widening of the standard deviation: one sound set in twenty.
pub const WIDENING: f64 = 1.645;

/// Are squares with `freedom` degrees of freedom no larger than a noise of this variance explains, at a quantile of the
/// normal distribution?
pub fn chi_square_test<T: Real>(squares: T, freedom: T, variance: T, quantile: T) -> bool {
    squares <= variance * chi_square_quantile(freedom, quantile)
}

/// The value that χ² with `freedom` degrees of freedom exceeds as rarely as a normal variable exceeds `quantile`, after
/// Wilson and Hilferty 1931: at the false-alarm quantile within 4 % at three degrees of freedom, 2 % from six on.
pub fn chi_square_quantile<T: Real>(freedom: T, quantile: T) -> T {
    let ninth = T::of(2.0) / (freedom * T::of(9.0));
    let root = T::one() - ninth + quantile * non_negative_root(ninth);
    freedom * root * root * root
}

/// χ² of the placed poses; 0 without any.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChiSquares<T> {
    /// The median, at most 1 % too large.
    pub median: T,
    /// The largest.
    pub worst: T,
}

impl<T: Real> ChiSquares<T> {
    /// Both 0.
    pub fn none() -> Self {
        Self { median: T::zero(), worst: T::zero() }
    }
}

/// The median by bisection on its value: no copy, no sorting. A few rounds a call.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MedianSearch<T> {
    half: usize,
    low: T,
    found: ChiSquares<T>,
    rounds: u8,
}

impl<T: Real> MedianSearch<T> {
    /// Rounds after which the interval is taken as it is.
    const MAX_ROUNDS: u8 = 40;
    /// Rounds of a call: 128 poses cost 4 000 cycles of a Cortex-M4F.
    const ROUNDS_A_CALL: u8 = 4;

    /// Begins.
    pub fn new(poses: &[Pose<T>]) -> Self {
        let (mut worst, mut placed) = (T::zero(), 0_usize);
        for pose in poses.iter().filter(|pose| pose.is_placed()) {
            placed += 1;
            if pose.chi_square > worst {
                worst = pose.chi_square;
            }
        }
        Self { half: placed.div_ceil(2), low: T::zero(), found: ChiSquares { median: worst, worst }, rounds: 0 }
    }

    /// Halves the interval a few times; the result, once it is narrow enough.
    pub fn advance(&mut self, poses: &[Pose<T>]) -> Option<ChiSquares<T>> {
        for _ in 0..Self::ROUNDS_A_CALL {
            if self.low * T::of(1.01) > self.found.median || self.rounds >= Self::MAX_ROUNDS {
                return Some(self.found);
            }
            self.rounds += 1;
            // Between the geometric and the arithmetic middle: χ² spans many powers of ten.
            let middle = if self.low > T::zero() {
                non_negative_root(self.low * self.found.median)
            } else {
                self.found.median * T::of(1.0 / 64.0)
            };
            if count_within(poses, middle) >= self.half {
                self.found.median = middle;
            } else {
                self.low = middle;
            }
        }
        None
    }
}

/// Number of poses with a χ² of at most `limit`, which is finite, so that only placed poses count.
pub fn count_within<T: Real>(poses: &[Pose<T>], limit: T) -> usize {
    poses.iter().filter(|pose| pose.chi_square <= limit).count()
}
