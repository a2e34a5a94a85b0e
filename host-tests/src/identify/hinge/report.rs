//! What `cargo identify --json` prints for a hinge: one object, its keys always the same and in the same order.

use super::Solved;
use crate::identify::report::{Precision, RejectedCable, Status};
use crate::identify::{MAX_TIMES_EXPECTED_NOISE, Request};
use glenoid::identification::hinge::{HingePart, HingeRefusal, HingeRig, IdentifiedHinge};
use glenoid::identification::uncertainty::worst_direction_of_point;
use glenoid::scalar::Real;
use nalgebra::Vector3;
use serde::Serialize;

/// The outcome. What is not known is `null`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HingeReport {
    /// How it ended.
    pub status: Status,
    /// Why it was refused.
    pub reason: Option<&'static str>,
    /// Always `hinge`.
    pub joint: &'static str,
    /// Direction of the axis in {B}, a unit vector.
    pub axis: Option<[f64; 3]>,
    /// Its 1σ in the worst direction, degrees.
    pub axis_sigma_deg: Option<f64>,
    /// The axis' point next to the middle of the base's points, in {B}, mm.
    pub point_mm: Option<[f64; 3]>,
    /// Its 1σ across the axis in the worst direction, mm.
    pub point_sigma_mm: Option<f64>,
    /// Direction of the axis in the platform.
    pub axis_in_platform: Option<[f64; 3]>,
    /// Its 1σ in the worst direction, degrees.
    pub axis_in_platform_sigma_deg: Option<f64>,
    /// The platform's point that coincides with `point_mm`, mm.
    pub point_in_platform_mm: Option<[f64; 3]>,
    /// 1σ of the axis' place in the platform across it, in the worst direction, mm.
    pub point_in_platform_sigma_mm: Option<f64>,
    /// 1σ of where the platform stands along the axis, mm.
    pub along_sigma_mm: Option<f64>,
    /// From the smallest to the largest angle, degrees.
    pub flexion_deg: Option<f64>,
    /// Angle of each pose from the first, degrees.
    pub angles_deg: Vec<f64>,
    /// What is left of the residuals, root mean square over the redundant lengths, mm.
    pub deviation_mm: Option<f64>,
    /// Noise of a cable length that the standard deviations are computed with, 1σ, mm.
    pub noise_mm: Option<f64>,
    /// The machine's constants where they were not known exactly.
    pub machine: Option<Constants>,
    /// What was left out. A pose with two suspected cables has two entries.
    pub rejected: Vec<RejectedCable>,
    /// Poses that the result stands on.
    pub poses_used: Option<usize>,
    /// Precision of the arithmetic.
    pub precision: Precision,
    /// Noise of a cable length that was given, 1σ, mm.
    pub given_noise_mm: Option<f64>,
    /// Noise that is expected of the rig, 1σ, mm.
    pub expected_noise_mm: f64,
    /// Residuals beyond this are not taken for noise unless it is given, mm.
    pub noise_limit_mm: f64,
    /// What is known of the refusal.
    pub refusal: Option<RefusalReport>,
    /// Of a refusal: how far the drawing is off where the poses fit a hinge that its standard deviations exclude.
    pub drawing_off: Option<DrawingOff>,
}

/// A hinge beside the drawing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DrawingOff {
    /// Angle between both axes in {B}, degrees.
    pub axis_deg: f64,
    /// Distance of the hinge's place next to the middle of the base from the drawn axis, mm.
    pub place_mm: f64,
}

/// The machine's constants as they were estimated.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Constants {
    /// Attachment points in {B}, mm.
    pub base_mm: Vec<[f64; 3]>,
    /// Ends in {P}, mm.
    pub ends_mm: Vec<[f64; 3]>,
    /// What each reading is too much, mm.
    pub zeros_mm: Vec<f64>,
    /// How much cable each drum pays out for 1 mm stated.
    pub drum_scale: Vec<f64>,
}

