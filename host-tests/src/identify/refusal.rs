//! A refusal with its figures, in the words of the report.

use glenoid::identification::Refusal;
use serde::Serialize;

/// What is known of a refusal. Poses are rows of the log from 0; directions are unit vectors in {B}.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum RefusalDetail {
    /// See [`Refusal::TooFewPoses`].
    TooFewPoses {
        /// Poses given.
        poses: u32,
    },
    /// See [`Refusal::BadLength`].
    BadLength {
        /// Row of the log.
        pose: usize,
        /// Cable, 1 to 6.
        cable: u8,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// See [`Refusal::NotClosing`].
    NotClosing {
        /// Row of the log.
        pose: usize,
        /// End-point, 1 to 3.
        end_point: u8,
        /// Steps taken before.
        iteration: u8,
    },
    /// See [`Refusal::Singular`].
    Singular,
    /// See [`Refusal::IterationCap`].
    IterationCap,
    /// See [`Refusal::PlatformDoesNotClose`].
    PlatformDoesNotClose {
        /// Row of the log, the first of them.
        pose: usize,
    },
    /// See [`Refusal::OneAxis`].
    OneAxis {
        /// The common axis.
        axis: [f64; 3],
        /// Root-mean-square angle by which the poses move it, degrees.
        sway_deg: f64,
    },
    /// See [`Refusal::TooAlike`].
    TooAlike {
        /// Root-mean-square angle between the poses, degrees.
        spread_deg: f64,
    },
    /// See [`Refusal::Weak`].
    Weak {
        /// The centre's worst direction.
        direction: [f64; 3],
        /// 1σ in that direction, mm.
        sigma_mm: f64,
    },
    /// See [`Refusal::TooManyOutliers`].
    TooManyOutliers {
        /// Poses that would have to be left out.
        rejected: u32,
        /// Poses given.
        poses: u32,
    },
    /// See [`Refusal::CentreNotFixed`].
    #[serde(rename = "not_a_ball")]
    CentreNotFixed {
        /// Root-mean-square migration of the centre along one axis, mm.
        #[serde(rename = "wander_mm")]
        migration_mm: f64,
    },
    /// See [`Refusal::OffsetNotDetermined`].
    ZeroNotDetermined {
        /// Cable whose zero is known worst, 1 to 6.
        cable: u8,
        /// 1σ of its zero, mm.
        sigma_mm: f64,
    },
    /// See [`Refusal::TooFewForMovingCentre`].
    TooFewForMovingCentre {
        /// Poses given.
        poses: u32,
    },
    /// See [`Refusal::MissingMotion`].
    MissingMotion {
        /// What is missing: 1 tilt, 2 tilt out of one plane, 3 torsion.
        missing: u8,
        /// Standard deviation of what there is of it, degrees.
        spread_deg: f64,
        /// The direction in which the arm does not tilt.
        direction: [f64; 3],
    },
    /// See [`Refusal::SlippedMidway`].
    SlippedMidway {
        /// Row of the log, the first after the slip.
        pose: usize,
        /// How far the centre moved, mm.
        size_mm: f64,
        /// The cuff slipped on the arm; otherwise the base on the body.
        cuff: bool,
    },
    /// See [`Refusal::NotExplained`].
    NotExplained {
        /// Residual of the poses' own centres in its worst direction, mm.
        residual_mm: f64,
    },
    /// See [`Refusal::NotHeld`].
    NotHeld {
        /// Scatter of the held poses' centres along an axis, mm.
        scatter_mm: f64,
    },
    /// See [`Refusal::HeldOfAnotherWearing`].
    HeldOfAnotherWearing {
        /// Distance between the two centres in the platform, mm.
        distance_mm: f64,
    },
    /// See [`Refusal::MachineNotAsStated`].
    MachineNotAsStated,
    /// See [`Refusal::NotRedundant`].
    HangsOnOnePose {
        /// Row of the log.
        pose: usize,
    },
}

impl RefusalDetail {
    /// The figures of a refusal; `row` turns a pose into its row of the log.
    pub fn of(refusal: &Refusal, row: impl Fn(u32) -> usize) -> Self {
        let degrees = |angle_rad: f32| f64::from(angle_rad).to_degrees();
        match *refusal {
            Refusal::TooFewPoses { poses } => Self::TooFewPoses { poses },
            Refusal::BadLength { pose, cable, fault } => {
                Self::BadLength { pose: row(pose), cable, problem: fault.text() }
            }
            Refusal::NotClosing { pose, end_point, iteration } => {
                Self::NotClosing { pose: row(pose), end_point, iteration }
            }
            Refusal::Singular => Self::Singular,
            Refusal::IterationCap => Self::IterationCap,
            Refusal::PlatformDoesNotClose { pose } => Self::PlatformDoesNotClose { pose: row(pose) },
            Refusal::OneAxis { axis, excitation_rad } => {
                Self::OneAxis { axis: axis.map(f64::from), sway_deg: degrees(excitation_rad) }
            }
            Refusal::TooAlike { spread_rad } => Self::TooAlike { spread_deg: degrees(spread_rad) },
            Refusal::Weak { direction, sigma_mm } => {
                Self::Weak { direction: direction.map(f64::from), sigma_mm: sigma_mm.into() }
            }
            Refusal::TooManyOutliers { rejected, poses } => Self::TooManyOutliers { rejected, poses },
            Refusal::OffsetNotDetermined { cable, sigma_mm } => {
                Self::ZeroNotDetermined { cable, sigma_mm: sigma_mm.into() }
            }
            Refusal::TooFewForMovingCentre { poses } => Self::TooFewForMovingCentre { poses },
            Refusal::MissingMotion { missing, spread_rad, direction } => Self::MissingMotion {
                missing: missing as u8,
                spread_deg: degrees(spread_rad),
                direction: direction.map(f64::from),
            },
            Refusal::SlippedMidway { pose, size_mm, is_cuff } => {
                Self::SlippedMidway { pose: row(pose), size_mm: size_mm.into(), cuff: is_cuff }
            }
            Refusal::NotExplained { residual_mm } => Self::NotExplained { residual_mm: residual_mm.into() },
            Refusal::NotHeld { scatter_mm } => Self::NotHeld { scatter_mm: scatter_mm.into() },
            Refusal::HeldOfAnotherWearing { distance_mm } => {
                Self::HeldOfAnotherWearing { distance_mm: distance_mm.into() }
            }
            Refusal::MachineNotAsStated => Self::MachineNotAsStated,
            Refusal::NotRedundant { pose } => Self::HangsOnOnePose { pose: row(pose) },
            Refusal::CentreNotFixed { migration_mm } => Self::CentreNotFixed { migration_mm: migration_mm.into() },
        }
    }
}
