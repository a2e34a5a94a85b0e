//! The second set of poses: does the centre that was found explain poses that it was not found from?

use super::input_error::InputError;
use super::lengths_file::LengthsFile;
use glenoid::identification::Identified;
use glenoid::paper::verify;
use glenoid::kinematics::CableLengths;
use glenoid::rig::Rig;
use glenoid::scalar::Real;
use serde::Serialize;

/// Verification on a second log (step 4 of the paper's procedure).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verification {
    /// δE of the platform edges (Eq. 17, as a root mean square) over the poses that can be checked, mm.
    pub deviation_mm: Option<f64>,
    /// Poses in the log, all of them checked.
    pub poses: usize,
    /// The pose that fits worst, from 0.
    pub worst_pose: Option<usize>,
    /// δE of that pose alone, mm.
    pub worst_deviation_mm: Option<f64>,
    /// Poses, from 0, that contradict the result altogether: no arm turned about the centre has their lengths.
    pub contradicting: Vec<usize>,
}

impl Verification {
    /// Lays every pose of a log, less the zeros that were identified, against the result.
    ///
    /// # Errors
    /// [`InputError`] for a length that precision `T` cannot hold.
    pub fn of<T: Real>(rig: &Rig<T>, identified: &Identified<T>, log: &LengthsFile) -> Result<Self, InputError> {
        let mut found = Self {
            deviation_mm: None,
            poses: log.rows().len(),
            worst_pose: None,
            worst_deviation_mm: None,
            contradicting: Vec::new(),
        };
        let (mut squares_mm2, mut checked) = (0.0, 0);
        for (pose, row) in log.rows().iter().enumerate() {
            let measured = log.cables::<T>(row)?;
            let lengths_mm = std::array::from_fn(|cable| measured.as_mm()[cable] - identified.offsets_mm[cable]);
            // Pose by pose: one bad reading must not hide what the others say.
            let deviation_mm = CableLengths::new(lengths_mm)
                .ok()
                .and_then(|lengths| verify(rig, &identified.parameters, &[lengths]).ok())
                .map(T::to_f64);
            let Some(deviation_mm) = deviation_mm else {
                found.contradicting.push(pose);
                continue;
            };
            squares_mm2 += deviation_mm * deviation_mm;
            checked += 1;
            if found.worst_deviation_mm.is_none_or(|worst| deviation_mm > worst) {
                (found.worst_pose, found.worst_deviation_mm) = (Some(pose), Some(deviation_mm));
            }
        }
        found.deviation_mm = (checked > 0).then(|| (squares_mm2 / f64::from(checked)).sqrt());
        Ok(found)
    }
}
