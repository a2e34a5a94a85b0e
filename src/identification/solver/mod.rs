//! The start-free solver: from raw lengths to a centre with an error bar, or a refusal that names its cause.
//!
//! ```text
//! place ──► pass ──► pass … ──► judge ──► blame ──► identified
//!   │         ▲        │          │
//!   │         └────────┘          └──► refused
//!   └ octahedron of each pose, linear fit of the pivot
//! ```
//!
//! 1. **Place**: the octahedron gives each pose's rotation R and origin t without knowing the centre. The centre is
//!    fixed in both bodies, O = R C + t, which is linear in O and C: one linear fit starts everything.
//! 2. **Pass**: Gauss-Newton with each pose's exact information (see
//!    [`pose_information`](super::pose_information)); the pose's own rotation is refined on the way. This is the
//!    maximum-likelihood estimate; its covariance is the inverse of the summed information.
//! 3. **Judge**: when the residuals are larger than the noise, poses are weighed down by their misfit (Geman-McClure,
//!    the scale lowered pass by pass) until those that contradict the others stand out, and are left out.
//! 4. **Blame**: each pose left out is explained: which cable, left out of the pose, reconciles it with the centre.

mod accumulation;
mod blame;
mod judgement;
mod placement;

use self::accumulation::PassSum;
use self::blame::Blame;
use self::placement::{Placement, Placer};
use super::normal_equations::{Factors, NormalEquations, Singular, UNKNOWNS};
use super::observability::RotationSum;
use super::outcome::{Identified, MOST_ITERATIONS, MOST_REJECTED, Progress, Refusal, Rejected, Termination, deviation};
use super::pose_buffer::DEFAULT_CAPACITY;
use super::uncertainty::covariance_of_parameters;
use crate::kinematics::{CableLengths, OctahedronError, Pivot};
use crate::rig::Rig;
use crate::scalar::Real;
use heapless::Vec;

/// Fewest poses that can determine the centre.
pub const FEWEST_POSES: usize = 3;

/// What is known of the noise of a cable length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Noise<T> {
    /// Its standard deviation is known, mm. Residuals beyond it are then evidence: of a bad reading, or of a centre
    /// that wanders.
    Known(T),
    /// It is estimated from the residuals; at most this much, mm, is taken for noise.
    EstimatedUpTo(T),
}

/// Limits of acceptance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolverSettings<T> {
    /// Noise of a cable length.
    pub noise: Noise<T>,
    /// Gauss-Newton ends when no unknown moves by more than this, mm.
    pub tolerance_mm: T,
    /// Largest 1σ of the centre in its worst direction, mm.
    pub sigma_limit_mm: T,
    /// Smallest sway about the most common axis, rad (see [`Sway`](super::observability::Sway)).
    pub sway_limit_rad: T,
}

impl<T: Real> SolverSettings<T> {
    /// The limits for `rig`, whose cable noise is taken as known.
    pub fn for_rig(rig: &Rig<T>) -> Self {
        Self {
            noise: Noise::Known(rig.length_noise_mm()),
            // The error after a step is about its square over the rig's size: far below any noise.
            tolerance_mm: (T::default_epsilon() * T::of(1e4)).min(T::of(1e-3)),
            // A tenth of what the humeral head itself moves in elevation (2-6 mm).
            sigma_limit_mm: T::one(),
            // 2.5 degrees: 0.1 mm of noise alone makes rotations about one axis sway by 0.1 degrees.
            sway_limit_rad: T::of(0.0436),
        }
    }
}

/// How poses are weighed in a pass.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Weighing<T> {
    /// All alike.
    Equal,
    /// By misfit over this scale, which is lowered pass by pass (in units of variance).
    Annealed(T),
    /// In or out.
    Selected,
    /// Equal weight for each pose's own centre: measures how far it wanders, after acceptance is lost.
    Wander {
        /// Passes still wanted.
        left: u8,
        /// Poses that the selection left out.
        rejected: u8,
    },
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase<T> {
    Place,
    Pass(Weighing<T>),
    Blame(Blame<T>),
}

/// The solver, resumable: each call of [`advance`](Self::advance) does a bounded slice of work, at most the placing of
/// one pose. Holds 24 bytes a pose in single precision beside the pose buffer.
#[derive(Clone, Debug)]
pub struct Solver<T: Real, const N: usize = DEFAULT_CAPACITY> {
    settings: SolverSettings<T>,
    placer: Placer<T>,
    placements: Vec<Placement<T>, N>,
    phase: Phase<T>,
    next: usize,
    linear: NormalEquations<T>,
    pivot: Pivot<T>,
    sum: PassSum<T>,
    noise_mm: T,
    selected_before: usize,
    passes_in_weighing: u8,
    deviations_mm: Vec<T, { MOST_ITERATIONS + 1 }>,
    result: Option<Identified<T>>,
}

