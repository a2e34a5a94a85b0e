//! Asks the library, in either precision, and brings the answer back to double precision.

use super::scene::Scene;
use crate::estimation::{Estimation, estimate};
use glenoid::identification::joint::Joint;
use glenoid::identification::{EstimatorSettings, Identified, JointChoice, Machine, Noise, Refusal, Rejected};
use glenoid::kinematics::CableLengths;
use glenoid::rig::{CABLES, Rig};
use glenoid::scalar::Real;
use nalgebra::Vector3;

/// A precision that a rig is held in.
pub trait Precision: Real {
    /// Its name.
    const NAME: &'static str;

    /// The rig of a scene in this precision.
    fn rig(scene: &Scene) -> &Rig<Self>;
}

impl Precision for f64 {
    const NAME: &'static str = "f64";

    fn rig(scene: &Scene) -> &Rig<Self> {
        scene.rig()
    }
}

impl Precision for f32 {
    const NAME: &'static str = "f32";

    fn rig(scene: &Scene) -> &Rig<Self> {
        scene.rig_single()
    }
}

/// What the estimator is given about the noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Knowledge {
    /// Its standard deviation, as on the device.
    Noise,
    /// Only that it is below 0.3 mm.
    Nothing,
    /// Its standard deviation, and that every pose is sound: a set may then depend on one pose, as three always do.
    NoiseAndSoundPoses,
}

/// Largest noise that is still taken for noise when it is not known, mm: five times the paper's.
const MAX_NOISE_MM: f64 = 0.3;

/// An accepted answer, in double precision.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// x, y, z, p1, p2, p3, mm.
    pub parameters_mm: [f64; 6],
    /// 1σ of the same, mm.
    pub sigma_mm: [f64; 6],
    /// Noise that the standard deviation was computed with, mm.
    pub noise_mm: f64,
    /// What is left of the residuals, mm.
    pub deviation_mm: f64,
    /// Poses left out.
    pub rejected: Vec<Rejected>,
    /// Distance from turning about one axis, rad.
    pub excitation_rad: f64,
    /// Offset of each encoder, mm; 0 when the offsets are taken as known.
    pub zeros_mm: [f64; CABLES],
    /// 1σ of the same, mm.
    pub zero_sigmas_mm: [f64; CABLES],
    /// Where the joint's model has the centre in each pose that was not left out; empty for a ball, whose centre is in
    /// one place.
    pub path: Vec<PathPoint>,
}

/// The joint centre in one pose, by the model of a moving joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathPoint {
    /// The pose, from 0.
    pub pose: usize,
    /// The centre in {B}, mm.
    pub centre_mm: Vector3<f64>,
    /// Root of the summed variances of its coordinates, mm.
    pub sigma_mm: f64,
}

/// Accepted centres may be off by this many standard deviations...
const SIGMAS: f64 = 5.0;
/// ... plus this, mm.
const SLACK_MM: f64 = 0.05;
/// Of a moving joint's path, this share of the poses may be further off: 5σ covers no model's lack of fit everywhere.
const MAX_SHARE_OFF: f64 = 0.02;

impl Answer {
    fn of<T: Real>(machine: &Machine<T>, estimation: Estimation<T>) -> Result<Self, Refusal> {
        let path = match estimation.estimator.joint() {
            Joint::Moving(_) => path(machine, &estimation),
            Joint::Ball | Joint::Held(_) => Vec::new(),
        };
        Ok(Self { path, ..Self::of_ball(estimation.outcome?) })
    }

    fn of_ball<T: Real>(identified: Identified<T>) -> Self {
        Self {
            path: Vec::new(),
            parameters_mm: identified.parameters.to_array().map(Real::to_f64),
            sigma_mm: identified.sigma_mm().map(Real::to_f64),
            noise_mm: identified.noise_mm.to_f64(),
            deviation_mm: identified.rms_residual_mm.to_f64(),
            rejected: identified.rejected.to_vec(),
            excitation_rad: identified.excitation_rad.to_f64(),
            zeros_mm: identified.offsets_mm.map(Real::to_f64),
            zero_sigmas_mm: identified.offset_sigmas_mm.map(Real::to_f64),
        }
    }

    /// Found minus true centre, mm.
    pub fn centre_error_mm(&self, scene: &Scene) -> Vector3<f64> {
        Vector3::from_row_slice(&self.parameters_mm[..3]) - scene.centre_mm
    }

