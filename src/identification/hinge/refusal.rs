//! Why no hinge was identified.

use crate::kinematics::LengthFault;

/// What of a hinge is known too poorly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HingePart {
    /// The direction of the axis in the base.
    Axis,
    /// The place of the axis in the base, across it.
    Place,
    /// The direction of the axis in the platform.
    AxisInPlatform,
    /// The place of the axis in the platform, across it.
    PlaceInPlatform,
    /// Where the two bodies stand along the axis.
    Along,
}

/// Why no hinge was identified.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HingeRefusal {
    /// Too few poses to contradict a wrong one.
    TooFewPoses {
        /// Poses given.
        poses: u32,
        /// Poses wanted.
        wanted: u32,
    },
    /// A cable length of a pose is impossible.
    BadLength {
        /// Pose, from 0.
        pose: u32,
        /// Cable, from 1.
        cable: u8,
        /// The fault.
        fault: LengthFault,
    },
    /// So few cables do not determine a hinge, however many poses there are, unless a drawing says the rest.
    TooFewCables {
        /// Cables of the rig.
        cables: u8,
        /// How many of the nine unknowns they determine.
        determined: u8,
    },
    /// The joint hardly bends in the poses.
    TooLittleFlexion {
        /// From the smallest to the largest angle, rad.
        range_rad: f32,
    },
    /// Two hinges explain the poses.
    TwoAxesFit {
        /// Angle between the two axes in the base, rad.
        angle_rad: f32,
        /// Distance between the two places of the axis next to the middle of the base, mm.
        distance_mm: f32,
    },
    /// A standard deviation is larger than its limit.
    Weak {
        /// Of what.
        part: HingePart,
        /// 1σ in the worst direction, rad or mm.
        sigma: f32,
    },
    /// More than a fifth of the poses contradict the others.
    TooManyOutliers {
        /// Poses that would have to be left out.
        rejected: u32,
        /// Poses given.
        poses: u32,
    },
    /// The joint is no hinge: it turns about a second axis as well.
    SecondAxis {
        /// Direction of that axis in the platform, a unit vector.
        axis_in_platform: [f32; 3],
        /// Standard deviation of the angle about it, rad.
        size_rad: f32,
    },
    /// The joint is no hinge, and a second axis does not explain it either.
    NotAHinge {
        /// Root mean square of the residuals, mm.
        residual_mm: f32,
    },
}

impl HingeRefusal {
    /// The reason in words.
    pub const fn text(&self) -> &'static str {
        match self {
            Self::TooFewPoses { .. } => "too few poses: nothing could contradict a wrong one",
            Self::BadLength { fault, .. } => fault.text(),
            Self::TooFewCables { .. } => "so few cables do not determine a hinge without a drawing",
            Self::TooLittleFlexion { .. } => "too little flexion: the joint hardly bends in these poses",
            Self::TwoAxesFit { .. } => "two different axes fit the poses",
            Self::Weak { part, .. } => match part {
                HingePart::Axis => "weak: the direction of the axis is known too poorly",
                HingePart::Place => "weak: the place of the axis is known too poorly",
                HingePart::AxisInPlatform => "weak: the direction of the axis in the platform is known too poorly",
                HingePart::PlaceInPlatform => "weak: the place of the axis in the platform is known too poorly",
                HingePart::Along => "weak: where the platform stands along the axis is known too poorly",
            },
            Self::TooManyOutliers { .. } => "more than a fifth of the poses contradict the others",
            Self::SecondAxis { .. } => "the joint is no hinge: it turns about a second axis",
            Self::NotAHinge { .. } => "the joint is no hinge",
        }
    }
}