impl<T: Real, const N: usize> Solver<T, N> {
    /// A solver for `rig`, at its beginning.
    pub fn new(rig: &Rig<T>, settings: SolverSettings<T>) -> Self {
        let placer = Placer::new(rig);
        let noise_mm = match settings.noise {
            Noise::Known(noise) => noise,
            Noise::EstimatedUpTo(_) => rig.length_noise_mm(),
        };
        Self {
            settings,
            pivot: Pivot::from_parameters(rig.nominal(), &placer.points),
            placer,
            placements: Vec::new(),
            phase: Phase::Place,
            next: 0,
            linear: NormalEquations::new(),
            sum: PassSum::new(),
            noise_mm,
            selected_before: 0,
            passes_in_weighing: 0,
            deviations_mm: Vec::new(),
            result: None,
        }
    }

    /// Runs to the end.
    ///
    /// # Errors
    /// The [`Refusal`] that names the cause.
    pub fn run(mut self, poses: &[CableLengths<T>]) -> Result<Identified<T>, Refusal> {
        loop {
            match self.advance(poses) {
                Progress::Working => {}
                Progress::Identified(identified) => return Ok(identified),
                Progress::Refused(refusal) => return Err(refusal),
            }
        }
    }

    /// One slice of work. `poses` must be the same in every call, at most `N` of them (more are not looked at).
    pub fn advance(&mut self, poses: &[CableLengths<T>]) -> Progress<T> {
        let poses = poses.get(..N).unwrap_or(poses);
        if poses.len() < FEWEST_POSES {
            return Progress::Refused(Refusal::TooFewPoses { poses: poses.len() as u8 });
        }
        let outcome = match (self.phase, poses.get(self.next)) {
            (Phase::Place, Some(lengths)) => {
                self.place(lengths);
                Ok(())
            }
            (Phase::Place, None) => self.finish_placing(),
            (Phase::Pass(weighing), Some(lengths)) => {
                self.weigh(weighing, lengths);
                Ok(())
            }
            (Phase::Pass(weighing), None) => self.finish_pass(weighing, poses.len()),
            (Phase::Blame(blame), _) => self.explain(blame, poses),
        };
        match outcome {
            Err(refusal) => Progress::Refused(refusal),
            Ok(()) => match (&self.phase, &self.result) {
                (Phase::Blame(blame), Some(result)) if blame.is_done(result) => Progress::Identified(result.clone()),
                _ => Progress::Working,
            },
        }
    }

    /// Steps taken so far.
    pub fn iterations(&self) -> u8 {
        self.deviations_mm.len() as u8
    }

    fn place(&mut self, lengths: &CableLengths<T>) {
        let placement = match self.placer.octahedron.solve(lengths) {
            Ok(pose) => {
                // O - R C = t, three equations.
                for row in 0..3 {
                    let mut equation = [T::zero(); UNKNOWNS];
                    equation[row] = T::one();
                    for column in 0..3 {
                        equation[3 + column] = -pose.rotation[(row, column)];
                    }
                    self.linear.add(&equation, pose.origin_mm[row]);
                }
                Placement::at(&pose.rotation)
            }
            Err(OctahedronError::DoesNotClose) => Placement::unplaced(),
            Err(OctahedronError::Length(error)) => Placement::broken(error.cable),
        };
        // Never full: `advance` looks at no more than N poses.
        let _ = self.placements.push(placement);
        self.next += 1;
    }

    /// The linear fit of the pivot.
    fn finish_placing(&mut self) -> Result<(), Refusal> {
        let placed = self.placements.iter().filter(|p| p.is_placed()).count();
        if placed < FEWEST_POSES {
            let first = self.placements.iter().position(|p| !p.is_placed()).unwrap_or(0);
            return Err(Refusal::PlatformDoesNotClose { pose: first as u8 });
        }
        match self.linear.solve() {
            Ok(x) => self.pivot = Pivot::from_array(&x),
            Err(Singular) => return Err(self.no_inverse()),
        }
        self.begin_pass(Weighing::Equal);
        Ok(())
    }

    fn begin_pass(&mut self, weighing: Weighing<T>) {
        let same = match (self.phase, weighing) {
            (Phase::Pass(before), now) => core::mem::discriminant(&before) == core::mem::discriminant(&now),
            _ => false,
        };
        self.passes_in_weighing = if same { self.passes_in_weighing + 1 } else { 0 };
        self.phase = Phase::Pass(weighing);
        self.next = 0;
        self.sum = PassSum::new();
    }

