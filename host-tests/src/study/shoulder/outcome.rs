//! What is found of a shoulder, by which method, and how far off it is in poses that identified nothing.

use super::set::{Person, Posed, lengths};
use crate::estimation::{estimate, estimate_poses};
use crate::identify::held_phase;
use glenoid::identification::joint::Joint;
use glenoid::identification::pivot_calibration::PivotCalibration;
use glenoid::identification::verification::CentrePrediction;
use glenoid::identification::{Estimator, EstimatorSettings, JointChoice, Machine, Pose, Refusal};
use glenoid::kinematics::rotation::rotation_of;
use glenoid::kinematics::{AttitudeSolver, CableSet, JointCentre};
use glenoid::paper::{PaperIteration, PaperSettings};
use glenoid::rig::Rig;
use nalgebra::{DMatrix, DVector, Vector3};

/// 99 % of χ² with three degrees of freedom.
const WITHIN_99: f64 = 11.345;

/// How far off an accepted path is over the poses of a second set: root mean squares, mm.
#[derive(Clone, Copy, Debug)]
pub struct Path {
    /// The predicted centre.
    pub centre_mm: f64,
    /// Of that, across the arm.
    pub across_mm: f64,
    /// The three predicted end-points.
    pub end_points_mm: f64,
    /// The centre read from the pose's own lengths.
    pub live_mm: f64,
    /// Share of the poses whose 99 % region holds the true centre.
    pub covered: f64,
    /// More than a fiftieth of the poses lie beyond 5 σ + 0.05 mm.
    pub is_wrong: bool,
    /// The moving model was chosen.
    pub moves: bool,
}

/// The start-free estimator on free poses, after held ones if there are any.
///
/// # Errors
/// Its [`Refusal`].
pub fn estimated(person: &Person, held: &[Posed], free: &[Posed], second: &[Posed]) -> Result<Path, Refusal> {
    let rig = &person.machine.stated;
    let machine = Machine::new(rig);
    let settings = EstimatorSettings::for_rig(rig);
    let held = match held {
        [] => None,
        poses => Some(held_phase::identify(&machine, rig, settings, as_poses(poses))?),
    };
    let estimation = estimate_poses(&machine, rig, settings, held, as_poses(free));
    estimation.outcome?;
    path(&machine, &estimation.estimator, second).ok_or(Refusal::Singular)
}

fn as_poses(posed: &[Posed]) -> Vec<Pose<f64>> {
    lengths(posed).into_iter().map(Pose::new).collect()
}

fn path(machine: &Machine<f64>, estimator: &Estimator<f64>, second: &[Posed]) -> Option<Path> {
    let (mut centre, mut across, mut end_points, mut live) = (0.0, 0.0, 0.0, 0.0);
    let (mut covered, mut far) = (0, 0);
    for (posed, lengths) in second.iter().zip(lengths(second)) {
        let pose = Pose::placed(machine.platform(), lengths).ok()?;
        let prediction = estimator.predict(machine, &pose)?;
        let error = prediction.predicted_mm - posed.centre_mm;
        let covariance = prediction.predicted_covariance_mm2;
        centre += error.norm_squared();
        across += (error - posed.along * error.dot(&posed.along)).norm_squared();
        live += (prediction.live_mm - posed.slid_mm).norm_squared();
        let squared = covariance.try_inverse().map_or(f64::INFINITY, |inverse| error.dot(&(inverse * error)));
        covered += usize::from(squared < WITHIN_99);
        far += usize::from(error.norm() > 5.0 * covariance.trace().sqrt() + 0.05);
        end_points += end_point_squares(machine, estimator, &pose, &prediction, posed)?;
    }
    let poses = second.len() as f64;
    let rms = |squares: f64| (squares / poses).sqrt();
    Some(Path {
        centre_mm: rms(centre),
        across_mm: rms(across),
        end_points_mm: rms(end_points),
        live_mm: rms(live),
        covered: covered as f64 / poses,
        is_wrong: far * 50 > second.len(),
        moves: matches!(estimator.joint(), Joint::Moving(_)),
    })
}

