//! Redundancy: would the result stand without any one of its poses? (Leave-one-out; internal reliability after Baarda.)
//!
//! If the standard deviation of the centre is far larger without a pose, the others cannot detect an error of that
//! pose.

use super::gates::MIN_POSES;
use super::refusal::Refusal;
use crate::scalar::Real;

/// Sets of up to this many poses are checked pose by pose. Of a larger set only the pose that makes most of the
/// excitation is.
const FEW_POSES: usize = 12;

/// The poses to leave out in turn: from `next` to before `last`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Candidates {
    /// The next pose, from 0.
    pub next: usize,
    /// One past the last.
    pub last: usize,
}

/// Which poses are left out: all of a few, or the one that makes most of the excitation.
pub fn candidates(used: usize, poses: usize, dominant: Option<usize>) -> Option<Candidates> {
    if used <= FEW_POSES {
        Some(Candidates { next: 0, last: poses })
    } else {
        dominant.map(|pose| Candidates { next: pose, last: pose + 1 })
    }
}

/// Largest ratio of the centre's standard deviation without one of `used` poses to that with all. Refuses 0.6 % of four
/// random poses (tilt 45, torsion 30 degrees), 0.07 % of five, 0.02 % of six, next to none of more (`cargo study
/// million`). Three are always refused: two never suffice, though rounding may hide that in their equations.
fn limit<T: Real>(used: usize) -> T {
    if used <= MIN_POSES {
        return T::zero();
    }
    let spare = T::of_integer((used - MIN_POSES) as i32);
    T::of(3.0) + T::of(27.0) / (spare * spare)
}

/// Refuses a set whose centre depends on pose `pose` alone. `sigma`, `without`: the centre's standard deviation in its
/// worst direction with all poses, and without that one.
///
/// With offsets or other parameters to be estimated, few poses hardly contradict each other, and the priors hide that
/// by bounding the standard deviation without the pose. `has_parameters` therefore sets the stricter limit of many
/// poses.
///
/// # Errors
/// [`Refusal::NotRedundant`].
pub fn require_redundancy<T: Real>(
    sigma: T,
    without: T,
    used: usize,
    has_parameters: bool,
    pose: usize,
) -> Result<(), Refusal> {
    let used = if has_parameters { used.max(FEW_POSES) } else { used };
    // Refuses NaN too.
    if without <= sigma * limit(used) { Ok(()) } else { Err(Refusal::NotRedundant { pose: pose as u32 }) }
}
