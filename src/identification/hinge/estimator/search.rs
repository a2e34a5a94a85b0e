//! The candidates: the hinges that the starts and a drawing with priors lead to.

use super::work::{CANDIDATES, Candidate, LAST_TRIALS, SAME, Starts, Work, are_near};
use crate::identification::hinge::joint::Hinge;
use crate::identification::hinge::machine::MAX_CONSTANTS;
use crate::identification::hinge::pose::HingePose;
use crate::identification::hinge::rig::MAX_CABLES;
use crate::identification::hinge::starts::{STARTS, STARTS_BESIDE, beside, is_on_platform_side, start};
use crate::scalar::Real;
use heapless::Vec;

/// Steps of the fit from every start, and from the cheapest, or a drawing.
const FIRST_TRIALS: usize = 8;
const START_TRIALS: usize = 60;
/// Two starts on their way lead to one hinge when no direction differs by more than this, rad, and no place, mm.
const NEAR: (f64, f64) = (0.1, 10.0);
/// Hinges that a slice holds against another one.
const COMPARED_A_SLICE: usize = 4;

/// The search under way.
#[derive(Clone, Copy, Debug)]
pub struct Search<T> {
    /// From the starts beside the best hinge so far, or from all over?
    beside: bool,
    /// The start or candidate meant.
    index: usize,
    /// Known hinges that the present one has been held against.
    compared: usize,
    mean_length_mm: T,
    step: Step,
}

#[derive(Clone, Copy, Debug)]
enum Step {
    Begin,
    /// The first steps from a start are to be taken; they are taken.
    SetOut,
    IsOut,
    /// The hinge lies on the platform's side.
    IsOnSide,
    /// The same from one of the cheapest; then to the end.
    GoOn,
    IsOnItsWay,
    HasArrived,
    /// The hinge may be one.
    IsPossible,
    /// The machine's constants are to take part; they did.
    Refine,
    IsRefined,
}

impl<T: Real> Search<T> {
    /// At the beginning.
    pub fn new() -> Self {
        Self { beside: false, index: 0, compared: 0, mean_length_mm: T::zero(), step: Step::Begin }
    }

    /// What follows the last minimisation; true when all candidates are there.
    pub fn advance(&mut self, work: &mut Work<T>, poses: &[HingePose<T>]) -> bool {
        match self.step {
            Step::Begin => self.begin(work, poses),
            Step::SetOut => self.set_out(work),
            Step::IsOut if is_on_platform_side(&work.fit.machine, &work.fit.hinge) => self.step = Step::IsOnSide,
            Step::IsOut => self.next(Step::SetOut),
            Step::IsOnSide => {
                let hinge = work.fit.hinge;
                let Some(same) = self.look(&work.starts, |known| are_near(&known.0, &hinge, NEAR)) else {
                    return false;
                };
                insert(&mut work.starts, (hinge, work.fit.squares_mm2), same);
                self.next(Step::SetOut);
            }
            Step::GoOn => match work.starts.get(self.index) {
                Some((hinge, _)) => {
                    work.fit.hinge = named(work, hinge);
                    work.minimise(FIRST_TRIALS, true);
                    self.step = Step::IsOnItsWay;
                }
                None => return self.after_arrivals(work),
            },
            // Most starts lead to the same few hinges: there is no need to arrive once more.
            Step::IsOnItsWay => match self.look_for_candidate(work) {
                None => {}
                Some(None) => {
                    work.minimise(START_TRIALS, false);
                    self.step = Step::HasArrived;
                }
                Some(Some(_)) => self.next(Step::GoOn),
            },
            Step::HasArrived => {
                // A drawing that is a prior says on which side; two points have no plane.
                let is_possible = work.fit.prior().is_some() || is_on_platform_side(&work.fit.machine, &work.fit.hinge);
                if is_possible {
                    self.step = Step::IsPossible;
                } else {
                    self.next(Step::GoOn);
                }
            }
            Step::IsPossible => {
                let Some(same) = self.look_for_candidate(work) else { return false };
                if same.is_none() {
                    add(work);
                }
                self.next(Step::GoOn);
            }
            Step::Refine => match work.starts.get(self.index) {
                Some((hinge, _)) => {
                    work.fit.set_estimate((*hinge, [T::zero(); MAX_CONSTANTS]));
                    work.minimise(LAST_TRIALS, true);
                    self.step = Step::IsRefined;
                }
                None => return true,
            },
            Step::IsRefined => {
                add(work);
                self.next(Step::Refine);
            }
        }
        false
    }

    fn next(&mut self, step: Step) {
        self.index += 1;
        self.step = step;
    }

