//! What an identification ends with: a centre that can be trusted, or a reason why there is none.

use crate::kinematics::LengthFault;
use crate::rig::Parameters;
use crate::scalar::Real;
use heapless::Vec;

/// Most iterations of any solver; the deviations of all of them are kept.
pub const MOST_ITERATIONS: usize = 30;

/// Why an iteration ended well.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Termination {
    /// δE fell below ε: the residuals vanish (noise-free lengths).
    DeviationBelowTolerance = 1,
    /// The last step moved no parameter by as much as ε: what is left of δE is noise.
    Settled = 2,
}

/// An identified joint centre.
#[derive(Clone, Debug, PartialEq)]
pub struct Identified<T> {
    /// Joint centre and radii, mm.
    pub parameters: Parameters<T>,
    /// δE over the poses used (Eq. 17 as the root mean square that its text describes), mm.
    pub deviation_mm: T,
    /// δE before each step and after the last, mm.
    pub deviations_mm: Vec<T, { MOST_ITERATIONS + 1 }>,
    /// Least-squares steps taken.
    pub iterations: u8,
    /// Why the iteration ended.
    pub termination: Termination,
}

/// Why no centre was identified. Codes are sent over CAN: they are never renumbered.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Refusal {
    /// Fewer than three poses. Two never suffice: the centre is free along the axis of their relative rotation.
    TooFewPoses {
        /// Poses given.
        poses: u8,
    },
    /// A cable length of a pose cannot be.
    BadLength {
        /// Pose, from 0.
        pose: u8,
        /// Cable, 1 to 6.
        cable: u8,
        /// What is wrong with it.
        fault: LengthFault,
    },
    /// A tetrahedron does not close at the current estimate: the start is too far off, or a length is wrong.
    NotClosing {
        /// Pose, from 0.
        pose: u8,
        /// End-point, 1 to 3.
        end_point: u8,
        /// Steps taken before.
        iteration: u8,
    },
    /// The normal matrix has no inverse: the poses do not determine the centre.
    Singular,
    /// The iteration cap was reached before the deviation or the step fell below the tolerance.
    IterationCap,
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
        }
    }
}

/// Where a solver stands after a slice of work.
#[derive(Clone, Debug, PartialEq)]
// The outcome is handed over once, by value, at the end of thousands of slices; boxing it would need a heap.
#[allow(clippy::large_enum_variant)]
pub enum Progress<T> {
    /// More slices are wanted.
    Working,
    /// The centre is identified.
    Identified(Identified<T>),
    /// There is no result, and why.
    Refused(Refusal),
}

/// δE (Eq. 17): root mean square of the residuals of `poses` poses, mm, from their sum of squares, mm².
pub(crate) fn deviation<T: Real>(squares_mm2: T, poses: usize) -> T {
    (squares_mm2 / T::of_integer(3 * poses as i32)).root()
}
