//! What an identification ends with: a centre that can be trusted, or a reason why there is none.

use super::normal_equations::{PACKED, UNKNOWNS};
use crate::calls::root;
use crate::kinematics::LengthFault;
use crate::rig::{CABLES, Parameters};
use crate::scalar::Real;
use heapless::Vec;

/// Most iterations of any solver; the deviations of all of them are kept.
pub const MOST_ITERATIONS: usize = 30;

/// Most poses that can be left out: a fifth of the default buffer.
pub const MOST_REJECTED: usize = 25;

/// Why an iteration ended well.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Termination {
    /// δE fell below ε: the residuals vanish (noise-free lengths).
    DeviationBelowTolerance = 1,
    /// The last step moved no parameter by as much as the tolerance: what is left of δE is noise.
    Settled = 2,
}

/// A pose that was left out, and the cables that are to blame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Rejected {
    /// Pose, from 0.
    pub pose: u16,
    /// Bit k set: cable k + 1. Two bits when two cables look alike or were exchanged; none when no single cable
    /// explains the pose.
    pub cables: u8,
}

impl Rejected {
    /// The cables to blame, 1 to 6.
    pub fn cable_numbers(self) -> impl Iterator<Item = u8> {
        (1..=6).filter(move |cable| self.cables & (1 << (cable - 1)) != 0)
    }
}

/// An identified joint centre.
#[derive(Clone, Debug, PartialEq)]
pub struct Identified<T> {
    /// Joint centre and radii, mm.
    pub parameters: Parameters<T>,
    /// Covariance of x, y, z, p1, p2, p3, mm²: lower triangle, row by row.
    pub covariance_mm2: [T; PACKED],
    /// Standard deviation (1σ) of the noise of a cable length, mm. The covariance is computed with it; wider where an
    /// estimated noise beyond the rig's may hide a bad reading.
    pub noise_mm: T,
    /// What is left of the residuals over the poses used, root mean square of three per pose, mm. The paper's
    /// iteration gives δE of the platform edges (Eq. 17, as the root mean square that its text describes); the
    /// start-free solver gives the same figure in terms of cable lengths.
    pub deviation_mm: T,
    /// The deviation before each step and after the last (the paper's iteration), after each step (start-free), mm.
    pub deviations_mm: Vec<T, { MOST_ITERATIONS + 1 }>,
    /// Least-squares steps taken.
    pub iterations: u8,
    /// Why the iteration ended.
    pub termination: Termination,
    /// Poses given.
    pub poses: u16,
    /// Poses left out, each with the cables to blame.
    pub rejected: Vec<Rejected, MOST_REJECTED>,
    /// How far the poses are from turning about one common axis, rad (see
    /// [`Sway`](super::observability::Sway)). Infinite for the paper's iteration, which does not look.
    pub sway_rad: T,
    /// Zero error of each encoder, mm: what its length reads too much. 0 when the zeros are known.
    pub zeros_mm: [T; CABLES],
    /// 1σ of the zero errors, mm. 0 when the zeros are known.
    pub zero_sigmas_mm: [T; CABLES],
}

impl<T: Real> Identified<T> {
    /// A result to be filled in, where it stays: the solver's largest value is never moved.
    pub(crate) fn empty(nominal: Parameters<T>) -> Self {
        let zero = T::zero();
        Self {
            parameters: nominal,
            covariance_mm2: [zero; PACKED],
            noise_mm: zero,
            deviation_mm: zero,
            deviations_mm: Vec::new(),
            iterations: 0,
            termination: Termination::Settled,
            poses: 0,
            rejected: Vec::new(),
            sway_rad: zero,
            zeros_mm: [zero; CABLES],
            zero_sigmas_mm: [zero; CABLES],
        }
    }

    /// 1σ of x, y, z, p1, p2, p3, mm.
    pub fn sigma_mm(&self) -> [T; UNKNOWNS] {
        super::uncertainty::sigmas(&self.covariance_mm2)
    }

    /// The direction in x, y, z, p1, p2, p3 that is known worst, a unit vector, and its 1σ, mm.
    pub fn weak_direction(&self) -> ([T; UNKNOWNS], T) {
        super::uncertainty::worst_direction(&self.covariance_mm2)
    }

    /// 1σ of the centre in its worst direction in {B}, mm, and that direction.
    pub fn worst_centre_sigma_mm(&self) -> (T, [T; 3]) {
        super::uncertainty::worst_centre_direction(&self.covariance_mm2)
    }
}

