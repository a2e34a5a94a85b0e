//! Leaves out the poses that contradict the others, from the candidate that leaves least.

use super::leave_out::LeaveOut;
use super::work::{Candidate, SAME, Work, are_near};
use crate::identification::hinge::joint::Hinge;
use crate::identification::hinge::judge;
use crate::identification::hinge::pose::HingePose;
use crate::identification::hinge::refusal::HingeRefusal;
use crate::scalar::Real;

/// Sums of the poses' χ², each cut off where it is left out, that differ by less than this do not tell two hinges apart.
const BOTH_FIT_WITHOUT_OUTLIERS: f64 = 50.0;

/// The attempts from all candidates.
#[derive(Clone, Debug)]
pub struct Outliers<T: Real> {
    /// The candidate under way, and what is done from it; none before the first.
    index: usize,
    attempt: Option<LeaveOut<T>>,
    best: Option<Candidate<T>>,
    /// The best of those that are another hinge than the best.
    rival: Option<(Hinge<T>, T)>,
    /// Why no attempt succeeded, of the first that failed so.
    failure: Option<HingeRefusal>,
    /// The last attempt, from the best.
    is_last: bool,
}

/// What becomes of them.
#[derive(Clone, Copy, Debug)]
pub enum Left {
    /// A hinge that the poses left explain.
    Hinge,
    /// A hinge from which the poses left differ by more than noise.
    NoHinge,
    /// No candidate is one. Too many poses contradict it, if so.
    Nothing(Option<HingeRefusal>),
    /// A refusal.
    Refused(HingeRefusal),
}

impl<T: Real> Outliers<T> {
    /// Before the first candidate.
    pub const fn new() -> Self {
        Self { index: 0, attempt: None, best: None, rival: None, failure: None, is_last: false }
    }

    /// What follows the last minimisation; the outcome at the end.
    pub fn advance(&mut self, work: &mut Work<T>, poses: &mut [HingePose<T>]) -> Option<Left> {
        if let Some(attempt) = &mut self.attempt {
            let outcome = attempt.advance(work, poses)?;
            self.attempt = None;
            if self.is_last {
                return Some(match outcome {
                    Err(refusal) => Left::Refused(refusal),
                    Ok(()) if judge::are_noise(&work.fit, poses, work.settings.noise) => Left::Hinge,
                    Ok(()) => Left::NoHinge,
                });
            }
            self.note(outcome, work, poses);
            self.index += 1;
        }
        match work.candidates.get(self.index).copied() {
            Some(candidate) => {
                self.attempt = Some(LeaveOut::from(&candidate, work, poses));
                None
            }
            None => self.decide(work, poses),
        }
    }

    /// Notes what became of the attempt from one candidate.
    fn note(&mut self, outcome: Result<(), HingeRefusal>, work: &Work<T>, poses: &[HingePose<T>]) {
        if outcome.is_ok() && judge::are_noise(&work.fit, poses, work.settings.noise) {
            let squares_mm2 = judge::cut_off_squares(&work.fit, poses);
            let found = Candidate { squares_mm2, ..work.candidate() };
            let is_better = self.best.as_ref().is_none_or(|best| found.squares_mm2 < best.squares_mm2);
            let other = if is_better { self.best.replace(found) } else { Some(found) };
            let is_rival = |other: &Candidate<T>| {
                self.best.as_ref().is_some_and(|best| !are_near(&best.hinge, &other.hinge, SAME))
                    && self.rival.is_none_or(|rival| other.squares_mm2 < rival.1)
            };
            let rival = other.filter(is_rival).map(|other| (other.hinge, other.squares_mm2));
            self.rival = rival.or(self.rival);
        } else if let (Err(refusal), None) = (outcome, self.failure) {
            self.failure = Some(refusal);
        }
    }

    /// Once more from the best; or two different ones are, or none.
    fn decide(&mut self, work: &mut Work<T>, poses: &mut [HingePose<T>]) -> Option<Left> {
        let Some(best) = self.best else {
            poses.iter_mut().for_each(|pose| pose.weight = T::one());
            return Some(Left::Nothing(self.failure));
        };
        let window = T::of(BOTH_FIT_WITHOUT_OUTLIERS) * work.fit.noise_mm * work.fit.noise_mm;
        if let Some((rival, _)) = self.rival.filter(|rival| rival.1 < best.squares_mm2 + window) {
            return Some(Left::Refused(judge::two_axes(&work.fit, &best.hinge, &rival)));
        }
        self.attempt = Some(LeaveOut::from(&best, work, poses));
        self.is_last = true;
        None
    }
}