/// A refusal with its figures. Poses are rows of the log from 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum RefusalReport {
    /// See [`HingeRefusal::TooFewPoses`].
    TooFewPoses {
        /// Poses given.
        poses: u32,
        /// Poses wanted.
        wanted: u32,
    },
    /// See [`HingeRefusal::BadLength`].
    BadLength {
        /// Row of the log.
        pose: u32,
        /// Cable, from 1.
        cable: u8,
    },
    /// See [`HingeRefusal::TooFewCables`].
    TooFewCables {
        /// Cables of the rig.
        cables: u8,
        /// How many of the nine unknowns they determine.
        determined: u8,
    },
    /// See [`HingeRefusal::TooLittleFlexion`].
    TooLittleFlexion {
        /// From the smallest to the largest angle, degrees.
        range_deg: f64,
    },
    /// See [`HingeRefusal::TwoAxesFit`].
    TwoAxesFit {
        /// Angle between both axes, degrees.
        angle_deg: f64,
        /// Distance between both places, mm.
        distance_mm: f64,
    },
    /// See [`HingeRefusal::Weak`].
    Weak {
        /// Of what: `axis`, `place`, `axis_in_platform`, `place_in_platform`, `along`.
        part: &'static str,
        /// 1σ of a direction, degrees.
        sigma_deg: Option<f64>,
        /// 1σ of a place, mm.
        sigma_mm: Option<f64>,
    },
    /// See [`HingeRefusal::TooManyOutliers`].
    TooManyOutliers {
        /// Poses that would have to be left out.
        rejected: u32,
        /// Poses given.
        poses: u32,
    },
    /// See [`HingeRefusal::SecondAxis`].
    SecondAxis {
        /// Direction of the second axis in the platform.
        axis_in_platform: [f64; 3],
        /// 1σ of the angle about it, degrees.
        size_deg: f64,
    },
    /// See [`HingeRefusal::NotAHinge`].
    NotAHinge {
        /// Root mean square of the residuals, mm.
        residual_mm: f64,
    },
}

impl RefusalReport {
    fn of(refusal: &HingeRefusal) -> Self {
        let degrees = |angle_rad: f32| f64::from(angle_rad).to_degrees();
        match *refusal {
            HingeRefusal::TooFewPoses { poses, wanted } => Self::TooFewPoses { poses, wanted },
            HingeRefusal::BadLength { pose, cable, .. } => Self::BadLength { pose, cable },
            HingeRefusal::TooFewCables { cables, determined } => Self::TooFewCables { cables, determined },
            HingeRefusal::TooLittleFlexion { range_rad } => Self::TooLittleFlexion { range_deg: degrees(range_rad) },
            HingeRefusal::TwoAxesFit { angle_rad, distance_mm } => {
                Self::TwoAxesFit { angle_deg: degrees(angle_rad), distance_mm: distance_mm.into() }
            }
            HingeRefusal::Weak { part, sigma } => {
                let (name, is_direction) = match part {
                    HingePart::Axis => ("axis", true),
                    HingePart::Place => ("place", false),
                    HingePart::AxisInPlatform => ("axis_in_platform", true),
                    HingePart::PlaceInPlatform => ("place_in_platform", false),
                    HingePart::Along => ("along", false),
                };
                let sigma_deg = is_direction.then(|| degrees(sigma));
                Self::Weak { part: name, sigma_deg, sigma_mm: (!is_direction).then(|| sigma.into()) }
            }
            HingeRefusal::TooManyOutliers { rejected, poses } => Self::TooManyOutliers { rejected, poses },
            HingeRefusal::SecondAxis { axis_in_platform, size_rad } => {
                Self::SecondAxis { axis_in_platform: axis_in_platform.map(f64::from), size_deg: degrees(size_rad) }
            }
            HingeRefusal::NotAHinge { residual_mm } => Self::NotAHinge { residual_mm: residual_mm.into() },
        }
    }
}