/// Why no centre was identified. Codes are sent over CAN: they are never renumbered.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Refusal {
    /// Fewer than three poses. Two never suffice: the centre is free along the axis of their relative rotation.
    TooFewPoses {
        /// Poses given.
        poses: u16,
    },
    /// A cable length of a pose cannot be.
    BadLength {
        /// Pose, from 0.
        pose: u16,
        /// Cable, 1 to 6.
        cable: u8,
        /// What is wrong with it.
        fault: LengthFault,
    },
    /// A tetrahedron does not close at the current estimate: the start is too far off, or a length is wrong.
    NotClosing {
        /// Pose, from 0.
        pose: u16,
        /// End-point, 1 to 3.
        end_point: u8,
        /// Steps taken before.
        iteration: u8,
    },
    /// The normal matrix has no inverse: the poses do not determine the centre.
    Singular,
    /// The iteration cap was reached before the deviation or the step fell below the tolerance.
    IterationCap,
    /// Too few poses whose six lengths fit the platform between the cables at all.
    PlatformDoesNotClose {
        /// The first such pose, from 0.
        pose: u16,
    },
    /// All poses turn about one axis; the centre can slide along it without any length changing.
    OneAxis {
        /// The common axis in {B}, a unit vector.
        axis: [f32; 3],
        /// Root-mean-square angle by which the poses move that axis, rad.
        sway_rad: f32,
    },
    /// All poses are alike: they differ by so little that no direction is determined.
    TooAlike {
        /// Root-mean-square angle between the poses, rad.
        spread_rad: f32,
    },
    /// The centre's error bar is wider than its limit.
    Weak {
        /// The centre's worst direction in {B}, a unit vector.
        direction: [f32; 3],
        /// 1σ in that direction, mm.
        sigma_mm: f32,
    },
    /// More than a fifth of the poses contradict the others.
    TooManyOutliers {
        /// Poses that would have to be left out.
        rejected: u16,
        /// Poses given.
        poses: u16,
    },
    /// The poses are sound one by one, but have no common centre: it wanders, or the strap slips.
    NotABall {
        /// Root-mean-square wander of the centre along one axis, mm.
        wander_mm: f32,
    },
    /// The centre hangs on a homing error that the poses do not determine.
    ZeroNotDetermined {
        /// Cable whose zero is known worst, 1 to 6.
        cable: u8,
        /// 1σ of its zero, mm.
        sigma_mm: f32,
    },
    /// The centre hangs on one pose: were that pose wrong, the others could not contradict it. Always so with three.
    HangsOnOnePose {
        /// Pose, from 0.
        pose: u16,
    },
}

impl Refusal {
    /// The code on the wire.
    pub const fn code(&self) -> u8 {
        match self {
            Self::TooFewPoses { .. } => 1,
            Self::BadLength { .. } => 2,
            Self::NotClosing { .. } => 3,
            Self::Singular => 4,
            Self::IterationCap => 5,
            Self::PlatformDoesNotClose { .. } => 6,
            Self::OneAxis { .. } => 7,
            Self::TooAlike { .. } => 8,
            Self::Weak { .. } => 9,
            Self::TooManyOutliers { .. } => 10,
            Self::NotABall { .. } => 11,
            Self::ZeroNotDetermined { .. } => 12,
            Self::HangsOnOnePose { .. } => 13,
        }
    }

    /// The reason in words.
    pub const fn text(&self) -> &'static str {
        match self {
            Self::TooFewPoses { .. } => "fewer than three poses",
            Self::BadLength { fault, .. } => fault.text(),
            Self::NotClosing { .. } => "a tetrahedron does not close at the estimated centre",
            Self::Singular => "the poses do not determine the centre (singular normal matrix)",
            Self::IterationCap => "the iteration cap was reached",
            Self::PlatformDoesNotClose { .. } => "the platform does not fit between the cables",
            Self::OneAxis { .. } => "degenerate: all poses turn about one axis",
            Self::TooAlike { .. } => "degenerate: all poses are alike",
            Self::Weak { .. } => "weak: the centre's error bar is wider than its limit",
            Self::TooManyOutliers { .. } => "more than a fifth of the poses contradict the others",
            Self::NotABall { .. } => "the joint centre wanders: not a ball joint",
            Self::HangsOnOnePose { .. } => "weak: the centre hangs on one pose that no other can contradict",
            Self::ZeroNotDetermined { .. } => {
                "weak: the centre hangs on an encoder zero that the poses do not determine"
            }
        }
    }
}

/// Where a solver stands after a slice of work. `R`: the result, or a reference to it where it is kept.
#[derive(Clone, Debug, PartialEq)]
pub enum Progress<R> {
    /// More slices are wanted.
    Working,
    /// The centre is identified.
    Identified(R),
    /// There is no result, and why.
    Refused(Refusal),
}

/// δE (Eq. 17): root mean square of the residuals of `poses` poses, mm, from their sum of squares, mm².
#[inline(never)]
pub(crate) fn deviation<T: Real>(squares_mm2: T, poses: usize) -> T {
    root(squares_mm2 / T::of_integer(3 * poses as i32))
}
