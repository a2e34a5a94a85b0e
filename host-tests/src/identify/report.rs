//! What `cargo identify --json` prints: one object, its keys always the same and in the same order.

use super::causes::{Cause, Causes};
use super::held_report::{self, HeldReport};
use super::machine_report::MachineReport;
use super::refusal::RefusalDetail;
use super::selection::RowsUsed;
use super::verification::Verification;
use crate::estimation::Estimation;
use glenoid::identification::joint::Joint;
use glenoid::identification::{Identified, JointChoice, Machine, Refusal};
use glenoid::scalar::Real;
use serde::Serialize;

/// How it ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// The centre is identified.
    Accepted,
    /// There is no result, and `reason` says why.
    Refused,
}

/// Which identification.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// The iteration of the paper's Fig. 4, from a start.
    Paper,
    /// The start-free solver of the drive board.
    Full,
}

/// Precision of the arithmetic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Precision {
    /// Single, as on the drive board.
    F32,
    /// Double.
    F64,
}

/// Where the paper's method began.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Start {
    /// Who said so.
    pub from: &'static str,
    /// x, y, z, p1, p2, p3, mm.
    pub values_mm: [f64; 6],
}

/// A pose that was left out and a faulty cable of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct RejectedCable {
    /// Row of the log, from 0.
    pub pose: usize,
    /// Cable, 1 to 6; none when no single cable explains the pose.
    pub cable: Option<u8>,
}

/// The direction in which the centre is known worst.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct WorstCentre {
    /// 1σ in that direction, mm.
    pub sigma_mm: f64,
    /// The direction in {B}, a unit vector.
    pub direction: [f64; 3],
}

/// How a result is computed: what was asked for, and what follows from it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Setting {
    /// Rows of the log that are looked at.
    pub rows_used: RowsUsed,
    /// Which identification.
    pub method: Method,
    /// In which precision.
    pub precision: Precision,
    /// The encoders' zeros are known to this only, 1σ, mm, where it was said.
    #[serde(skip)]
    pub zero_prior_mm: Option<f64>,
    /// Which models of the joint are tried.
    #[serde(skip)]
    pub joint: JointChoice,
    /// The machine has so many unknown constants that there is no room for those of a centre that moves.
    #[serde(skip)]
    pub has_no_room_for_motion: bool,
    /// Where the paper's method begins. The full one has no start.
    pub start: Option<Start>,
    /// Noise of a cable length that was given, 1σ, mm; otherwise it is estimated from the residuals.
    pub given_noise_mm: Option<f64>,
    /// Noise that is expected of the rig, 1σ, mm.
    pub expected_noise_mm: f64,
    /// Residuals beyond this are not taken for noise unless it is given, mm.
    pub noise_limit_mm: f64,
}

/// The outcome. What is not known is `null`, never a made-up number.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// How it ended.
    pub status: Status,
    /// Why it was refused.
    pub reason: Option<&'static str>,
    /// Joint centre in {B}, mm.
    pub centre_mm: Option<[f64; 3]>,
    /// Distances |OP1|, |OP2|, |OP3|, mm.
    pub radii_mm: Option<[f64; 3]>,
    /// 1σ of x, y, z, p1, p2, p3, mm.
    pub sigma_mm: Option<[f64; 6]>,
    /// What is left of the residuals, root mean square, mm. See [`Identified::rms_residual_mm`].
    pub deviation_mm: Option<f64>,
    /// The deviation of every iteration, mm.
    pub deviations_mm: Vec<f64>,
    /// Least-squares steps taken.
    pub iterations: u8,
    /// The joint: `ball` or `moving`.
    pub joint: Option<&'static str>,
    /// Scatter of the poses' own centres about a moving one, 1σ an axis, mm.
    pub scatter_mm: Option<f64>,
    /// The machine's constants where they were not known exactly.
    pub machine: Option<MachineReport>,
    /// What was left out. A pose with two suspected cables has two entries.
    pub rejected: Vec<RejectedCable>,
    /// What each of the six encoders reads too much, mm, when it was asked for.
    pub zeros_mm: Option<[f64; 6]>,
    /// The direction in x, y, z, p1, p2, p3 that is known worst, a unit vector.
    pub weak_direction: Option<[f64; 6]>,
    /// 1σ of the encoders' zeros, mm.
    pub zero_sigmas_mm: Option<[f64; 6]>,
    /// The worst direction of the centre alone.
    pub worst_centre: Option<WorstCentre>,
    /// 1σ of the centre in its worst direction if the zeros that were found were known exactly, mm: how much of the
    /// standard deviation is due to homing.
    pub worst_sigma_if_homed_mm: Option<f64>,
    /// Noise of a cable length that the standard deviations are computed with, 1σ, mm. The paper's method: of an edge of the platform.
    pub noise_mm: Option<f64>,
    /// How far the poses are from turning about one common axis, degrees, root mean square.
    pub sway_deg: Option<f64>,
    /// Poses that the result stands on.
    pub poses_used: Option<usize>,
    /// How it was computed.
    #[serde(flatten)]
    pub setting: Setting,
    /// What is known of the refusal.
    pub refusal: Option<RefusalDetail>,
    /// The poses of `--still`, when they were asked for.
    pub held: Option<HeldReport>,
    /// What explains the log better than a fixed centre and the machine as stated.
    pub cause: Option<Causes>,
    /// The constant of the machine that contradicts its stated tolerance, in a set that is accepted.
    pub contradiction: Option<Cause>,
    /// The result on a second log.
    pub verification: Option<Verification>,
}