/// The report of an estimator at its end.
pub(super) fn of<T: Real>(
    solved: &Solved<T>,
    rig: &HingeRig<f64>,
    request: &Request,
    noise_mm: Option<f64>,
) -> HingeReport {
    let empty = HingeReport {
        status: Status::Refused,
        reason: None,
        joint: "hinge",
        axis: None,
        axis_sigma_deg: None,
        point_mm: None,
        point_sigma_mm: None,
        axis_in_platform: None,
        axis_in_platform_sigma_deg: None,
        point_in_platform_mm: None,
        point_in_platform_sigma_mm: None,
        along_sigma_mm: None,
        flexion_deg: None,
        angles_deg: Vec::new(),
        deviation_mm: None,
        noise_mm: None,
        machine: None,
        rejected: Vec::new(),
        poses_used: None,
        precision: request.precision,
        given_noise_mm: noise_mm,
        expected_noise_mm: rig.length_noise_mm(),
        noise_limit_mm: rig.length_noise_mm() * MAX_TIMES_EXPECTED_NOISE,
        refusal: None,
        drawing_off: None,
    };
    match &solved.outcome {
        Ok(found) => accepted(empty, solved, found),
        Err(refusal) => {
            HingeReport { reason: Some(refusal.text()), refusal: Some(RefusalReport::of(refusal)), ..empty }
        }
    }
}

fn accepted<T: Real>(empty: HingeReport, solved: &Solved<T>, found: &IdentifiedHinge<T>) -> HingeReport {
    let vector = |vector: &Vector3<T>| -> [f64; 3] { vector.map(T::to_f64).into() };
    let degrees = |part| found.worst_sigma(part).to_f64().to_degrees();
    let hinge = &found.hinge;
    let point = solved.estimator.axis_point();
    // The same point in the platform: as far along the axis from its foot point.
    let along = hinge.axis().dot(&(point.at_mm - hinge.platform_foot_mm()));
    let in_platform = hinge.foot_in_platform_mm() + hinge.axis_in_platform() * along;
    let first = solved.poses.first().map_or(T::zero(), |pose| pose.angle_rad);
    let left_out = solved.poses.iter().enumerate().filter(|(_, pose)| !pose.is_used());
    let rejected = left_out.flat_map(|(row, pose)| {
        let cables = (1..=4).filter(|cable| pose.suspect_cables & (1 << (cable - 1)) != 0).map(Some);
        let none = (pose.suspect_cables == 0).then_some(None);
        cables.chain(none).map(move |cable| RejectedCable { pose: row, cable })
    });
    let machine = &found.machine;
    let count = machine.cables();
    HingeReport {
        status: Status::Accepted,
        axis: Some(vector(hinge.axis())),
        axis_sigma_deg: Some(degrees(HingePart::Axis)),
        point_mm: Some(vector(&point.at_mm)),
        point_sigma_mm: Some(worst_direction_of_point(&point.covariance_mm2).0.to_f64()),
        axis_in_platform: Some(vector(&hinge.axis_in_platform())),
        axis_in_platform_sigma_deg: Some(degrees(HingePart::AxisInPlatform)),
        point_in_platform_mm: Some(vector(&in_platform)),
        point_in_platform_sigma_mm: Some(found.worst_sigma(HingePart::PlaceInPlatform).to_f64()),
        along_sigma_mm: Some(found.worst_sigma(HingePart::Along).to_f64()),
        flexion_deg: Some(found.flexion_rad.to_f64().to_degrees()),
        angles_deg: solved.poses.iter().map(|pose| (pose.angle_rad - first).to_f64().to_degrees()).collect(),
        deviation_mm: Some(found.rms_residual_mm.to_f64()),
        noise_mm: Some(found.noise_mm.to_f64()),
        machine: (!machine.constants().is_empty()).then(|| Constants {
            base_mm: machine.base_mm().iter().map(vector).collect(),
            ends_mm: machine.end_mm().iter().take(count).map(vector).collect(),
            zeros_mm: machine.offset_mm().iter().take(count).map(|zero| zero.to_f64()).collect(),
            drum_scale: machine.scale().iter().take(count).map(|scale| scale.to_f64()).collect(),
        }),
        rejected: rejected.collect(),
        poses_used: Some(solved.poses.iter().filter(|pose| pose.is_used()).count()),
        ..empty
    }
}
