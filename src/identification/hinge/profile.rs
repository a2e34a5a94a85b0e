//! Is the covariance true? A hinge is not linear in its unknowns: where the valley of χ² bends, another hinge beyond five
//! standard deviations fits nearly as well.
//!
//! The profile of χ² answers it (Bates and Watts 1988, section 6.1): each unknown in turn is held 5 σ to either side of its
//! estimate, and all others are fitted anew. A linear problem leaves 25 more there.

use super::fit::Fit;
use super::judge;
use super::pose::HingePose;
use super::refusal::HingeRefusal;
use super::result::IdentifiedHinge;
use crate::scalar::Real;

/// Where the profile is looked at, standard deviations.
const AT: f64 = 5.0;
/// Smallest rise of χ², over that of a linear problem.
const MIN_RISE: f64 = 0.5;
/// Steps of the fit at each place.
const TRIALS: usize = 12;

/// Refuses a hinge beside which another one, about 5 σ away, fits nearly as well. `fit`: finished at `found`. The poses are
/// left at other angles.
///
/// # Errors
/// [`HingeRefusal::TwoAxesFit`].
pub(super) fn require_true_sigmas<T: Real>(
    fit: &Fit<T>,
    found: &IdentifiedHinge<T>,
    poses: &mut [HingePose<T>],
) -> Result<(), HingeRefusal> {
    for (unknown, sigma) in found.sigmas().iter().enumerate() {
        let column = fit.equations.covariance_column(unknown, 0);
        // How all unknowns follow this one on average.
        let follow = column.map(|entry| entry * found.noise_mm * found.noise_mm / *sigma);
        for side in [T::of(AT), -T::of(AT)] {
            let mut other = fit.clone();
            other.held = Some(unknown);
            other.take(&follow.map(|entry| entry * side));
            other.minimise(poses, TRIALS, false);
            let difference = found.hinge.difference(&other.hinge);
            let deviations = difference.get(unknown).copied().unwrap_or_else(T::zero) / *sigma;
            let rise = (other.squares_mm2 - fit.squares_mm2) / (found.noise_mm * found.noise_mm);
            // Also refuses NaN.
            if !(rise >= T::of(MIN_RISE) * deviations * deviations) {
                return Err(judge::two_axes(fit, &fit.hinge, &other.hinge));
            }
        }
    }
    Ok(())
}
