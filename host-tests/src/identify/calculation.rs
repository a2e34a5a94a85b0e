//! The library's identification, run on a log in the precision asked for.

use super::input_error::InputError;
use super::lengths_file::LengthsFile;
use super::report::{Method, Precision, Report, Start};
use super::rig_file;
use super::selection::RowsUsed;
use super::verification::Verification;
use glenoid::identification::{
    Identified, Noise, PaperIteration, PaperSettings, Progress, Refusal, Solver, SolverSettings,
};
use glenoid::kinematics::CableLengths;
use glenoid::rig::{Parameters, Rig};
use glenoid::scalar::Real;

/// Without `--noise`, residuals up to this standard deviation are taken for noise of the cables, mm: ten times what
/// the paper assumes and more than any encoder gives, but less than a strap that slips.
pub const MOST_ESTIMATED_NOISE_MM: f64 = 1.0;

/// What is to be solved.
pub struct Problem<'a> {
    /// The machine.
    pub rig: &'a Rig<f64>,
    /// The poses.
    pub log: &'a LengthsFile,
    /// Which of them.
    pub rows: RowsUsed,
    /// Which identification.
    pub method: Method,
    /// Where the paper's method begins.
    pub start: Start,
    /// Known noise of a cable length, mm.
    pub noise_mm: Option<f64>,
    /// The poses to verify on.
    pub second: Option<&'a LengthsFile>,
}

impl Problem<'_> {
    /// Solves it in precision `T`.
    ///
    /// # Errors
    /// [`InputError`] for a number that precision `T` cannot hold.
    pub fn solve<T: Real>(&self) -> Result<Report, InputError> {
        let rig: Rig<T> = rig_file::in_precision(self.rig)
            .map_err(|error| InputError::Request(format!("the rig in this precision: {}", error.text())))?;
        let rows = self.log.rows();
        let poses: Vec<CableLengths<T>> =
            self.rows.iter().map(|row| self.log.cables(&rows[row])).collect::<Result<_, _>>()?;
        let (outcome, iterations) = match self.method {
            Method::Full => self.run_full(&rig, &poses),
            Method::Paper => self.run_paper(&rig, &poses),
        };
        let mut report = match &outcome {
            Ok(identified) => Report::accepted(identified, self.rows),
            Err(refusal) => Report::refused(refusal, iterations, self.rows),
        };
        report.method = self.method;
        report.precision = if size_of::<T>() == size_of::<f32>() { Precision::F32 } else { Precision::F64 };
        report.noise_given = self.method == Method::Full && self.noise_mm.is_some();
        report.expected_noise_mm = self.rig.length_noise_mm();
        report.start = (self.method == Method::Paper).then_some(self.start);
        if let (Ok(identified), Some(second)) = (&outcome, self.second) {
            report.verification = Some(Verification::of(&rig, &identified.parameters, second)?);
        }
        Ok(report)
    }

    fn run_full<T: Real>(&self, rig: &Rig<T>, poses: &[CableLengths<T>]) -> (Result<Identified<T>, Refusal>, u8) {
        let noise = match self.noise_mm {
            Some(noise_mm) => Noise::Known(T::of(noise_mm)),
            None => Noise::EstimatedUpTo(T::of(MOST_ESTIMATED_NOISE_MM)),
        };
        let mut solver: Solver<T> = Solver::new(rig, SolverSettings { noise, ..SolverSettings::for_rig(rig) });
        // Slice by slice rather than in one run, to know how far a refused one came.
        loop {
            match solver.advance(poses) {
                Progress::Working => {}
                Progress::Identified(identified) => return (Ok(identified), solver.iterations()),
                Progress::Refused(refusal) => return (Err(refusal), solver.iterations()),
            }
        }
    }

    fn run_paper<T: Real>(&self, rig: &Rig<T>, poses: &[CableLengths<T>]) -> (Result<Identified<T>, Refusal>, u8) {
        let start = Parameters::from_array(self.start.values_mm.map(T::of));
        let mut iteration = PaperIteration::new(rig, start, PaperSettings::default());
        loop {
            match iteration.advance(poses) {
                Progress::Working => {}
                Progress::Identified(identified) => return (Ok(identified), iteration.iterations()),
                Progress::Refused(refusal) => return (Err(refusal), iteration.iterations()),
            }
        }
    }
}
