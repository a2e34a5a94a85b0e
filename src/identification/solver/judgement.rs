//! The limits of acceptance, and the statistics behind them.

use super::FEWEST_POSES;
use super::placement::Placement;
use crate::calls::root as square_root;
use crate::scalar::Real;
use nalgebra::Vector3;

/// Misfit beyond which a pose is left out: chi-square with three degrees of freedom exceeds 25 once in 65 000 sound
/// poses.
pub(super) const MISFIT_LIMIT: f64 = 25.0;

/// Misfit beyond which a pose that is left out was certainly no sound one.
pub(super) const CLEARLY_OUT: f64 = 100.0;

/// A misfit this many times the typical one is no noise of any size.
pub(super) const STANDS_OUT: f64 = 40.0;

/// How much wider the error bar is when all residuals may be due to one bad reading that is not seen as such.
///
/// A reading with redundancy r that is off by b leaves a square of r b² and moves the centre by b times its share of the
/// variance. Of the 6 m readings of m poses the mean redundancy is freedom / 6 m, the mean share 1 / 6 m. The whole
/// residual, freedom σ², in one reading of mean redundancy and six times the mean share adds 6 σ²: the root of 1 + 6.
pub(super) const WIDENING_FOR_ONE_BAD_READING: f64 = 2.65;

/// Sets of up to this many poses are checked pose by pose: would the result stand without it? Of a larger set only the
/// pose that makes most of the sway is.
pub(super) const FEW_POSES: usize = 12;

/// A pose that makes this part of the sway makes most of it.
pub(super) const MOST_OF_THE_SWAY: f64 = 0.5;

/// How much worse the centre may be determined without any one pose. A pose that improves the error bar more than
/// this can be wrong by its full outlier without the others showing it. Refuses 0.6 % of four random poses (tilt 45,
/// torsion 30 degrees), 0.07 % of five, 0.02 % of six, next to none of more (`cargo study million`). Two poses never
/// suffice, though rounding may hide that in the equations that are left of three: those never stand.
pub(super) fn limit_without_one_pose<T: Real>(poses: usize) -> T {
    if poses <= FEWEST_POSES {
        return T::zero();
    }
    let spare = T::of_integer((poses - FEWEST_POSES) as i32);
    T::of(3.0) + T::of(27.0) / (spare * spare)
}

/// Poses from which the median of the misfits is good enough to take the noise from again, pass by pass.
pub(super) const POSES_TO_ESTIMATE: usize = 10;

/// The rig's stated noise counts as this many degrees of freedom where the noise is estimated.
pub(super) const PRIOR_FREEDOM: f64 = 6.0;

/// Misfit beyond which a pose's rotation itself is in doubt.
pub(super) const HOPELESS_MISFIT: f64 = 100.0;

/// Last scale of the annealed weights: a pose at the limit of being left out weighs a seventh.
pub(super) const ANNEALED_SCALE: f64 = 16.0;

/// The scale is lowered by this factor a pass.
pub(super) const ANNEALING: f64 = 0.25;

/// Passes with equal weights before the residuals are taken to hold something else than noise.
pub(super) const EQUAL_PASSES: u8 = 4;

/// The same when the zeros are unknown: from ±10 mm they settle in six to eight passes.
pub(super) const EQUAL_PASSES_WITH_ZEROS: u8 = 10;

/// Passes with poses in or out; a selection that has not settled by then is judged as it stands.
pub(super) const SELECTED_PASSES: u8 = 8;

/// Passes that measure how far the centre wanders.
pub(super) const WANDER_PASSES: u8 = 2;

/// Median of chi-square with three degrees of freedom.
pub(super) const MEDIAN_OF_CHI_SQUARE_3: f64 = 2.366;

/// No encoder is finer: below this an estimated noise is rounding, mm.
pub(super) const LEAST_NOISE_MM: f64 = 1e-3;

/// Mean over median of the squared distances of the poses' own centres, up to which the centre itself wanders.
pub(super) const SCATTER_RATIO: f64 = 4.0;

/// Quantile of the normal distribution behind the refusal: one false alarm in 10 000 sound sets.
pub(super) const FALSE_ALARM: f64 = 3.72;

/// Quantile behind the widening of the error bar: one sound set in twenty.
pub(super) const WIDENING: f64 = 1.645;

/// Are squares with `freedom` degrees of freedom no larger than a noise of this variance explains, at a quantile of the
/// normal distribution? By the chi-square value of Wilson and Hilferty 1931: at the false-alarm quantile within 4 % at
/// three degrees of freedom, 2 % from six on.
#[inline(never)]
pub(super) fn is_noise<T: Real>(squares: T, freedom: T, variance: T, quantile: T) -> bool {
    let ninth = T::of(2.0) / (freedom * T::of(9.0));
    let root = T::one() - ninth + quantile * square_root(ninth);
    squares <= variance * (freedom * root * root * root)
}

/// Misfits of the placed poses; 0 without any.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Misfits<T> {
    /// The typical one, within 1 %.
    pub median: T,
    /// The largest.
    pub worst: T,
}

impl<T: Real> Misfits<T> {
    /// Of poses that all fit.
    pub fn none() -> Self {
        Self { median: T::zero(), worst: T::zero() }
    }

    /// Of these poses; their median by bisection on the value: no copy, no reordering.
    #[inline(never)]
    pub fn of(placements: &[Placement<T>]) -> Self {
        let (mut worst, mut placed) = (T::zero(), 0_usize);
        for placement in placements {
            if placement.is_placed() {
                placed += 1;
                if placement.misfit > worst {
                    worst = placement.misfit;
                }
            }
        }
        let half = placed.div_ceil(2);
        let (mut low, mut median) = (T::zero(), worst);
        for _ in 0..40 {
            if low * T::of(1.01) > median {
                break;
            }
            // Between the geometric and the arithmetic middle: misfits span many powers of ten.
            let middle = if low > T::zero() { square_root(low * median) } else { median * T::of(1.0 / 64.0) };
            if fitting(placements, middle) >= half {
                median = middle;
            } else {
                low = middle;
            }
        }
        Self { median, worst }
    }
}

/// Poses with a misfit of `limit`, which is finite, at most: all of them are placed.
#[inline(never)]
pub(super) fn fitting<T: Real>(placements: &[Placement<T>], limit: T) -> usize {
    placements.iter().filter(|p| p.misfit <= limit).count()
}

pub(super) fn to_f32<T: Real>(vector: &Vector3<T>) -> [f32; 3] {
    [vector.x.to_f32(), vector.y.to_f32(), vector.z.to_f32()]
}