    /// Adds one pose to the pass.
    fn weigh(&mut self, weighing: Weighing<T>, lengths: &CableLengths<T>) {
        let variance = self.noise_mm * self.noise_mm;
        if let Some(placement) = self.placements.get_mut(self.next) {
            // A pose that fits nothing may stand on the wrong side of the fold: the known centre places it.
            let hopeless = placement.misfit > T::of(judgement::HOPELESS_MISFIT) || !placement.is_placed();
            if weighing == Weighing::Selected && hopeless && self.passes_in_weighing < 2 {
                self.placer.replace(placement, &self.pivot, lengths);
            }
            match weighing {
                Weighing::Equal => self.sum.add(placement, &self.placer, &self.pivot, lengths, variance, |_| T::one()),
                Weighing::Annealed(scale) => {
                    self.sum.add(placement, &self.placer, &self.pivot, lengths, variance, |misfit| {
                        let weight = scale / (scale + misfit);
                        weight * weight
                    });
                }
                Weighing::Selected => {
                    self.sum.add(placement, &self.placer, &self.pivot, lengths, variance, |misfit| {
                        if misfit <= T::of(judgement::MISFIT_LIMIT) { T::one() } else { T::zero() }
                    });
                }
                Weighing::Wander { .. } => self.sum.add_own_centre(placement, &self.placer, &self.pivot, lengths),
            }
        }
        self.next += 1;
    }

    /// Takes the step of a pass and decides what comes next.
    fn finish_pass(&mut self, weighing: Weighing<T>, poses: usize) -> Result<(), Refusal> {
        let Ok(step) = self.sum.equations.solve() else {
            return Err(match weighing {
                Weighing::Wander { rejected, .. } => Refusal::TooManyOutliers { rejected, poses: poses as u8 },
                _ => self.no_inverse(),
            });
        };
        self.pivot = self.pivot.moved_by(&step);
        let largest = step.iter().fold(T::zero(), |largest, x| largest.max(x.abs()));
        let squares_mm2 = self.sum.squares_after(&step);
        let deviation_mm = deviation(squares_mm2, self.sum.poses.max(1));
        if self.deviations_mm.push(deviation_mm).is_err() {
            return Err(Refusal::IterationCap);
        }
        let settled = largest <= self.settings.tolerance_mm;
        match weighing {
            Weighing::Equal => {
                if settled && self.sum.poses == poses && self.residuals_are_noise(squares_mm2) {
                    return self.accept(poses, squares_mm2);
                }
                if settled || self.passes_in_weighing >= judgement::EQUAL_PASSES {
                    let scale = self.begin_annealing();
                    self.begin_pass(Weighing::Annealed(scale));
                } else {
                    self.begin_pass(weighing);
                }
            }
            Weighing::Annealed(scale) => {
                let floor = T::of(judgement::ANNEALED_SCALE);
                self.begin_pass(if scale <= floor {
                    Weighing::Selected
                } else {
                    Weighing::Annealed((scale * T::of(judgement::ANNEALING)).max(floor))
                });
            }
            Weighing::Selected => {
                let stable = self.sum.poses == self.selected_before && settled;
                self.selected_before = self.sum.poses;
                if stable || self.passes_in_weighing >= judgement::SELECTED_PASSES {
                    return self.judge_selection(poses, squares_mm2);
                }
                self.begin_pass(weighing);
            }
            Weighing::Wander { left: 0, rejected } => {
                return Err(self.sum.wander(&step, &mut self.placements, rejected, poses));
            }
            Weighing::Wander { left, rejected } => self.begin_pass(Weighing::Wander { left: left - 1, rejected }),
        }
        Ok(())
    }

    /// Rotations decide why the normal matrix has no inverse.
    fn no_inverse(&self) -> Refusal {
        self.degenerate(|p| p.is_placed()).err().unwrap_or(Refusal::Singular)
    }

    /// Refuses poses that turn about one axis or are all alike; else their sway, rad.
    fn degenerate(&self, used: impl Fn(&Placement<T>) -> bool) -> Result<T, Refusal> {
        let mut rotations = RotationSum::default();
        for placement in self.placements.iter().filter(|p| used(p)) {
            rotations.add(&placement.rotation());
        }
        let sway = rotations.sway();
        let without_best = self.sway_without_best(&used, &sway);
        judgement::refuse_degenerate(&sway, without_best, self.settings.sway_limit_rad)?;
        Ok(sway.least_rad)
    }

    /// A direction that a single pose determines is not determined: that pose could not be checked.
    fn sway_without_best(&self, used: impl Fn(&Placement<T>) -> bool, sway: &super::observability::Sway<T>) -> T {
        let (mut sum, mut most, mut count) = (T::zero(), T::zero(), 0);
        for placement in self.placements.iter().filter(|p| used(p)) {
            let moved = (placement.rotation() * sway.axis_in_platform - sway.axis).norm_squared();
            sum += moved;
            most = most.max(moved);
            count += 1;
        }
        ((sum - most).max(T::zero()) / T::of_integer(count.max(1))).root()
    }

