//! Does another hinge fit as well as the one found? Then it is the one that the drawing means, or a refusal.

use super::work::{LAST_TRIALS, Work};
use crate::identification::hinge::joint::{HINGE_UNKNOWNS, Hinge};
use crate::identification::hinge::judge;
use crate::identification::hinge::refusal::HingeRefusal;
use crate::scalar::Real;

/// Another hinge whose χ² is larger by less than this fits as well: at the most once in 250 000 the true one is worse by more.
const BOTH_FIT: f64 = 20.0;
/// Two hinges farther apart than this many standard deviations in any unknown are two.
const DISTINCT: f64 = 4.0;
/// A hinge within this of the drawing is the drawn one when the other that fits is farther than twice this from it.
const AT_DRAWING_RAD: f64 = 0.262;
const AT_DRAWING_MM: f64 = 30.0;

/// The comparison under way.
#[derive(Clone, Copy, Debug)]
pub struct Compare<T> {
    index: usize,
    /// The candidate at `index` is being fitted.
    is_fitting: bool,
    /// Squares below which another hinge fits as well, mm², and what tells two apart.
    limit_mm2: T,
    sigmas: [T; HINGE_UNKNOWNS],
}

/// What comes of it.
#[derive(Clone, Copy, Debug)]
pub enum Compared {
    /// The result stands.
    Stands,
    /// The drawing means the hinge that is fitted now: it is to be the result, and is to be compared with those that are left.
    Other,
    /// Both fit.
    Refused(HingeRefusal),
}

impl<T: Real> Compare<T> {
    /// With the result as it was first found.
    pub fn new(work: &Work<T>) -> Self {
        let found = &work.found;
        let limit_mm2 = work.fit.squares_mm2 + T::of(BOTH_FIT) * found.noise_mm * found.noise_mm;
        Self { index: 0, is_fitting: false, limit_mm2, sigmas: found.sigmas() }
    }

    /// What follows the last minimisation; the outcome at the end.
    pub fn advance(&mut self, work: &mut Work<T>) -> Option<Compared> {
        if self.is_fitting {
            self.is_fitting = false;
            self.index += 1;
            return self.judge(work);
        }
        let Some(other) = work.candidates.get(self.index).copied() else { return Some(Compared::Stands) };
        if !self.is_other(work, &other.hinge) {
            self.index += 1;
            return None;
        }
        // Without the poses that are left out it may fit better than it did.
        work.keep();
        work.fit.set_estimate((other.hinge, other.values));
        work.minimise(LAST_TRIALS, true);
        self.is_fitting = true;
        None
    }

    fn is_other(&self, work: &Work<T>, other: &Hinge<T>) -> bool {
        let difference = work.found.hinge.difference(other);
        difference.iter().zip(&self.sigmas).any(|(x, sigma)| x.abs() > *sigma * T::of(DISTINCT))
    }

    fn judge(&self, work: &mut Work<T>) -> Option<Compared> {
        let other = work.fit.hinge;
        if !(self.is_other(work, &other) && work.fit.squares_mm2 < self.limit_mm2) {
            work.return_to_kept();
            return None;
        }
        let best = work.kept.estimate.0;
        match (off_drawing(work, &best), off_drawing(work, &other)) {
            (Some(one), Some(two)) if one < T::one() && two > T::of(2.0) => {
                work.return_to_kept();
                None
            }
            (Some(one), Some(two)) if two < T::one() && one > T::of(2.0) => Some(Compared::Other),
            _ => Some(Compared::Refused(judge::two_axes(&work.fit, &best, &other))),
        }
    }
}

/// How far a hinge is from the drawing, the limit of what counts as drawn being 1. A drawing that is a prior already has its
/// say in the squares.
fn off_drawing<T: Real>(work: &Work<T>, hinge: &Hinge<T>) -> Option<T> {
    let drawing = work.rig.drawing().filter(|drawing| drawing.sigma.is_none())?;
    let (angle, distance) = judge::apart(&work.fit, &drawing.hinge, hinge);
    Some((angle / T::of(AT_DRAWING_RAD)).max(distance / T::of(AT_DRAWING_MM)))
}
