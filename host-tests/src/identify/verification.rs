//! The second set of poses: does the centre that was found explain poses that it was not found from?

use super::input_error::InputError;
use super::lengths_file::LengthsFile;
use glenoid::identification::verification::{CentrePrediction, rms_limit_mm};
use glenoid::identification::{Estimator, Identified, Machine, Pose};
use glenoid::paper::verify;
use glenoid::rig::Rig;
use glenoid::scalar::Real;
use nalgebra::{Matrix3, Vector3};
use serde::Serialize;

/// Verification on a second log (step 4 of the paper's procedure).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verification {
    /// Root mean square of what is left over the poses that can be checked, mm: of the cable lengths, three of each pose;
    /// with the paper's method δE of the platform edges (Eq. 17).
    pub deviation_mm: Option<f64>,
    /// Where χ² would refuse, mm; not for the paper's method.
    pub limit_mm: Option<f64>,
    /// The second set agrees with the result, by χ²; not for the paper's method.
    pub agrees: Option<bool>,
    /// Poses in the log.
    pub pose_count: usize,
    /// The pose that fits worst, from 0.
    pub worst_pose: Option<usize>,
    /// What is left of that pose alone, mm.
    pub worst_deviation_mm: Option<f64>,
    /// Poses, from 0, that contradict the result altogether: no arm turned about the centre has their lengths.
    pub contradicting: Vec<usize>,
    /// The joint centre in each pose that can be checked; empty for the paper's method.
    pub poses: Vec<VerifiedCentre>,
}

/// The joint centre in {B} in one pose.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VerifiedCentre {
    /// By the joint's model from the pose's rotation, mm.
    pub predicted_mm: [f64; 3],
    /// xx, xy, xz, yy, yz, zz, mm².
    pub predicted_covariance_mm2: [f64; 6],
    /// As the pose's six lengths read it, mm.
    pub live_mm: [f64; 3],
    /// xx, xy, xz, yy, yz, zz, mm².
    pub live_covariance_mm2: [f64; 6],
}

impl Verification {
    fn none(poses: usize) -> Self {
        Self {
            deviation_mm: None,
            limit_mm: None,
            agrees: None,
            pose_count: poses,
            worst_pose: None,
            worst_deviation_mm: None,
            contradicting: Vec::new(),
            poses: Vec::new(),
        }
    }

    /// Holds every pose against the estimator's last fit.
    pub fn of<T: Real>(
        machine: &Machine<T>,
        estimator: &Estimator<T>,
        identified: &Identified<T>,
        poses: &[Pose<T>],
    ) -> Self {
        let mut found = Self::none(poses.len());
        let (mut squares_mm2, mut chi_square, mut checked) = (0.0, T::zero(), 0_usize);
        for (index, pose) in poses.iter().enumerate() {
            let mut pose = *pose;
            pose.place(machine.platform());
            let verified = estimator.verify(machine, &pose);
            let predicted = estimator.predict(machine, &pose);
            let (Some(verified), Some(predicted)) = (verified, predicted) else {
                found.contradicting.push(index);
                continue;
            };
            found.poses.push(VerifiedCentre::of(&predicted));
            squares_mm2 += verified.squares_mm2.to_f64();
            chi_square += verified.chi_square;
            checked += 1;
            found.note(index, (verified.squares_mm2.to_f64() / 3.0).sqrt());
        }
        if checked > 0 {
            let deviation_mm = (squares_mm2 / (3 * checked) as f64).sqrt();
            let joint = estimator.joint();
            let limit = rms_limit_mm(T::of(deviation_mm), chi_square, checked, identified.noise_mm, joint).to_f64();
            found.deviation_mm = Some(deviation_mm);
            found.limit_mm = Some(limit);
            found.agrees = Some(deviation_mm <= limit && found.contradicting.is_empty());
        }
        found
    }

    /// Holds every pose of a log against the result of the paper's method, by its own tetrahedra.
    ///
    /// # Errors
    /// [`InputError`] for a length that precision `T` cannot hold.
    pub fn of_paper<T: Real>(rig: &Rig<T>, identified: &Identified<T>, log: &LengthsFile) -> Result<Self, InputError> {
        let mut found = Self::none(log.rows().len());
        let (mut squares_mm2, mut checked) = (0.0, 0);
        for (index, row) in log.rows().iter().enumerate() {
            let measured = log.true_lengths(row, rig)?;
            // Pose by pose: one bad reading must not hide what the others say.
            match verify(rig, &identified.parameters, &[measured]).ok().map(T::to_f64) {
                None => found.contradicting.push(index),
                Some(deviation_mm) => {
                    squares_mm2 += deviation_mm * deviation_mm;
                    checked += 1;
                    found.note(index, deviation_mm);
                }
            }
        }
        found.deviation_mm = (checked > 0).then(|| (squares_mm2 / f64::from(checked)).sqrt());
        Ok(found)
    }

    fn note(&mut self, pose: usize, deviation_mm: f64) {
        if self.worst_deviation_mm.is_none_or(|worst| deviation_mm > worst) {
            (self.worst_pose, self.worst_deviation_mm) = (Some(pose), Some(deviation_mm));
        }
    }
}

impl VerifiedCentre {
    fn of<T: Real>(found: &CentrePrediction<T>) -> Self {
        let point = |point: &Vector3<T>| point.map(T::to_f64).into();
        let packed = |m: &Matrix3<T>| [m.m11, m.m12, m.m13, m.m22, m.m23, m.m33].map(T::to_f64);
        Self {
            predicted_mm: point(&found.predicted_mm),
            predicted_covariance_mm2: packed(&found.predicted_covariance_mm2),
            live_mm: point(&found.live_mm),
            live_covariance_mm2: packed(&found.live_covariance_mm2),
        }
    }
}