    /// Are the residuals no larger than the noise explains?
    fn residuals_are_noise(&mut self, squares_mm2: T) -> bool {
        let freedom = 3 * self.sum.poses as i32 - UNKNOWNS as i32;
        match self.settings.noise {
            Noise::Known(noise) => squares_mm2 <= noise * noise * judgement::chi_square_limit(freedom),
            Noise::EstimatedUpTo(most) => {
                let estimate = (squares_mm2 / T::of_integer(freedom.max(1))).root();
                let worst = self.placements.iter().fold(T::zero(), |worst, p| worst.max(p.misfit));
                // `misfit` is in units of the present noise figure; outliers stand out against the others.
                let floor = T::of(judgement::LEAST_NOISE_MM);
                let unit = self.noise_mm / estimate.max(floor);
                estimate <= most && worst * unit * unit <= T::of(judgement::MISFIT_LIMIT)
            }
        }
    }

    /// First scale of the annealing; with an unknown noise, its robust estimate too.
    fn begin_annealing(&mut self) -> T {
        let median = judgement::median_misfit(&mut self.placements);
        if let Noise::EstimatedUpTo(most) = self.settings.noise {
            let poses = T::of_integer(self.placements.len() as i32);
            let typical = median / T::of(judgement::MEDIAN_OF_CHI_SQUARE_3) * poses / (poses - T::of(2.0));
            let noise = (self.noise_mm * typical.root()).clamp(T::of(judgement::LEAST_NOISE_MM), most);
            self.noise_mm = noise;
            return T::of(judgement::ANNEALED_SCALE * 8.0);
        }
        (median * T::of(3.0)).max(T::of(judgement::ANNEALED_SCALE))
    }

    /// After the selection: are enough poses left, and is what they leave noise?
    fn judge_selection(&mut self, poses: usize, squares_mm2: T) -> Result<(), Refusal> {
        let rejected = poses - self.sum.poses.min(poses);
        let too_many = rejected * 5 > poses || rejected > MOST_REJECTED || self.sum.poses < FEWEST_POSES;
        let noise_fits = match self.settings.noise {
            Noise::Known(_) => self.residuals_are_noise(squares_mm2),
            Noise::EstimatedUpTo(most) => {
                let freedom = 3 * self.sum.poses as i32 - UNKNOWNS as i32;
                (squares_mm2 / T::of_integer(freedom.max(1))).root() <= most
            }
        };
        if too_many || !noise_fits {
            // What is wrong may still be the poses rather than the joint.
            self.degenerate(|p| p.is_placed())?;
            self.begin_pass(Weighing::Wander { left: 1, rejected: rejected as u8 });
            return Ok(());
        }
        self.accept(poses, squares_mm2)
    }

    /// The last gates, then the result; poses left out are explained next.
    fn accept(&mut self, poses: usize, squares_mm2: T) -> Result<(), Refusal> {
        let sway_rad = self.degenerate(|p| p.is_used())?;
        let factors = Factors::of(&self.sum.equations.matrix).map_err(|_| Refusal::Singular)?;
        let freedom = T::of_integer((3 * self.sum.poses as i32 - UNKNOWNS as i32).max(1));
        let noise_mm = match self.settings.noise {
            Noise::Known(noise) => noise,
            Noise::EstimatedUpTo(_) => (squares_mm2 / freedom).root(),
        };
        let of_pivot = factors.inverse();
        let unit = covariance_of_parameters(&of_pivot, &self.pivot, &self.placer.points);
        // Noise-free lengths must not pass a geometry that noise would ruin.
        let gate = noise_mm.max(self.placer.rig_noise_mm);
        judgement::refuse_weak(&unit, gate, self.settings.sigma_limit_mm)?;
        let mut rejected = Vec::new();
        for (pose, placement) in self.placements.iter().enumerate() {
            if !placement.is_used() {
                let _ = rejected.push(Rejected { pose: pose as u8, cables: placement.broken_cables() });
            }
        }
        self.result = Some(Identified {
            parameters: self.pivot.parameters(&self.placer.points),
            covariance_mm2: unit.map(|entry| entry * noise_mm * noise_mm),
            noise_mm,
            deviation_mm: deviation(squares_mm2, self.sum.poses),
            deviations_mm: self.deviations_mm.clone(),
            iterations: self.iterations(),
            termination: Termination::Settled,
            poses: poses as u8,
            rejected,
            sway_rad,
        });
        self.phase = Phase::Blame(Blame::new());
        Ok(())
    }

    fn explain(&mut self, mut blame: Blame<T>, poses: &[CableLengths<T>]) -> Result<(), Refusal> {
        if let Some(result) = &mut self.result {
            blame.advance(result, &self.placer, &self.pivot, poses);
        }
        self.phase = Phase::Blame(blame);
        Ok(())
    }
}
