//! Is the covariance true? A hinge is not linear in its unknowns: where its valley of χ² bends, another hinge beyond five
//! standard deviations fits nearly as well.
//!
//! The profile of χ² answers it (Bates and Watts 1988, section 6.1): each unknown in turn is held 5 σ to either side of its
//! estimate, and all others are fitted anew. A linear problem leaves 25 more.

use super::fit::Fit;
use super::joint::HINGE_UNKNOWNS;
use super::judge;
use super::pose::HingePose;
use super::refusal::HingeRefusal;
use super::result::IdentifiedHinge;
use crate::scalar::Real;

/// Where the profile is looked at, standard deviations.
const AT: f64 = 5.0;
/// Smallest rise of χ² over what a linear problem has there.
const MIN_RISE: f64 = 0.5;
/// Steps of the fit at each place.
const TRIALS: usize = 12;

/// Refuses a hinge beside which another one beyond 5 σ fits nearly as well.
///
/// # Errors
/// [`HingeRefusal::TwoAxesFit`].
pub(super) fn require_sigmas<T: Real>(
    fit: &Fit<T>,
    found: &IdentifiedHinge<T>,
    poses: &mut [HingePose<T>],
) -> Result<(), HingeRefusal> {
    let variance = found.noise_mm * found.noise_mm;
    for unknown in 0..HINGE_UNKNOWNS {
        let column = fit.equations.covariance_column(unknown, 0);
        let own = column.get(unknown).copied().unwrap_or_else(T::zero);
        // How all unknowns follow one that is a standard deviation off.
        let follow = column.map(|entry| entry * variance / (own * variance).root());
        for side in [T::of(AT), T::of(-AT)] {
            let mut other = fit.clone();
            other.held = Some(unknown);
            other.take(&follow.map(|entry| entry * side));
            other.minimise(poses, TRIALS, false);
            let off = found.hinge.difference(&other.hinge).get(unknown).copied().unwrap_or_else(T::zero);
            let deviations = off / (own * variance).root();
            let rise = (other.squares_mm2 - fit.squares_mm2) / variance;
            if !(rise >= T::of(MIN_RISE) * deviations * deviations) {
                return Err(judge::two_axes(fit, &fit.hinge, &other.hinge));
            }
        }
    }
    Ok(())
}