/// Mean square of the error of the end-points when the platform stands about the predicted centre, with the rotation that
/// its six lengths show.
fn end_point_squares(
    machine: &Machine<f64>,
    estimator: &Estimator<f64>,
    pose: &Pose<f64>,
    prediction: &CentrePrediction<f64>,
    posed: &Posed,
) -> Option<f64> {
    let machine_estimate = estimator.machine_estimate();
    let in_platform_mm = estimator.centre().in_platform_mm;
    let own = JointCentre { in_base_mm: prediction.live_mm, in_platform_mm };
    let solver = AttitudeSolver { geometry: machine_estimate.geometry(), centre: &own };
    let lengths = machine_estimate.corrected(machine, pose.lengths());
    let turned = rotation_of(&solver.track(*pose.attitude(), &lengths, CableSet::ALL)?.attitude);
    let ends = machine_estimate.geometry().end_points_mm();
    let square = |(point, truth): (&Vector3<f64>, &Vector3<f64>)| {
        (prediction.predicted_mm + turned * (point - in_platform_mm) - truth).norm_squared()
    };
    Some(ends.iter().zip(&posed.ends_mm).map(square).sum::<f64>() / 3.0)
}

/// Methods that know a fixed centre only.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fixed {
    /// The estimator, told that the joint is a ball.
    Ball,
    /// The paper's iteration.
    Paper,
    /// SCoRE (Ehrig 2006): one centre in both bodies.
    Score,
    /// A sphere through each end-point (algebraic fit), the three centres averaged.
    Sphere,
}

/// How far off a fixed centre is from the moving one, rms over the second set, mm; `None` when it is refused.
pub fn fixed_mm(method: Fixed, person: &Person, free: &[Posed], second: &[Posed]) -> Option<f64> {
    let centre = fixed_centre(method, person, free)?;
    let squares: f64 = second.iter().map(|posed| (centre - posed.centre_mm).norm_squared()).sum();
    Some((squares / second.len() as f64).sqrt())
}

fn fixed_centre(method: Fixed, person: &Person, free: &[Posed]) -> Option<Vector3<f64>> {
    let rig: &Rig<f64> = &person.machine.stated;
    let machine = Machine::new(rig);
    let lengths = lengths(free);
    let placed = || lengths.iter().filter_map(|lengths| Pose::placed(machine.platform(), *lengths).ok());
    match method {
        Fixed::Ball => {
            let settings = EstimatorSettings { joint: JointChoice::Ball, ..EstimatorSettings::for_rig(rig) };
            Some(estimate(&machine, rig, settings, &lengths).outcome.ok()?.parameters.centre_mm)
        }
        Fixed::Paper => {
            let start = *rig.nominal();
            Some(PaperIteration::new(rig, start, PaperSettings::default()).run(&lengths).ok()?.parameters.centre_mm)
        }
        Fixed::Score => {
            let mut calibration = PivotCalibration::default();
            placed().for_each(|pose| calibration.add(&pose.platform()));
            Some(calibration.solve().ok()?.in_base_mm)
        }
        Fixed::Sphere => {
            let centres: Option<Vec<_>> = rig
                .platform_mm()
                .iter()
                .map(|point| {
                    let places = placed().map(|pose| pose.platform().origin_mm + pose.rotation() * point);
                    sphere_centre(&places.collect::<Vec<_>>())
                })
                .collect();
            let centres = centres?;
            Some(centres.iter().sum::<Vector3<f64>>() / centres.len() as f64)
        }
    }
}

/// Centre of the sphere through points: |x|² = 2 c·x + k, linear in c and k.
fn sphere_centre(points: &[Vector3<f64>]) -> Option<Vector3<f64>> {
    let rows = DMatrix::from_fn(points.len(), 4, |i, j| if j < 3 { 2.0 * points[i][j] } else { 1.0 });
    let squares = DVector::from_iterator(points.len(), points.iter().map(Vector3::norm_squared));
    let solution = rows.svd(true, true).solve(&squares, 1e-12).ok()?;
    Some(Vector3::new(solution[0], solution[1], solution[2]))
}
