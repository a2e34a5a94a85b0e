//! What the stages work on, and what they have done slice by slice.

use crate::identification::hinge::fit::{Equations, Estimate, Fit, Minimise, Place, Scratch};
use crate::identification::hinge::joint::{HINGE_UNKNOWNS, Hinge, is_direction};
use crate::identification::hinge::machine::{HingeMachine, MAX_CONSTANTS};
use crate::identification::hinge::pose::HingePose;
use crate::identification::hinge::result::IdentifiedHinge;
use crate::identification::hinge::rig::HingeRig;
use crate::identification::hinge::settings::HingeSettings;
use crate::scalar::Real;
use heapless::Vec;

/// Starts that the fit goes on from, the cheapest.
pub const CANDIDATES: usize = 16;
/// Steps of the fit with the machine's constants.
pub const LAST_TRIALS: usize = 60;
/// Two hinges are the same when no direction differs by more than this, rad, and no place, mm.
pub const SAME: (f64, f64) = (0.02, 2.0);

/// A converged hinge.
#[derive(Clone, Copy, Debug)]
pub struct Candidate<T: Real> {
    pub hinge: Hinge<T>,
    pub values: [T; MAX_CONSTANTS],
    pub squares_mm2: T,
}

/// The candidates, the best first.
pub type Candidates<T> = Vec<Candidate<T>, CANDIDATES>;
/// Hinges on their way with the squares that they leave, the cheapest first.
pub type Starts<T> = Vec<(Hinge<T>, T), CANDIDATES>;

/// A fit that another one must not spoil.
#[derive(Clone, Debug)]
pub struct Kept<T: Real> {
    pub estimate: Estimate<T>,
    pub squares_mm2: T,
    pub equations: Equations<T>,
}

/// Everything that the stages work on.
#[derive(Clone, Debug)]
pub struct Work<T: Real> {
    pub rig: HingeRig<T>,
    pub settings: HingeSettings<T>,
    pub fit: Fit<T>,
    pub scratch: Scratch<T>,
    task: Task<T>,
    pub kept: Kept<T>,
    pub starts: Starts<T>,
    pub candidates: Candidates<T>,
    /// The result, filled in as the stages find it.
    pub found: IdentifiedHinge<T>,
}

/// What is being done for a stage.
#[derive(Clone, Debug)]
enum Task<T: Real> {
    Nothing,
    /// The squares are minimised; then the poses get their χ², if wanted.
    Minimise {
        minimise: Minimise<T>,
        settle: bool,
    },
    /// The poses get the angles of a fit that was returned to, then their χ².
    Place(Place<T>),
    /// The next pose to get its χ².
    Settle(usize),
}

impl<T: Real> Work<T> {
    /// Nothing to do.
    pub fn new(rig: &HingeRig<T>, settings: HingeSettings<T>) -> Self {
        let (x, nowhere) = (nalgebra::Vector3::x(), nalgebra::Vector3::zeros());
        let hinge = Hinge::through(&x, &nowhere, &x, &nowhere);
        Self {
            rig: rig.clone(),
            settings,
            scratch: Scratch::new(),
            task: Task::Nothing,
            kept: Kept {
                estimate: (hinge, [T::zero(); MAX_CONSTANTS]),
                squares_mm2: T::zero(),
                equations: Equations::new(HINGE_UNKNOWNS),
            },
            starts: Vec::new(),
            candidates: Vec::new(),
            found: IdentifiedHinge::at(&hinge, HingeMachine::new(rig)),
            fit: Fit::new(rig, hinge),
        }
    }

    /// Is something under way? If so, a slice of it.
    pub fn advance(&mut self, poses: &mut [HingePose<T>]) -> bool {
        let Self { fit, scratch, .. } = self;
        match &mut self.task {
            Task::Nothing => return false,
            Task::Minimise { minimise, settle } => {
                if minimise.advance(fit, scratch, poses) {
                    self.task = if *settle { Task::Settle(0) } else { Task::Nothing };
                }
            }
            Task::Place(place) => {
                if place.advance(fit, &mut scratch.angles, poses).is_some() {
                    self.task = Task::Settle(0);
                }
            }
            Task::Settle(next) => match poses.get_mut(*next) {
                Some(pose) => {
                    fit.settle(pose);
                    *next += 1;
                }
                None => self.task = Task::Nothing,
            },
        }
        true
    }

    /// Has the squares minimised, at most `trials` steps. `search`: the poses' angles are not known yet.
    pub fn minimise(&mut self, trials: usize, search: bool) {
        self.task = Task::Minimise { minimise: Minimise::new(trials, search), settle: false };
    }

    /// The same; then the poses get their χ².
    pub fn minimise_and_settle(&mut self, trials: usize, search: bool) {
        self.task = Task::Minimise { minimise: Minimise::new(trials, search), settle: true };
    }

    /// Goes to a candidate: with its poses' angles and their χ² in the end.
    pub fn go_to(&mut self, candidate: &Candidate<T>) {
        self.fit.set_estimate((candidate.hinge, candidate.values));
        self.minimise_and_settle(LAST_TRIALS, true);
    }

    /// Keeps the fit as it is.
    pub fn keep(&mut self) {
        self.kept.estimate = self.fit.estimate();
        self.kept.squares_mm2 = self.fit.squares_mm2;
        self.kept.equations.clone_from(&self.fit.equations);
    }

    /// Back to the fit that was kept; the poses have the angles of another one.
    pub fn return_to_kept(&mut self) {
        self.fit.set_estimate(self.kept.estimate);
        self.fit.squares_mm2 = self.kept.squares_mm2;
        self.fit.equations.clone_from(&self.kept.equations);
        self.task = Task::Place(Place::new(true));
    }

    /// Nothing is under way any more.
    pub fn stop(&mut self) {
        self.task = Task::Nothing;
    }

    /// The present estimate.
    pub fn candidate(&self) -> Candidate<T> {
        let (hinge, values) = self.fit.estimate();
        Candidate { hinge, values, squares_mm2: self.fit.squares_mm2 }
    }
}

/// Does no direction of two hinges differ by more than the first limit, rad, and no place by more than the second, mm?
pub fn are_near<T: Real>(one: &Hinge<T>, other: &Hinge<T>, (turn_rad, move_mm): (f64, f64)) -> bool {
    let difference = one.difference(other);
    difference.iter().enumerate().all(|(k, x)| x.abs() < T::of(if is_direction(k) { turn_rad } else { move_mm }))
}
