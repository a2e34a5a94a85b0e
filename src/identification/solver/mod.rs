//! The start-free solver: from raw lengths to a centre with an error bar, or a refusal that names its cause.
//!
//! ```text
//! place ──► pass ──► pass … ──► judge ──► check ──► blame ──► identified
//!   │         ▲        │          │
//!   │         └────────┘          └────────┴──► refused
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
//! 4. **Check**: would the result stand without any one of few poses, or without the one that makes most of the sway?
//!    If not, nothing could contradict that pose, and the set is weak.
//! 5. **Blame**: each pose left out is explained: which cable, left out of the pose, reconciles it with the centre.

mod acceptance;
mod accumulation;
mod attitude;
mod blame;
mod judgement;
mod noise;
mod placement;
mod settings;

use self::accumulation::PassSum;
use self::blame::Blame;
use self::judgement::Misfits;
use self::placement::{Placement, Placer};
pub use self::settings::{Noise, SolverSettings};
use super::normal_equations::Singular;
use super::outcome::{Identified, Progress, Refusal, deviation};
use super::pivot_fit::PivotFit;
use super::pose_buffer::DEFAULT_CAPACITY;
use super::zeros::{UnknownZeros, Zeros};
use crate::kinematics::arm::nearest_attitude;
use crate::kinematics::cable_length::cable_number;
use crate::kinematics::{CableLengths, LengthFault, OctahedronError, Pivot};
use crate::rig::Rig;
use crate::scalar::Real;
use heapless::Vec;

/// Fewest poses that can determine the centre. Three determine it but cannot be trusted: each of them can be wrong in
/// one direction without the others contradicting it, and the set is refused as hanging on one pose.
pub const FEWEST_POSES: usize = 3;

/// Fewest poses that must remain when others are left out: fewer can agree by chance with the wrong one among them.
pub const FEWEST_AFTER_REJECTION: usize = 5;

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
        /// Poses that the selection left out.
        rejected: u16,
    },
    /// Taken away again.
    Without,
}

