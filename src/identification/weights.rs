//! How poses are weighted in a pass.

use crate::scalar::Real;

/// χ² beyond which a pose is left out: with three degrees of freedom, once in 65 000 sound poses.
pub const INLIER_LIMIT: f64 = 25.0;

/// Final scale of the Geman-McClure weights, in units of χ²: a pose at the inlier limit weighs a seventh.
pub const FINAL_SCALE: f64 = 16.0;

/// The scale is lowered by this factor a pass (graduated non-convexity; Yang, Antonante, Tzoumas and Carlone 2020).
pub const SCALE_STEP: f64 = 0.25;

/// The weights of a pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Weights<T> {
    /// Equal weights.
    Equal,
    /// Geman-McClure with this scale, in units of χ²: (scale / (scale + χ²))².
    GemanMcClure(T),
    /// 1 up to this χ², else 0.
    Inliers(T),
    /// The poses of the last pass without one of them (leave-one-out).
    Without {
        /// The pose left out, from 0.
        pose: usize,
    },
    /// Equal weight for each pose's own centre: measures their scatter, once the set is refused as a ball.
    OwnCentres {
        /// Poses beyond the inlier limit.
        rejected: usize,
    },
}

impl<T: Real> Weights<T> {
    /// Weight of pose `index` with this χ².
    pub fn weight(&self, index: usize, chi_square: T, was_used: bool) -> T {
        let in_or_out = |is_in: bool| if is_in { T::one() } else { T::zero() };
        match self {
            Self::Equal | Self::OwnCentres { .. } => T::one(),
            Self::GemanMcClure(scale) => {
                let root = *scale / (*scale + chi_square);
                root * root
            }
            Self::Inliers(limit) => in_or_out(chi_square <= *limit),
            Self::Without { pose } => in_or_out(was_used && *pose != index),
        }
    }
}
