//! Why no candidate is a hinge that explains the poses: a second axis beside one of them, a few wild poses, or another
//! joint.

use super::work::Work;
use crate::identification::hinge::judge::{self, Flexion};
use crate::identification::hinge::pose::HingePose;
use crate::identification::hinge::refusal::HingeRefusal;
use crate::identification::hinge::second_axis::SecondAxisSearch;
use crate::scalar::Real;

/// Candidates beside which a second axis is looked for, the cheapest.
const CANDIDATES_WITH_SECOND_AXIS: usize = 6;

/// The search for a reason under way.
#[derive(Clone, Debug)]
pub struct Explain<T: Real> {
    /// Too many poses contradict every candidate, if so.
    outliers: Option<HingeRefusal>,
    index: usize,
    step: Step<T>,
}

#[derive(Clone, Debug)]
enum Step<T: Real> {
    /// To the next candidate.
    GoTo,
    /// How far does the joint bend?
    Bend(Flexion<T>),
    /// Is there a second axis?
    Second(SecondAxisSearch<T>),
    /// At the best candidate again.
    AtFirst,
}

impl<T: Real> Explain<T> {
    /// Before the first candidate.
    pub const fn new(outliers: Option<HingeRefusal>) -> Self {
        Self { outliers, index: 0, step: Step::GoTo }
    }

    /// A slice; the reason at the end.
    pub fn advance(&mut self, work: &mut Work<T>, poses: &mut [HingePose<T>]) -> Option<HingeRefusal> {
        match &mut self.step {
            Step::GoTo => {
                let next = work.candidates.get(self.index).filter(|_| self.index < CANDIDATES_WITH_SECOND_AXIS);
                let is_next = next.is_some();
                let candidate = next.or(work.candidates.first()).copied();
                if let Some(candidate) = candidate {
                    work.go_to(&candidate);
                }
                self.step = if is_next { Step::Bend(Flexion::new()) } else { Step::AtFirst };
                None
            }
            Step::Bend(flexion) => {
                let range = flexion.advance(poses)?;
                self.step = Step::Second(SecondAxisSearch::new(&work.fit));
                judge::require_flexion(range, &work.settings).err()
            }
            Step::Second(search) => {
                let second = search.advance(&work.fit, &mut work.scratch.equations, poses)?;
                self.index += 1;
                self.step = Step::GoTo;
                let refusal = judge::no_hinge(&work.fit, poses, work.settings.noise, second.as_ref());
                Some(refusal).filter(|refusal| matches!(refusal, HingeRefusal::SecondAxis { .. }))
            }
            // A few wild poses leave the others nearly sound.
            Step::AtFirst => Some(match self.outliers {
                Some(outliers) if judge::is_mostly_sound(&work.fit, poses) => outliers,
                _ => judge::not_a_hinge(&work.fit, poses),
            }),
        }
    }
}
