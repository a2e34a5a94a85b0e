//! What the solver is told beside the poses: the noise, and the limits of acceptance.

use super::judgement::LEAST_NOISE_MM;
use crate::rig::Rig;
use crate::scalar::Real;

/// What is known of the noise of a cable length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Noise<T> {
    /// Its standard deviation is known, mm. Residuals beyond it are then evidence: of a bad reading, or of a centre
    /// that wanders.
    Known(T),
    /// It is estimated from the residuals; at most this much, mm, is taken for noise.
    EstimatedUpTo(T),
}

/// Limits of acceptance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolverSettings<T> {
    /// Noise of a cable length.
    pub noise: Noise<T>,
    /// How well the encoder zeros are known, 1σ, mm; 0 = exactly. See [`zeros`](crate::identification::zeros).
    pub zero_prior_mm: T,
    /// Gauss-Newton ends when no unknown moves by more than this, mm.
    pub tolerance_mm: T,
    /// Largest 1σ of the centre in its worst direction, mm.
    pub sigma_limit_mm: T,
    /// Smallest sway about the most common axis, rad (see [`Sway`](crate::identification::observability::Sway)).
    pub sway_limit_rad: T,
    /// Refuse a set that hangs on one pose, though noise-free lengths would give the centre: nothing could contradict
    /// that pose if it were wrong. Every set of three poses is one.
    pub refuse_hanging: bool,
    /// Smallest sway about the second most common axis, rad: poses that stay below it are all alike.
    pub spread_limit_rad: T,
}

impl<T: Real> SolverSettings<T> {
    /// The limits for `rig`, whose cable noise is taken as known.
    pub fn for_rig(rig: &Rig<T>) -> Self {
        Self {
            noise: Noise::Known(rig.length_noise_mm()),
            zero_prior_mm: T::zero(),
            refuse_hanging: true,
            // Single precision: 3e-3 mm, double: 1e-7 mm. The error after a step is about its square over the rig's size.
            tolerance_mm: half_the_digits::<T>() * T::of(8.0),
            // A tenth of what the humeral head itself moves in elevation (2-6 mm).
            sigma_limit_mm: T::one(),
            // 1 degree: 0.1 mm of noise alone makes rotations about one axis sway by 0.1 degrees.
            sway_limit_rad: T::of(0.017_5),
            // 2.5 degrees: nobody can hold such poses apart, let alone a control loop.
            spread_limit_rad: T::of(0.043_6),
        }
    }

    /// The same with every number that cannot be a limit (negative, NaN, a noise finer than any encoder) put right:
    /// a noise to its least value, a limit to the strictest.
    pub(super) fn sound(mut self) -> Self {
        let at_least = |value: T, least: T| if value >= least { value } else { least };
        let least_noise = T::of(LEAST_NOISE_MM);
        self.noise = match self.noise {
            Noise::Known(noise) => Noise::Known(at_least(noise, least_noise)),
            Noise::EstimatedUpTo(most) => Noise::EstimatedUpTo(at_least(most, least_noise)),
        };
        self.zero_prior_mm = at_least(self.zero_prior_mm, T::zero());
        self.tolerance_mm = at_least(self.tolerance_mm, half_the_digits());
        self.sigma_limit_mm = at_least(self.sigma_limit_mm, T::zero());
        self
    }
}

/// The root of the precision, 2^-11.5 or 2^-26. As a number: the compiler knows it then.
fn half_the_digits<T: Real>() -> T {
    let is_single = T::default_epsilon() > T::of(1e-12);
    T::of(if is_single { 3.452_669_830_012_439e-4 } else { 1.490_116_119_384_765_6e-8 })
}
