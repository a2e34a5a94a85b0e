//! One log: the poses of one wearing, with one joint centre of their own.

use super::refusal::Refused;
use super::request::{KnownCentre, LogRequest};
use crate::identify::input_error::{InputError, Place};
use crate::identify::lengths_file::LengthsFile;
use crate::identify::rig_file::RigFile;
use crate::identify::units;
use glenoid::identification::excitation::Excitation;
use glenoid::identification::pivot_calibration::PivotCalibration;
use glenoid::identification::{EstimatorSettings, Machine, Pose};
use glenoid::kinematics::{CableLengths, JointCentre};
use glenoid::rig::{CABLES, Rig};
use rayon::prelude::*;

/// Fewest poses of a log: each has three equations more than unknowns of its own, the joint centre has six unknowns, and
/// a few must be left to contradict.
const MIN_POSES: usize = 6;

/// The poses of one wearing.
#[derive(Clone, Debug)]
pub struct Wearing {
    /// The log's name for messages.
    pub file: String,
    /// Where COMMISSION.toml names it.
    pub place: Place,
    /// Its poses.
    pub poses: Vec<Pose<f64>>,
    /// The line of each.
    pub lines: Vec<usize>,
    /// Its joint centre, at the present estimate.
    pub centre: JointCentre<f64>,
    /// Where that is known to be.
    pub known: Option<KnownCentre>,
    /// Repeated rows, other columns: what the log was taken for.
    pub notes: Vec<String>,
    /// How the poses move the arm.
    pub excitation: Excitation<f64>,
}

/// A log that cannot be read is an error of the input; one that determines nothing is refused.
#[derive(Debug)]
pub enum Unusable {
    /// It cannot be read.
    Input(InputError),
    /// It determines nothing.
    Refused(Refused),
}

impl From<InputError> for Unusable {
    fn from(error: InputError) -> Self {
        Self::Input(error)
    }
}

impl Wearing {
    /// Reads a log and places its poses. `samples_a_row`: what each row is the mean of, where the rig's noise is to be used.
    ///
    /// # Errors
    /// [`Unusable`].
    pub fn read(
        request: &LogRequest,
        machine: &Machine<f64>,
        rig_file: &RigFile,
        samples_a_row: Option<u16>,
    ) -> Result<Self, Unusable> {
        let rig = &rig_file.rig;
        let log = LengthsFile::read(&request.path)?;
        if let (Some(complaint), Some(row)) =
            (units::complaint_about_lengths(log.rows(), rig.base_mm()), log.rows().first())
        {
            return Err(log.at(row.line, 0, complaint).into());
        }
        let log = log.with_repeated_rows_merged(rig_file.row_noise_mm());
        let poses = log.poses(log.rows().iter(), rig, samples_a_row)?;
        let lines = log.rows().iter().map(|row| row.line).collect();
        let mut notes = log.notes().to_vec();
        notes.extend(log.note_of_correction(rig));
        Self::place(request, log.file(), poses, lines, notes, machine, rig).map_err(Unusable::Refused)
    }

    /// Of readings that are in no file.
    ///
    /// # Errors
    /// [`Refused`] when they determine nothing.
    pub fn of_readings(
        request: &LogRequest,
        readings: &[[f64; CABLES]],
        machine: &Machine<f64>,
        rig: &Rig<f64>,
    ) -> Result<Self, Refused> {
        let lengths = readings.iter().map(|reading| CableLengths::new(*reading)?.corrected(rig));
        let poses: Result<Vec<_>, _> = lengths.map(|lengths| lengths.map(Pose::new)).collect();
        let poses = poses.map_err(|error| Refused::at(request.place.clone(), error.fault.text()))?;
        let lines = (1..=poses.len()).collect();
        Self::place(request, &request.path.display().to_string(), poses, lines, Vec::new(), machine, rig)
    }

    fn place(
        request: &LogRequest,
        file: &str,
        mut poses: Vec<Pose<f64>>,
        lines: Vec<usize>,
        notes: Vec<String>,
        machine: &Machine<f64>,
        rig: &Rig<f64>,
    ) -> Result<Self, Refused> {
        let refused = |reason: String| Refused::at(request.place.clone(), format!("{file}: {reason}"));
        poses.par_iter_mut().for_each(|pose| pose.place(machine.platform()));
        let mut calibration = PivotCalibration::default();
        poses.iter().filter(|pose| pose.is_placed()).for_each(|pose| calibration.add(&pose.platform()));
        let placed = calibration.rotations().poses() as usize;
        if placed < MIN_POSES {
            let reason = if poses.len() < MIN_POSES {
                format!(
                    "{} different poses determine nothing of the machine, at least {MIN_POSES} are wanted",
                    poses.len()
                )
            } else {
                format!("only {placed} of {} poses fit this rig at all: another rig, or cables exchanged", poses.len())
            };
            return Err(refused(reason));
        }
        let excitation = calibration.rotations().excitation();
        let settings = EstimatorSettings::for_rig(rig);
        if excitation.second_rad < settings.spread_limit_rad {
            let degrees = excitation.second_rad.to_degrees();
            return Err(refused(format!(
                "determines nothing: its poses are all alike ({degrees:.1} degrees apart); move the arm"
            )));
        }
        if excitation.least_rad < settings.excitation_limit_rad {
            let [x, y, z] = excitation.axis.into();
            return Err(refused(format!(
                "determines nothing: its poses turn about one axis, ({x:.2}, {y:.2}, {z:.2}) in {{B}}; move the arm about \
                 the others too"
            )));
        }
        let centre =
            calibration.solve().map_err(|_| refused("its poses leave the joint centre undetermined".to_owned()))?;
        let (file, place, known) = (file.to_owned(), request.place.clone(), request.known.clone());
        Ok(Self { file, place, poses, lines, centre, known, notes, excitation })
    }

    /// Poses that took part in the last pass.
    pub fn used(&self) -> usize {
        self.poses.iter().filter(|pose| pose.is_used()).count()
    }

    /// χ² of the poses that took part, and its degrees of freedom.
    pub fn chi_square(&self) -> (f64, f64) {
        let used = self.poses.iter().filter(|pose| pose.is_used());
        let sum = used.map(|pose| pose.chi_square).sum();
        (sum, (3 * self.used()) as f64 - 6.0)
    }

    /// Median of the poses' χ².
    pub fn median_chi_square(&self) -> f64 {
        let mut values: Vec<f64> =
            self.poses.iter().filter(|pose| pose.is_placed()).map(|pose| pose.chi_square).collect();
        values.sort_unstable_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(0.0)
    }

    /// Lines of the poses that were left out, with their χ².
    pub fn left_out(&self) -> Vec<(usize, f64)> {
        let all = self.poses.iter().zip(&self.lines);
        all.filter(|(pose, _)| !pose.is_used()).map(|(pose, line)| (*line, pose.chi_square)).collect()
    }
}