    /// Whether it is further off than its standard deviation allows. `true_centre_mm` gives the true centre in each pose.
    pub fn is_false(&self, true_centre_mm: impl Fn(usize) -> Vector3<f64>) -> bool {
        // A NaN is false too.
        let holds = |off_mm: Vector3<f64>, sigma_mm: f64| off_mm.norm() <= SIGMAS * sigma_mm + SLACK_MM;
        if self.path.is_empty() {
            let centre_mm = Vector3::from_row_slice(&self.parameters_mm[..3]);
            return !holds(centre_mm - true_centre_mm(0), self.centre_sigma_mm());
        }
        let off = self.path.iter().filter(|at| !holds(at.centre_mm - true_centre_mm(at.pose), at.sigma_mm)).count();
        off as f64 > MAX_SHARE_OFF * self.path.len() as f64
    }

    /// Largest error of any of the six parameters, mm.
    pub fn largest_error_mm(&self, scene: &Scene) -> f64 {
        let truth = scene.truth().to_array();
        self.parameters_mm.iter().zip(truth).fold(0.0, |most, (found, true_)| most.max((found - true_).abs()))
    }

    /// Root of the summed variances of the centre's three coordinates, mm.
    pub fn centre_sigma_mm(&self) -> f64 {
        libm::sqrt(self.sigma_mm[..3].iter().map(|sigma| sigma * sigma).sum())
    }
}

/// Where a moving joint has its centre in the poses that were not left out.
fn path<T: Real>(machine: &Machine<T>, estimation: &Estimation<T>) -> Vec<PathPoint> {
    let rejected = estimation.outcome.as_ref().map_or(&[][..], |identified| &identified.rejected);
    let kept = |pose: &usize| rejected.iter().all(|left_out| left_out.pose as usize != *pose);
    (0..estimation.poses.len())
        .filter(kept)
        .filter_map(|pose| {
            let at = estimation.estimator.predict(machine, &estimation.poses[pose])?;
            Some(PathPoint {
                pose,
                centre_mm: at.predicted_mm.map(Real::to_f64),
                sigma_mm: at.predicted_covariance_mm2.trace().to_f64().sqrt(),
            })
        })
        .collect()
}

/// Rounds lengths to a precision.
///
/// # Errors
/// The first pose with a length that is none.
pub fn lengths_in<T: Real>(poses_mm: &[[f64; CABLES]]) -> Result<Vec<CableLengths<T>>, Refusal> {
    let pose = |(index, lengths): (usize, &[f64; CABLES])| {
        CableLengths::new(lengths.map(T::of)).map_err(|error| Refusal::BadLength {
            pose: index as u32,
            cable: error.cable,
            fault: error.fault,
        })
    };
    poses_mm.iter().enumerate().map(pose).collect()
}

/// The start-free solver with the limits that the device uses; the data choose the joint's model.
///
/// # Errors
/// The solver's refusal.
pub fn solve<T: Precision>(scene: &Scene, poses_mm: &[[f64; CABLES]], knowledge: Knowledge) -> Result<Answer, Refusal> {
    solve_with::<T>(scene, poses_mm, knowledge, JointChoice::Auto, 0.0)
}

/// The same with encoder zeros that are known to `zero_prior_mm` only, 1σ, mm.
///
/// # Errors
/// The solver's refusal.
pub fn solve_with_zeros<T: Precision>(
    scene: &Scene,
    poses_mm: &[[f64; CABLES]],
    knowledge: Knowledge,
    zero_prior_mm: f64,
) -> Result<Answer, Refusal> {
    solve_with::<T>(scene, poses_mm, knowledge, JointChoice::Auto, zero_prior_mm)
}

/// The same with a chosen model of the joint.
///
/// # Errors
/// The solver's refusal.
pub fn solve_with<T: Precision>(
    scene: &Scene,
    poses_mm: &[[f64; CABLES]],
    knowledge: Knowledge,
    joint: JointChoice,
    zero_prior_mm: f64,
) -> Result<Answer, Refusal> {
    let rig = T::rig(scene);
    let mut settings = EstimatorSettings::for_rig(rig);
    if knowledge == Knowledge::Nothing {
        settings.noise = Noise::EstimatedUpTo(T::of(MAX_NOISE_MM));
    }
    settings.require_redundancy = knowledge != Knowledge::NoiseAndSoundPoses;
    settings.joint = joint;
    let machine = Machine::with_offset_prior(rig, T::of(zero_prior_mm));
    Answer::of(&machine, estimate(&machine, rig, settings, &lengths_in(poses_mm)?))
}
