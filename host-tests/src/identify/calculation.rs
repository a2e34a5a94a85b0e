//! The library's identification, run on a log in the precision asked for.

use super::input_error::InputError;
use super::lengths_file::LengthsFile;
use super::report::{Precision, Report, Setting, Start};
use super::rig_file;
use super::verification::Verification;
use crate::estimation::estimate;
use glenoid::identification::{EstimatorSettings, Identified, Machine, Noise, Progress, Refusal};
use glenoid::kinematics::CableLengths;
use glenoid::paper::{PaperIteration, PaperSettings};
use glenoid::rig::{Parameters, Rig};
use glenoid::scalar::Real;

/// How far off an unknown encoder zero may be, 1σ, mm: that of a machine that nobody homed.
const UNKNOWN_ZERO_MM: f64 = 10.0;

/// What is to be solved.
pub struct Problem<'a> {
    /// The machine.
    pub rig: &'a Rig<f64>,
    /// The poses.
    pub log: &'a LengthsFile,
    /// Which of them, and how.
    pub setting: Setting,
    /// The poses to verify on.
    pub second: Option<&'a LengthsFile>,
}

impl Problem<'_> {
    /// Solves it.
    ///
    /// # Errors
    /// [`InputError`] for a number that the precision asked for cannot hold.
    pub fn solve(&self) -> Result<Report, InputError> {
        match self.setting.precision {
            Precision::F32 => self.solve_in::<f32>(),
            Precision::F64 => self.solve_in::<f64>(),
        }
    }

    fn solve_in<T: Real>(&self) -> Result<Report, InputError> {
        let rig: Rig<T> = rig_file::in_precision(self.rig)
            .map_err(|error| InputError::Request(format!("the rig in this precision: {}", error.text())))?;
        let rows = self.log.rows();
        let used = self.setting.rows_used.iter();
        let poses: Vec<CableLengths<T>> = used.map(|row| self.log.cables(&rows[row])).collect::<Result<_, _>>()?;
        let zero_prior_mm = if self.setting.zeros { UNKNOWN_ZERO_MM } else { 0.0 };
        let (outcome, iterations) = match self.setting.start {
            None => self.run_full(&rig, &poses, zero_prior_mm),
            Some(start) => run_paper(&rig, &start, &poses),
        };
        let mut report = match &outcome {
            Ok(identified) => Report::accepted(identified, self.setting),
            Err(refusal) => Report::refused(refusal, iterations, self.setting),
        };
        if let (Ok(identified), true) = (&outcome, self.setting.zeros) {
            report.worst_sigma_if_homed_mm = self.worst_sigma_if_homed_mm(&rig, &poses, identified);
        }
        if let (Ok(identified), Some(second)) = (&outcome, self.second) {
            report.verification = Some(Verification::of(&rig, identified, second)?);
        }
        Ok(report)
    }

    /// The error bar of the centre from the same poses less the zeros that were found, as if these were known.
    fn worst_sigma_if_homed_mm<T: Real>(
        &self,
        rig: &Rig<T>,
        poses: &[CableLengths<T>],
        found: &Identified<T>,
    ) -> Option<f64> {
        let homed: Vec<_> = poses.iter().map(|pose| pose.less(&found.offsets_mm)).collect::<Result<_, _>>().ok()?;
        let identified = self.run_full(rig, &homed, 0.0).0.ok()?;
        Some(identified.worst_centre_sigma_mm().0.to_f64())
    }

    fn run_full<T: Real>(
        &self,
        rig: &Rig<T>,
        poses: &[CableLengths<T>],
        zero_prior_mm: f64,
    ) -> (Result<Identified<T>, Refusal>, u8) {
        let noise = match self.setting.given_noise_mm {
            Some(noise_mm) => Noise::Known(T::of(noise_mm)),
            None => Noise::EstimatedUpTo(T::of(self.setting.noise_limit_mm)),
        };
        let settings = EstimatorSettings { noise, ..EstimatorSettings::for_rig(rig) };
        let machine = Machine::with_offset_prior(rig, T::of(zero_prior_mm));
        let estimation = estimate(&machine, rig, settings, poses);
        (estimation.outcome, estimation.estimator.iterations())
    }
}

fn run_paper<T: Real>(rig: &Rig<T>, start: &Start, poses: &[CableLengths<T>]) -> (Result<Identified<T>, Refusal>, u8) {
    let start = Parameters::from_array(start.values_mm.map(T::of));
    let mut iteration = PaperIteration::new(rig, start, PaperSettings::default());
    loop {
        match iteration.advance(poses) {
            Progress::Working => {}
            Progress::Identified(identified) => return (Ok(identified), iteration.iterations()),
            Progress::Refused(refusal) => return (Err(refusal), iteration.iterations()),
        }
    }
}
