//! The hinges that the starts lead to.

use super::fit::Fit;
use super::joint::{Hinge, is_direction};
use super::machine::{HingeMachine, MAX_CONSTANTS};
use super::pose::HingePose;
use super::rig::MAX_CABLES;
use super::starts::{STARTS, STARTS_BESIDE, beside, is_on_platform_side, start};
use crate::scalar::Real;
use heapless::Vec;

/// Starts that the fit goes on from, the cheapest.
const CANDIDATES: usize = 16;
/// Steps of the fit from every start; from the cheapest, or a drawing; with the machine's constants.
const FIRST_TRIALS: usize = 8;
const START_TRIALS: usize = 60;
pub(super) const LAST_TRIALS: usize = 60;
/// Two starts on their way lead to one hinge when no direction differs by more than this, rad, and no place, mm; and when
/// they have arrived.
const NEAR: (f64, f64) = (0.1, 10.0);
pub(super) const SAME: (f64, f64) = (0.02, 2.0);

/// A converged hinge.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate<T: Real> {
    pub hinge: Hinge<T>,
    pub values: [T; MAX_CONSTANTS],
    pub squares_mm2: T,
}

/// The candidates, the best first.
pub(super) type Candidates<T> = Vec<Candidate<T>, CANDIDATES>;
/// Hinges on their way with the squares that they leave, the cheapest first.
type Starts<T> = Vec<(Hinge<T>, T), CANDIDATES>;

impl<T: Real> Fit<T> {
    /// The hinges that the starts and a drawing with priors lead to, the best first.
    pub fn candidates(&mut self, poses: &mut [HingePose<T>]) -> Candidates<T> {
        let mut starts = Starts::new();
        self.constants = false;
        self.machine.set_values([T::zero(); MAX_CONSTANTS]);
        if let Some(drawing) = self.drawing.filter(|drawing| drawing.sigma.is_some()) {
            let _ = starts.push((drawing.hinge, T::zero()));
        }
        let mut rough = Candidates::new();
        // Fewer cables follow the drawing.
        if self.machine.cables() < MAX_CABLES {
            self.arrive(&starts, poses, &mut rough);
        } else {
            let mean = mean_length(poses, self.machine.cables());
            self.set_out(STARTS, |machine, index| start(machine, mean, index), poses, &mut starts);
            self.arrive(&starts, poses, &mut rough);
            // Another hinge that fits mostly has nearly the same axis in the base and another one in the platform.
            if let Some(best) = rough.first().map(|best| best.hinge) {
                starts.clear();
                self.set_out(STARTS_BESIDE, |machine, index| beside(machine, mean, &best, index), poses, &mut starts);
                self.arrive(&starts, poses, &mut rough);
            }
        }
        if self.machine.constants().is_empty() {
            return rough;
        }
        let mut candidates = Vec::new();
        self.constants = true;
        for start in &rough {
            self.hinge = start.hinge;
            self.machine.set_values(start.values);
            self.minimise(poses, LAST_TRIALS, true);
            add(&mut candidates, self.candidate());
        }
        candidates
    }

    /// The first steps from each of some starts.
    fn set_out(
        &mut self,
        count: usize,
        at: impl Fn(&HingeMachine<T>, usize) -> Hinge<T>,
        poses: &mut [HingePose<T>],
        starts: &mut Starts<T>,
    ) {
        for index in 0..count {
            self.hinge = at(&self.machine, index);
            self.minimise(poses, FIRST_TRIALS, true);
            if is_on_platform_side(&self.machine, &self.hinge) {
                insert(starts, (self.hinge, self.squares_mm2));
            }
        }
    }

    /// Goes on to the end.
    fn arrive(&mut self, starts: &Starts<T>, poses: &mut [HingePose<T>], rough: &mut Candidates<T>) {
        for (hinge, _) in starts {
            self.hinge = *hinge;
            self.minimise(poses, FIRST_TRIALS, true);
            // Most starts lead to the same few hinges: there is no need to arrive once more.
            if self.is_known(rough) {
                continue;
            }
            self.minimise(poses, START_TRIALS, false);
            // A drawing that is a prior says on which side; two points have no plane.
            let is_possible = self.prior().is_some() || is_on_platform_side(&self.machine, &self.hinge);
            if is_possible && !self.is_known(rough) {
                add(rough, self.candidate());
            }
        }
    }

    fn is_known(&self, candidates: &Candidates<T>) -> bool {
        candidates.iter().any(|known| are_near(&known.hinge, &self.hinge, SAME))
    }

    /// The present estimate.
    pub fn candidate(&self) -> Candidate<T> {
        Candidate { hinge: self.hinge, values: *self.machine.values(), squares_mm2: self.squares_mm2 }
    }
}

/// Keeps the cheapest hinges, in order; of those on the way to the same one, the cheapest.
fn insert<T: Real>(starts: &mut Starts<T>, new: (Hinge<T>, T)) {
    if let Some(place) = starts.iter().position(|known| are_near(&known.0, &new.0, NEAR)) {
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

/// Does no direction of two hinges differ by more than the first limit, rad, and no place by more than the second, mm?
pub(super) fn are_near<T: Real>(one: &Hinge<T>, other: &Hinge<T>, (turn_rad, move_mm): (f64, f64)) -> bool {
    let difference = one.difference(other);
    difference.iter().enumerate().all(|(k, x)| x.abs() < T::of(if is_direction(k) { turn_rad } else { move_mm }))
}

/// Adds a candidate at its place, the best first.
fn add<T: Real>(candidates: &mut Candidates<T>, new: Candidate<T>) {
    put_in_order(candidates, new, |candidate| candidate.squares_mm2);
}

fn mean_length<T: Real>(poses: &[HingePose<T>], cables: usize) -> T {
    let lengths = poses.iter().flat_map(|pose| pose.lengths_mm.iter().take(cables));
    let (sum, count) = lengths.fold((T::zero(), 0), |(sum, count), length| (sum + *length, count + 1));
    sum / T::of_integer(count.max(1))
}