impl<T: Real> Weighing<T> {
    /// Weight of a pose with this misfit.
    fn weight(&self, misfit: T) -> T {
        match self {
            Self::Equal | Self::Wander { .. } => T::one(),
            Self::Annealed(scale) => {
                let root = *scale / (*scale + misfit);
                root * root
            }
            Self::Selected if misfit <= T::of(judgement::MISFIT_LIMIT) => T::one(),
            Self::Selected => T::zero(),
            Self::Without => -T::one(),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    Place,
    Pass,
    /// Would the result stand without any one of its poses?
    Check {
        /// One past the last pose to be doubted.
        last: usize,
    },
    Blame,
    Refused(Refusal),
}

/// The solver, resumable: each call of [`advance`](Self::advance) does a bounded slice of work, at most the placing of
/// one pose. Holds 12 bytes a pose in single precision beside the pose buffer.
#[derive(Clone, Debug)]
pub struct Solver<T: Real, const N: usize = DEFAULT_CAPACITY, Z = UnknownZeros<T>> {
    settings: SolverSettings<T>,
    placer: Placer<T>,
    phase: Phase,
    next: usize,
    weighing: Weighing<T>,
    linear: PivotFit<T>,
    pivot: Pivot<T>,
    zeros: Z,
    sum: PassSum<T>,
    /// Of the last pass.
    misfits: Misfits<T>,
    noise_mm: T,
    selected_before: usize,
    passes_in_weighing: u8,
    /// Misfit beyond which the pass places a pose anew. Infinite where it places none.
    doubt: T,
    /// Has a pose among vanishing residuals been placed anew?
    doubted: bool,
    blame: Blame<T>,
    /// Filled as it becomes known.
    result: Identified<T>,
    /// Last: what stands before it is within short reach.
    placements: Vec<Placement<T>, N>,
}

impl<T: Real, const N: usize, Z: Zeros<T>> Solver<T, N, Z> {
    /// A solver for `rig`, at its beginning.
    pub fn new(rig: &Rig<T>, settings: SolverSettings<T>) -> Self {
        let placer = Placer::new(rig);
        let settings = settings.sound();
        let noise_mm = match settings.noise {
            Noise::Known(noise) => noise,
            Noise::EstimatedUpTo(_) => rig.length_noise_mm(),
        };
        Self {
            // The linear fit overwrites it. With a constant here the compiler would build all of it on the stack first.
            pivot: Pivot::from_parameters(rig.nominal(), &placer.points),
            placer,
            placements: Vec::new(),
            phase: Phase::Place,
            next: 0,
            weighing: Weighing::Equal,
            linear: PivotFit::default(),
            zeros: Z::new(settings.zero_prior_mm),
            sum: PassSum::new(),
            misfits: Misfits::none(),
            noise_mm,
            selected_before: 0,
            passes_in_weighing: 0,
            doubt: T::zero(),
            doubted: false,
            blame: Blame::new(),
            result: Identified::empty(*rig.nominal()),
            settings,
        }
    }

    /// Back to the beginning, for another set of poses. In place: the solver is too large to be built on a small stack
    /// twice.
    pub fn restart(&mut self) {
        self.placements.clear();
        self.phase = Phase::Place;
        self.next = 0;
        self.linear = PivotFit::default();
        self.zeros = Z::new(self.settings.zero_prior_mm);
        self.sum = PassSum::new();
        if let Noise::EstimatedUpTo(_) = self.settings.noise {
            self.noise_mm = self.placer.rig_noise_mm;
        }
        self.selected_before = 0;
        self.passes_in_weighing = 0;
        self.doubted = false;
        self.result.deviations_mm.clear();
    }

    /// Runs to the end.
    ///
    /// # Errors
    /// The [`Refusal`] that names the cause.
    pub fn run(mut self, poses: &[CableLengths<T>]) -> Result<Identified<T>, Refusal> {
        loop {
            match self.advance(poses) {
                Progress::Working => {}
                Progress::Identified(identified) => return Ok(identified.clone()),
                Progress::Refused(refusal) => return Err(refusal),
            }
        }
    }

    /// One slice of work. `poses` must be the same in every call, at most `N` of them (more are not looked at).
    pub fn advance(&mut self, poses: &[CableLengths<T>]) -> Progress<&Identified<T>> {
        let poses = poses.get(..N).unwrap_or(poses);
        if poses.len() < FEWEST_POSES {
            return Progress::Refused(Refusal::TooFewPoses { poses: poses.len() as u16 });
        }
        match (&self.phase, poses.get(self.next)) {
            (Phase::Place, Some(lengths)) => self.place(lengths),
            (Phase::Place, None) => self.finish_placing(),
            (Phase::Pass, Some(lengths)) => self.weigh(lengths),
            (Phase::Pass, None) => self.finish_pass(),
            (Phase::Check { last }, Some(lengths)) if self.next < *last => self.check_without(lengths),
            (Phase::Check { .. }, _) => self.phase = Phase::Blame,
            (Phase::Blame, _) => {
                let arm = self.placer.arm(&self.pivot);
                self.blame.advance(&mut self.result, &arm, self.placer.rig_noise_mm, &self.zeros, poses);
            }
            (Phase::Refused(_), _) => {}
        }
        match &self.phase {
            Phase::Refused(refusal) => Progress::Refused(*refusal),
            Phase::Blame if self.blame.is_done(&self.result) => Progress::Identified(&self.result),
            _ => Progress::Working,
        }
    }

    /// Steps taken so far.
    pub fn iterations(&self) -> u8 {
        self.result.deviations_mm.len() as u8
    }

    #[inline(never)]
    fn place(&mut self, lengths: &CableLengths<T>) {
        // Never full: `advance` looks at no more than N poses.
        let _ = self.placements.push(Placement::unplaced());
        let Some(placement) = self.placements.last_mut() else { return };
        // By reference: taken out of the result the pose would be copied.
        match &self.placer.octahedron.solve(lengths) {
            Ok(pose) => {
                self.linear.add(pose);
                placement.place(&nearest_attitude(&pose.rotation));
            }
            Err(OctahedronError::DoesNotClose) => {}
            Err(OctahedronError::Length(error)) => placement.set_broken(error.cable),
        }
        self.next += 1;
    }

    /// The linear fit of the pivot.
    #[inline(never)]
    fn finish_placing(&mut self) {
        if self.linear.rotations().poses() < T::of_integer(FEWEST_POSES as i32) {
            let first = self.placements.iter().enumerate().find(|(_, p)| !p.is_placed());
            let (pose, broken) = first.map_or((0, 0), |(pose, p)| (pose as u16, p.broken_cables));
            return self.refuse_placing(pose, broken);
        }
        match self.linear.solve(&mut self.pivot) {
            Ok(()) => self.begin_weighing(Weighing::Equal),
            Err(Singular) => self.refuse_no_inverse(),
        }
    }

    /// Refuses for a pose without a rotation.
    fn refuse_placing(&mut self, pose: u16, broken_cables: u8) {
        if broken_cables == 0 {
            return self.refuse(Refusal::PlatformDoesNotClose { pose });
        }
        let cable = cable_number(broken_cables.trailing_zeros() as usize);
        self.refuse(Refusal::BadLength { pose, cable, fault: LengthFault::BreaksTriangle });
    }

    /// There will be no result.
    fn refuse(&mut self, refusal: Refusal) {
        self.phase = Phase::Refused(refusal);
    }

    /// Weighs the poses by misfit over this scale from now on, or over the last one.
    fn anneal(&mut self, scale: T) {
        self.begin_weighing(Weighing::Annealed(scale.max(T::of(judgement::ANNEALED_SCALE))));
    }

    /// Weighs the poses in another way from now on.
    #[inline(never)]
    fn begin_weighing(&mut self, weighing: Weighing<T>) {
        self.weighing = weighing;
        self.passes_in_weighing = 0;
        self.begin_pass();
    }

    #[inline(never)]
    fn begin_pass(&mut self) {
        self.passes_in_weighing += 1;
        self.phase = Phase::Pass;
        self.next = 0;
        self.doubt = match self.weighing {
            // A pose that fits nothing may stand on the wrong side of the fold: the known centre places it.
            Weighing::Selected if self.passes_in_weighing <= 2 => T::of(judgement::HOPELESS_MISFIT),
            _ => T::of(f64::INFINITY),
        };
        match self.weighing {
            Weighing::Wander { .. } => self.zeros.hold(),
            _ => self.zeros.begin_pass(self.noise_mm),
        }
        self.sum = PassSum::new();
    }

    /// Adds one pose to the pass.
    #[inline(never)]
    fn weigh(&mut self, lengths: &CableLengths<T>) {
        let lengths = self.zeros.corrected(lengths);
        if let Some(placement) = self.placements.get_mut(self.next) {
            if placement.misfit > self.doubt {
                self.placer.replace(placement, &self.pivot, &lengths);
            }
            let at = (&self.placer.points, &self.pivot);
            self.sum.add(placement, &mut self.zeros, at, &lengths, self.noise_mm, &self.weighing);
        }
        self.next += 1;
    }

    /// Takes the step of a pass and decides what comes next.
    #[inline(never)]
    fn finish_pass(&mut self) {
        // By reference: taken out of the result the step would be copied.
        let Ok(step) = &self.zeros.step(&self.sum.equations) else { return self.refuse_step() };
        self.pivot.move_by(&step.pivot);
        self.sum.squares_left_mm2 = step.squares_left_mm2;
        self.misfits = Misfits::of(&self.placements);
        self.result.deviation_mm = deviation(step.squares_left_mm2, self.sum.poses);
        if self.result.deviations_mm.push(self.result.deviation_mm).is_err() {
            return self.refuse(Refusal::IterationCap);
        }
        let settled = step.largest_mm <= self.settings.tolerance_mm;
        match self.weighing {
            Weighing::Equal => {
                if settled && self.sum.poses == self.placements.len() && self.residuals_are_noise() {
                    return self.accept_unless_beside();
                }
                // A gross error would drag the next passes with it where its leverage is large.
                if settled || self.stands_out() || self.passes_in_weighing > self.most_equal_passes() {
                    let scale = self.first_scale();
                    return self.anneal(scale);
                }
            }
            Weighing::Annealed(scale) => {
                // The median of a handful says nothing that the first estimate did not.
                let shrinks = self.placements.len() >= judgement::POSES_TO_ESTIMATE && self.noise_shrinks();
                if !shrinks && scale <= T::of(judgement::ANNEALED_SCALE) {
                    return self.begin_weighing(Weighing::Selected);
                }
                if !shrinks {
                    return self.anneal(scale * T::of(judgement::ANNEALING));
                }
            }
            Weighing::Selected => {
                let stable = self.sum.poses == self.selected_before && settled;
                self.selected_before = self.sum.poses;
                if stable {
                    return self.judge_selection();
                }
                if self.passes_in_weighing > judgement::SELECTED_PASSES {
                    return self.look_for_wander();
                }
            }
            Weighing::Wander { rejected } if self.passes_in_weighing >= judgement::WANDER_PASSES => {
                return self.refuse_wander(rejected);
            }
            Weighing::Wander { .. } | Weighing::Without => {}
        }
        self.begin_pass();
    }

    /// The equations of a pass have no solution.
    #[inline(never)]
    fn refuse_step(&mut self) {
        match self.weighing {
            Weighing::Equal => self.refuse_no_inverse(),
            Weighing::Wander { rejected } => self.refuse_outliers(rejected),
            // Hardly any pose agrees with another.
            _ => self.look_for_wander(),
        }
    }

    /// Unknown zeros of centimetres take more steps to find than noise does.
    fn most_equal_passes(&self) -> u8 {
        if self.zeros.take_part() { judgement::EQUAL_PASSES_WITH_ZEROS } else { judgement::EQUAL_PASSES }
    }
}