impl Report {
    /// An identified centre.
    pub fn accepted<T: Real>(found: &Identified<T>, setting: Setting) -> Self {
        let of_pose: Vec<usize> = setting.rows_used.iter().collect();
        let mut rejected = Vec::new();
        for entry in &found.rejected {
            let pose = of_pose[entry.pose as usize];
            rejected.extend(entry.cable_numbers().map(|cable| RejectedCable { pose, cable: Some(cable) }));
            if entry.cables == 0 {
                rejected.push(RejectedCable { pose, cable: None });
            }
        }
        let (sigma, direction) = found.worst_centre_sigma_mm();
        let sway_deg = found.excitation_rad.to_f64().to_degrees();
        Self {
            status: Status::Accepted,
            centre_mm: Some(found.parameters.centre_mm.map(T::to_f64).into()),
            radii_mm: Some(found.parameters.radii_mm.map(T::to_f64)),
            sigma_mm: Some(found.sigma_mm().map(T::to_f64)),
            deviation_mm: Some(found.rms_residual_mm.to_f64()),
            deviations_mm: found.rms_residuals_mm.iter().map(|deviation| deviation.to_f64()).collect(),
            rejected,
            zeros_mm: setting.zero_prior_mm.map(|_| found.offsets_mm.map(T::to_f64)),
            zero_sigmas_mm: setting.zero_prior_mm.map(|_| found.offset_sigmas_mm.map(T::to_f64)),
            weak_direction: Some(found.weak_direction().0.map(T::to_f64)),
            worst_centre: Some(WorstCentre { sigma_mm: sigma.to_f64(), direction: direction.map(T::to_f64) }),
            noise_mm: Some(found.noise_mm.to_f64()),
            // The paper's method does not look.
            sway_deg: sway_deg.is_finite().then_some(sway_deg),
            poses_used: Some(setting.rows_used.count - found.rejected.len()),
            ..Self::empty(found.iterations, setting)
        }
    }

    /// The result of the estimator.
    pub fn of_estimation<T: Real>(estimation: &Estimation<T>, machine: &Machine<T>, setting: Setting) -> Self {
        let Ok(found) = &estimation.outcome else { return Self::empty(estimation.estimator.iterations(), setting) };
        let mut report = Self::accepted(found, setting);
        let rows: Vec<usize> = setting.rows_used.iter().collect();
        let left_out = estimation.poses.iter().zip(&rows).filter(|(pose, _)| !pose.is_used());
        report.rejected = left_out
            .flat_map(|(pose, row)| {
                let cables = (1..=6).filter(|cable| pose.suspect_cables & (1 << (cable - 1)) != 0).map(Some);
                let none = (pose.suspect_cables == 0).then_some(None);
                cables.chain(none).map(|cable| RejectedCable { pose: *row, cable })
            })
            .collect();
        report.poses_used = Some(estimation.poses.iter().filter(|pose| pose.is_used()).count());
        let joint = estimation.estimator.joint();
        report.joint = Some(match joint {
            Joint::Moving(_) => "moving",
            Joint::Ball | Joint::Held(_) => "ball",
        });
        report.scatter_mm = match joint {
            Joint::Moving(moving) => Some(moving.scatter.sigma_mm().to_f64()),
            Joint::Ball | Joint::Held(_) => None,
        };
        report.machine = MachineReport::of(&estimation.estimator, machine, found.noise_mm);
        report
    }

    /// A refusal after so many iterations.
    pub fn refused(refusal: &Refusal, iterations: u8, setting: Setting) -> Self {
        let row = |pose: u32| setting.rows_used.iter().nth(pose as usize).unwrap_or_default();
        Self {
            reason: Some(refusal.text()),
            refusal: Some(RefusalDetail::of(refusal, row)),
            ..Self::empty(iterations, setting)
        }
    }

    /// A refusal of the held poses.
    pub fn refused_held(refusal: &Refusal, held: HeldReport, setting: Setting) -> Self {
        let detail = RefusalDetail::of(refusal, |pose| pose as usize);
        Self {
            reason: Some(held_report::reason(&detail, &held).unwrap_or(refusal.text())),
            refusal: Some(detail),
            held: Some(held),
            ..Self::empty(0, setting)
        }
    }

    fn empty(iterations: u8, setting: Setting) -> Self {
        Self {
            status: Status::Refused,
            reason: None,
            centre_mm: None,
            radii_mm: None,
            sigma_mm: None,
            deviation_mm: None,
            deviations_mm: Vec::new(),
            iterations,
            joint: None,
            scatter_mm: None,
            machine: None,
            rejected: Vec::new(),
            zeros_mm: None,
            zero_sigmas_mm: None,
            weak_direction: None,
            worst_centre: None,
            worst_sigma_if_homed_mm: None,
            noise_mm: None,
            sway_deg: None,
            poses_used: None,
            setting,
            refusal: None,
            held: None,
            cause: None,
            contradiction: None,
            verification: None,
        }
    }
}