    /// Looks through some more of the known ones for the first that is the present one: where it is, if at all; `None` before
    /// the end.
    fn look<X>(&mut self, known: &[X], is_same: impl Fn(&X) -> bool) -> Option<Option<usize>> {
        let from = self.compared;
        self.compared += COMPARED_A_SLICE;
        let same = known.iter().skip(from).take(COMPARED_A_SLICE).position(is_same).map(|place| from + place);
        (same.is_some() || self.compared >= known.len()).then(|| {
            self.compared = 0;
            same
        })
    }

    /// The same among the candidates.
    fn look_for_candidate(&mut self, work: &Work<T>) -> Option<Option<usize>> {
        self.look(&work.candidates, |known| are_near(&known.hinge, &work.fit.hinge, SAME))
    }

    fn begin_at_the_first(&mut self, step: Step) {
        (self.index, self.step) = (0, step);
    }

    fn begin(&mut self, work: &mut Work<T>, poses: &[HingePose<T>]) {
        work.fit.constants = false;
        work.fit.machine.set_values([T::zero(); MAX_CONSTANTS]);
        work.starts.clear();
        work.candidates.clear();
        if let Some(drawing) = work.fit.drawing.filter(|drawing| drawing.sigma.is_some()) {
            let _ = work.starts.push((drawing.hinge, T::zero()));
        }
        self.mean_length_mm = mean_length(poses, work.fit.machine.cables());
        // Fewer cables follow the drawing.
        let has_all_cables = work.fit.machine.cables() >= MAX_CABLES;
        self.begin_at_the_first(if has_all_cables { Step::SetOut } else { Step::GoOn });
    }

    /// The first steps from the next start.
    fn set_out(&mut self, work: &mut Work<T>) {
        let (machine, mean, index) = (&work.fit.machine, self.mean_length_mm, self.index);
        let hinge = match work.candidates.first().filter(|_| self.beside) {
            Some(best) if index < STARTS_BESIDE => beside(machine, mean, &best.hinge, index),
            None if index < STARTS => start(machine, mean, index),
            _ => return self.begin_at_the_first(Step::GoOn),
        };
        work.fit.hinge = named(work, &hinge);
        work.minimise(FIRST_TRIALS, true);
        self.step = Step::IsOut;
    }

    /// What follows when all starts have arrived; true when nothing does.
    fn after_arrivals(&mut self, work: &mut Work<T>) -> bool {
        // Another hinge that fits mostly has nearly the same axis in the base and another one in the platform.
        if work.fit.machine.cables() >= MAX_CABLES && !self.beside && !work.candidates.is_empty() {
            work.starts.clear();
            self.beside = true;
            self.begin_at_the_first(Step::SetOut);
            return false;
        }
        if work.fit.machine.constants().is_empty() {
            return true;
        }
        work.fit.constants = true;
        work.starts.clear();
        for candidate in &work.candidates {
            // There is room for as many as there are.
            let _ = work.starts.push((candidate.hinge, candidate.squares_mm2));
        }
        work.candidates.clear();
        self.begin_at_the_first(Step::Refine);
        false
    }
}

/// The hinge in the direction of the drawing, so that the drawing's angles are its angles.
fn named<T: Real>(work: &Work<T>, hinge: &Hinge<T>) -> Hinge<T> {
    hinge.named_as(work.fit.drawing.as_ref().map(|drawing| drawing.hinge.axis()))
}

/// Adds the present estimate to the candidates, the best first.
fn add<T: Real>(work: &mut Work<T>) {
    let new = work.candidate();
    put_in_order(&mut work.candidates, new, |candidate: &Candidate<T>| candidate.squares_mm2);
}

/// Keeps the cheapest hinges, in order; of those on the way to the same one, the cheapest. `same`: where that is already.
fn insert<T: Real>(starts: &mut Starts<T>, new: (Hinge<T>, T), same: Option<usize>) {
    if let Some(place) = same {
        if starts.get(place).is_some_and(|known| known.1 <= new.1) {
            return;
        }
        let mut places = 0..;
        starts.retain(|_| places.next() != Some(place));
    }
    put_in_order(starts, new, |start| start.1);
}

/// Puts an item before the first one that costs more; of a full list the last goes.
fn put_in_order<T: Real, X>(list: &mut Vec<X, CANDIDATES>, new: X, cost: fn(&X) -> T) {
    let place = list.iter().position(|known| cost(&new) < cost(known)).unwrap_or(list.len());
    let mut next = new;
    list.iter_mut().skip(place).for_each(|item| core::mem::swap(item, &mut next));
    let _ = list.push(next);
}

fn mean_length<T: Real>(poses: &[HingePose<T>], cables: usize) -> T {
    let lengths = poses.iter().flat_map(|pose| pose.lengths_mm.iter().take(cables));
    let (sum, count) = lengths.fold((T::zero(), 0), |(sum, count), length| (sum + *length, count + 1));
    sum / T::of_integer(count.max(1))
}
