//! Settings of the estimator: the noise, the model of the joint, and the limits of acceptance.

use crate::rig::Rig;
use crate::scalar::Real;

/// Smallest noise, 1σ, mm: no encoder is finer, and below this an estimated noise is rounding.
pub const MIN_NOISE_MM: f64 = 1e-3;

/// What is known of the noise of a cable length, 1σ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Noise<T> {
    /// It is known, mm. Larger residuals are then evidence of a bad reading or of a centre that is not fixed.
    Known(T),
    /// It is estimated from the residuals, up to this much, mm; larger residuals are not taken for noise.
    EstimatedUpTo(T),
}

/// Which model of the joint is tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointChoice {
    /// The ball while it explains the residuals, else the moving centre.
    Auto,
    /// A ball only.
    Ball,
    /// A moving centre only.
    Moving,
    /// A ball whose centre scatters: for the held phase.
    Held,
}

/// Limits of acceptance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EstimatorSettings<T> {
    /// Noise of a cable length.
    pub noise: Noise<T>,
    /// Which model of the joint is tried.
    pub joint: JointChoice,
    /// Gauss-Newton ends when no unknown moves by more than this, mm.
    pub tolerance_mm: T,
    /// Largest 1σ of the centre in its worst direction, mm.
    pub sigma_limit_mm: T,
    /// Smallest excitation about the most common axis, rad (see [`Excitation`](super::excitation::Excitation)).
    pub excitation_limit_rad: T,
    /// Refuse a set whose centre depends on one pose alone, which no other could contradict if it were wrong. Every set
    /// of three poses is one.
    pub require_redundancy: bool,
    /// Smallest excitation about the second most common axis, rad: poses that stay below it are all alike.
    pub spread_limit_rad: T,
}

impl<T: Real> EstimatorSettings<T> {
    /// The limits for `rig`, whose cable noise is taken as known.
    pub fn for_rig(rig: &Rig<T>) -> Self {
        Self {
            noise: Noise::Known(rig.length_noise_mm()),
            joint: JointChoice::Auto,
            require_redundancy: true,
            // Single precision: 3e-3 mm, double: 1e-7 mm. The error after a step is about its square over the rig's
            // size.
            tolerance_mm: half_the_digits::<T>() * T::of(8.0),
            // A tenth of what the humeral head itself moves in elevation (2-6 mm).
            sigma_limit_mm: T::one(),
            // 1 degree: 0.1 mm of noise alone makes rotations about one axis differ by 0.1 degrees.
            excitation_limit_rad: T::of(0.017_5),
            // 2.5 degrees: poses this near to each other determine nothing useful.
            spread_limit_rad: T::of(0.043_6),
        }
    }

    /// The same with every invalid number (negative, NaN, a noise below [`MIN_NOISE_MM`]) replaced: a noise by its
    /// minimum, a limit by the strictest.
    pub(super) fn sound(mut self) -> Self {
        let at_least = |value: T, least: T| if value >= least { value } else { least };
        let least_noise = T::of(MIN_NOISE_MM);
        self.noise = match self.noise {
            Noise::Known(noise) => Noise::Known(at_least(noise, least_noise)),
            Noise::EstimatedUpTo(most) => Noise::EstimatedUpTo(at_least(most, least_noise)),
        };
        self.tolerance_mm = at_least(self.tolerance_mm, half_the_digits());
        self.sigma_limit_mm = at_least(self.sigma_limit_mm, T::zero());
        self
    }
}

/// The root of the precision, 2^-11.5 or 2^-26.
fn half_the_digits<T: Real>() -> T {
    T::default_epsilon().root()
}
