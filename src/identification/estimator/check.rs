//! The result of a converged fit, then leave-one-out: a pass without each candidate pose in turn.

use super::Next;
use super::fit::{Fit, Pass};
use super::result::{Acceptance, Accepted};
use crate::identification::leave_one_out::{Candidates, require_redundancy};
use crate::identification::machine::Machine;
use crate::identification::pose::Pose;
use crate::identification::uncertainty::worst_direction_of_point;
use crate::identification::weights::Weights;
use crate::linear_algebra::{Singular, block};
use crate::scalar::Real;

/// The acceptance first; then the candidates, and the pass without the present one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Check<T> {
    /// Until the result is written.
    acceptance: Option<Acceptance<T>>,
    candidates: Candidates,
    /// The centre's standard deviation in its worst direction with all poses, for a noise of 1 mm.
    sigma: T,
    pass: Option<Pass<T>>,
    is_summed: bool,
    /// The equations are no longer those of all poses.
    has_left_out: bool,
}

impl<T: Real> Check<T> {
    /// Begins.
    pub fn new(accepted: Accepted) -> Self {
        Self {
            acceptance: Some(Acceptance::new(accepted)),
            candidates: Candidates { next: 0, last: 0 },
            sigma: T::zero(),
            pass: None,
            is_summed: false,
            has_left_out: false,
        }
    }

    /// The next slice of the acceptance, or of the pass without the present candidate. The centre must still be determined,
    /// though worse.
    pub fn advance(&mut self, fit: &mut Fit<T>, machine: &Machine<T>, poses: &mut [Pose<T>]) -> Option<Next<T>> {
        if let Some(acceptance) = &mut self.acceptance {
            return match acceptance.advance(fit, machine, poses)? {
                Ok((candidates, sigma)) => {
                    (self.acceptance, self.candidates, self.sigma) = (None, candidates, sigma);
                    None
                }
                Err(refusal) => Some(Next::Done(Err(refusal))),
            };
        }
        let pose = self.candidates.next;
        let is_last = pose >= self.candidates.last;
        if is_last && !self.has_left_out {
            return Some(Next::Isolate);
        }
        // After the last candidate one pass with all poses, so that the covariances that follow are those of all.
        let is_used = is_last || poses.get(pose).is_some_and(Pose::is_used);
        let Some(pass) = &mut self.pass else {
            if is_used {
                fit.begin_pass();
                (self.pass, self.is_summed) = (Some(Pass::default()), false);
            } else {
                self.candidates.next += 1;
            }
            return None;
        };
        if !self.is_summed {
            let weights = Weights::Without { pose: if is_last { usize::MAX } else { pose } };
            self.is_summed = !fit.add_next_pose(pass, machine, poses, &weights, T::of(f64::INFINITY));
            return None;
        }
        if is_last {
            return match fit.factor() {
                Ok(false) => None,
                // Singular cannot be: the same equations had a factor before.
                _ => Some(Next::Isolate),
            };
        }
        self.has_left_out = true;
        let without = match fit.factor() {
            Ok(false) => return None,
            Ok(true) => {
                let covariance = fit.centre_covariance();
                worst_direction_of_point(&block::<T, 0, 0>(&covariance)).0
            }
            Err(Singular) => T::of(f64::INFINITY),
        };
        self.pass = None;
        self.candidates.next += 1;
        let has_parameters = fit.parameters() > 0;
        match require_redundancy(self.sigma, without, fit.residuals.used, has_parameters, pose) {
            Ok(()) => None,
            Err(refusal) => Some(Next::Done(Err(refusal))),
        }
    }
}
