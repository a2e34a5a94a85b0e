//! Every pose gets its best angle at the present estimate, a round of one pose a slice: sine and cosine take long.

use super::Fit;
use crate::identification::hinge::pose::{AngleSearch, HingePose, PoseAt};
use crate::scalar::Real;

/// Angles of the search that a slice adds.
const ANGLES_A_SLICE: usize = 2;
/// Gauss-Newton rounds for the angle of one pose, from where it was searched, and from its last value.
const SEARCHED_ROUNDS: usize = 4;
const NEXT_ROUNDS: usize = 2;

/// The angles under way.
#[derive(Clone, Copy, Debug)]
pub struct Place<T> {
    /// Are they searched for, or do they follow from the last ones?
    search: bool,
    /// The search's angles so far.
    searched: usize,
    /// The next pose, and the rounds for its angle so far.
    next: usize,
    round: usize,
    /// Of the priors and the poses so far, mm².
    squares: T,
}

impl<T: Real> Place<T> {
    /// Before the first pose.
    pub fn new(search: bool) -> Self {
        Self { search, searched: 0, next: 0, round: 0, squares: T::zero() }
    }

    /// One slice; at the end the sum of the squares, mm². The poses' angles stay on trial.
    pub fn advance(&mut self, fit: &Fit<T>, angles: &mut AngleSearch<T>, poses: &mut [HingePose<T>]) -> Option<T> {
        if self.search && self.searched < AngleSearch::<T>::ANGLES {
            if self.searched == 0 {
                angles.begin(fit.range_rad());
            }
            let until = self.searched + ANGLES_A_SLICE;
            angles.look(&fit.hinge, &fit.machine, self.searched..until);
            self.searched = until;
            return None;
        }
        if self.next == 0 && self.round == 0 {
            self.squares = fit.prior_squares();
        }
        if let Some(pose) = poses.get_mut(self.next) {
            let rounds = if self.search { SEARCHED_ROUNDS } else { NEXT_ROUNDS };
            if self.round == 0 {
                let cables = fit.machine.cables();
                let last = pose.angle_rad;
                pose.trial_rad = if self.search { angles.nearest_rad(&pose.lengths_mm, cables) } else { last };
            }
            let at = PoseAt::new(&fit.hinge, &fit.machine);
            if self.round < rounds {
                pose.trial_rad = at.turned(&pose.lengths_mm, pose.trial_rad, 1);
                self.round += 1;
            } else {
                self.squares += at.squares(&pose.lengths_mm, pose.trial_rad) * pose.weight;
                (self.next, self.round) = (self.next + 1, 0);
            }
        }
        (self.next >= poses.len()).then_some(self.squares)
    }
}
