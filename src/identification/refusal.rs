//! Why no centre was identified.

use super::joint::MissingMotion;
use crate::kinematics::LengthFault;

/// Why no centre was identified. Codes are sent over CAN: they are never renumbered.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Refusal {
    /// Fewer than three poses. Two never suffice: the centre is free along the axis of their relative rotation.
    TooFewPoses {
        /// Poses given.
        poses: u32,
    },
    /// A cable length of a pose is impossible.
    BadLength {
        /// Pose, from 0.
        pose: u32,
        /// Cable, 1 to 6.
        cable: u8,
        /// The fault.
        fault: LengthFault,
    },
    /// A tetrahedron does not close at the current estimate: the start is too far off, or a length is wrong.
    NotClosing {
        /// Pose, from 0.
        pose: u32,
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
        pose: u32,
    },
    /// All poses turn about one axis; the centre can slide along it without any length changing.
    OneAxis {
        /// The common axis in {B}, a unit vector.
        axis: [f32; 3],
        /// Root-mean-square angle by which the poses move that axis, rad.
        excitation_rad: f32,
    },
    /// All poses are alike: they differ by so little that no direction is determined.
    TooAlike {
        /// Root-mean-square angle between the poses, rad.
        spread_rad: f32,
    },
    /// The centre's standard deviation is larger than its limit.
    Weak {
        /// The centre's worst direction in {B}, a unit vector.
        direction: [f32; 3],
        /// 1σ in that direction, mm.
        sigma_mm: f32,
    },
    /// More than a fifth of the poses contradict the others.
    TooManyOutliers {
        /// Poses that would have to be left out.
        rejected: u32,
        /// Poses given.
        poses: u32,
    },
    /// Each pose is consistent, but they have no common centre: the joint is no ball, or the strap slips.
    CentreNotFixed {
        /// Root-mean-square migration of the centre along one axis, mm.
        migration_mm: f32,
    },
    /// The centre depends on an encoder offset that the poses do not determine.
    OffsetNotDetermined {
        /// Cable with the largest 1σ of its offset, 1 to 6.
        cable: u8,
        /// 1σ of its offset, mm.
        sigma_mm: f32,
    },
    /// Too few poses for a joint centre that moves with the arm: it has 24 unknowns.
    TooFewForMovingCentre {
        /// Poses given.
        poses: u32,
    },
    /// The arm moves too little to determine how the joint centre moves with it.
    MissingMotion {
        /// What is missing.
        missing: MissingMotion,
        /// Standard deviation of that motion over the poses, rad.
        spread_rad: f32,
        /// For [`MissingMotion::SecondPlane`] the direction in {B} in which the arm does not tilt, a unit vector.
        direction: [f32; 3],
    },
    /// Something slipped between two poses: the poses from one on belong to another joint centre.
    SlippedMidway {
        /// The first pose after the slip, from 0.
        pose: u32,
        /// How far the centre moved, mm.
        size_mm: f32,
        /// The platform (cuff) slipped on the arm; otherwise the base (strap) on the body.
        is_cuff: bool,
    },
    /// Neither a ball nor a centre that moves with the arm explains the poses.
    NotExplained {
        /// Root-mean-square residual of the poses' own centres in its worst direction, mm.
        residual_mm: f32,
    },
    /// The poses of the held phase have no common centre: the shoulder blade was not held.
    NotHeld {
        /// Scatter of the held poses' centres along an axis, mm.
        scatter_mm: f32,
    },
    /// The held poses belong to another wearing: their joint centre in the platform contradicts that of the free poses.
    HeldOfAnotherWearing {
        /// Distance between the two, mm.
        distance_mm: f32,
    },
    /// A ball on a machine that is not as stated explains the poses as well as a centre that moves.
    MachineNotAsStated,
    /// The centre depends on one pose alone: were that pose wrong, the others could not contradict it (no redundancy).
    /// Always so with three.
    NotRedundant {
        /// Pose, from 0.
        pose: u32,
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
            Self::CentreNotFixed { .. } => 11,
            Self::OffsetNotDetermined { .. } => 12,
            Self::NotRedundant { .. } => 13,
            Self::TooFewForMovingCentre { .. } => 14,
            Self::MissingMotion { .. } => 15,
            Self::SlippedMidway { .. } => 16,
            Self::NotExplained { .. } => 17,
            Self::NotHeld { .. } => 18,
            Self::HeldOfAnotherWearing { .. } => 19,
            Self::MachineNotAsStated => 20,
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
            Self::Weak { .. } => "weak: the centre's standard deviation is larger than its limit",
            Self::TooManyOutliers { .. } => "more than a fifth of the poses contradict the others",
            Self::CentreNotFixed { .. } => "the joint centre is not fixed: not a ball joint",
            Self::NotRedundant { .. } => "weak: the centre depends on one pose that no other can contradict",
            Self::TooFewForMovingCentre { .. } => "the joint centre moves, and the poses are too few to say how",
            Self::MissingMotion { missing, .. } => missing.text(),
            Self::SlippedMidway { is_cuff: true, .. } => "the cuff slipped on the arm between two poses",
            Self::SlippedMidway { is_cuff: false, .. } => "the base slipped on the body between two poses",
            Self::NotExplained { .. } => "neither a ball nor a centre that moves with the arm explains the poses",
            Self::NotHeld { .. } => "the shoulder blade was not held in the held poses",
            Self::HeldOfAnotherWearing { .. } => "the held poses belong to another wearing",
            Self::MachineNotAsStated => "a machine that is not as stated explains the poses as well as a moving centre",
            Self::OffsetNotDetermined { .. } => {
                "weak: the centre depends on an encoder offset that the poses do not determine"
            }
        }
    }
}
