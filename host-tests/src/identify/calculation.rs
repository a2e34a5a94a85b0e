//! The library's identification, run on a log in the precision asked for.

use super::causes::{self, Cause, Causes};
use super::held_phase::{self, HeldPhase};
use super::held_report::HeldReport;
use super::input_error::InputError;
use super::lengths_file::{LengthsFile, Row};
use super::report::{Precision, Report, Setting, Start};
use super::rig_file::{self, RigFile};
use super::verification::Verification;
use crate::estimation::{Estimation, estimate_poses};
use glenoid::identification::{EstimatorSettings, Identified, Machine, Noise, Pose, Progress, Refusal};
use glenoid::kinematics::CableLengths;
use glenoid::paper::{PaperIteration, PaperSettings};
use glenoid::rig::{Parameters, Rig};
use glenoid::scalar::Real;
use std::ops::RangeInclusive;

/// Fewer poses tell no causes apart; more take longer than it is worth.
const POSES_TO_TELL_CAUSES: RangeInclusive<usize> = 10..=2_000;

/// Noise this many times above what the rig should have makes one look for a cause.
const LOOK_TWICE: f64 = 1.5;

/// What is to be solved.
pub struct Problem<'a> {
    /// The machine.
    pub rig_file: &'a RigFile,
    /// The poses.
    pub log: &'a LengthsFile,
    /// Which of them, and how.
    pub setting: Setting,
    /// The poses of the held phase.
    pub still: Option<&'a LengthsFile>,
    /// The poses to verify on.
    pub second: Option<&'a LengthsFile>,
    /// What each row of a table is the mean of, where the rig's noise is to be used.
    pub samples_a_row: Option<u16>,
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
        let rig: Rig<T> = rig_file::in_precision(&self.rig_file.rig)
            .map_err(|error| InputError::Request(format!("the rig in this precision: {}", error.text())))?;
        let rows = self.log.rows();
        let used = self.setting.rows_used.iter().map(|row| &rows[row]);
        match self.setting.start {
            None => self.solve_full(&rig, used),
            Some(start) => {
                let poses = used.map(|row| self.log.true_lengths(row, &rig)).collect::<Result<Vec<_>, _>>()?;
                let (outcome, iterations) = run_paper(&rig, &start, &poses);
                let mut report = match &outcome {
                    Ok(identified) => Report::accepted(identified, self.setting),
                    Err(refusal) => Report::refused(refusal, iterations, self.setting),
                };
                if let (Ok(identified), Some(second)) = (&outcome, self.second) {
                    report.verification = Some(Verification::of_paper(&rig, identified, second)?);
                }
                Ok(report)
            }
        }
    }

    fn solve_full<'r, T: Real>(&self, rig: &Rig<T>, rows: impl Iterator<Item = &'r Row>) -> Result<Report, InputError> {
        let machine = self.machine(rig);
        let poses = self.log.poses(rows, rig, self.samples_a_row)?;
        let settings = self.settings(rig);
        let (held, held_report) = match self.still {
            None => (None, None),
            Some(still) => {
                let held_poses = still.poses(still.rows().iter(), rig, self.samples_a_row)?;
                let HeldPhase { centre, left_out } = held_phase::run(&machine, rig, settings, held_poses.clone());
                let refused = centre.is_err();
                let mut held = HeldReport { poses: held_poses.len(), refused, left_out, logs_exchanged: false };
                match centre {
                    Ok(centre) => (Some(centre), Some(held)),
                    Err(refusal) => {
                        let is_moving = matches!(refusal, Refusal::NotHeld { .. });
                        held.logs_exchanged = is_moving && held_phase::identify(&machine, rig, settings, poses).is_ok();
                        let mut report = Report::refused_held(&refusal, held, self.setting);
                        report.cause = self.exchanged_cables(&held_poses);
                        return Ok(report);
                    }
                }
            }
        };
        let estimation = estimate_poses(&machine, rig, settings, held, poses);
        let mut report = match &estimation.outcome {
            Ok(_) => Report::of_estimation(&estimation, &machine, self.setting),
            Err(refusal) => Report::refused(refusal, estimation.estimator.iterations(), self.setting),
        };
        report.held = held_report;
        self.look_for_causes(&mut report, &estimation);
        if let (Ok(identified), Some(_)) = (&estimation.outcome, self.setting.zero_prior_mm) {
            report.worst_sigma_if_homed_mm = self.worst_sigma_if_homed_mm(rig, &estimation.poses, identified);
        }
        if let (Ok(identified), Some(second)) = (&estimation.outcome, self.second) {
            let second = second.poses(second.rows().iter(), rig, self.samples_a_row)?;
            report.verification = Some(Verification::of(&machine, &estimation.estimator, identified, &second));
        }
        Ok(report)
    }

    /// What explains the poses better, where they are refused for what a machine or a joint may have, or are accepted
    /// with residuals or constants that make one look twice. In double precision whatever was asked for.
    fn look_for_causes<T: Real>(&self, report: &mut Report, estimation: &Estimation<T>) {
        let poses = &estimation.poses;
        if !POSES_TO_TELL_CAUSES.contains(&poses.len()) {
            return;
        }
        let (expected_mm, noise_mm) = (self.setting.expected_noise_mm, self.noise_of_row_mm());
        let rig = &self.rig_file.rig;
        let machine = self.machine(rig);
        let Some(lengths) = in_double(poses) else { return };
        let row =
            |cause: Cause| Cause { pose: cause.pose.and_then(|pose| self.setting.rows_used.iter().nth(pose)), ..cause };
        let is_noisy = |found: &Identified<T>| found.noise_mm.to_f64() > expected_mm * LOOK_TWICE;
        match &estimation.outcome {
            Err(refusal) if may_have_a_cause(refusal) => {}
            Ok(found) if report.joint == Some("moving") || is_noisy(found) => {}
            Ok(_) => {
                let used = lengths.iter().zip(&estimation.poses).filter(|(_, pose)| pose.is_used());
                let used: Vec<_> = used.map(|(lengths, _)| *lengths).collect();
                report.contradiction = causes::contradiction(&machine, &used, noise_mm);
                return;
            }
            Err(_) => return,
        }
        report.cause = causes::find(rig, &machine, &lengths, noise_mm)
            .map(|causes| Causes { best: row(causes.best), or: causes.or.map(row) });
    }

    /// Two cables that are exchanged in all the held poses.
    fn exchanged_cables<T: Real>(&self, held: &[Pose<T>]) -> Option<Causes> {
        let lengths = in_double(held).filter(|lengths| POSES_TO_TELL_CAUSES.contains(&lengths.len()))?;
        causes::exchanged(&self.machine(&self.rig_file.rig), &lengths, self.noise_of_row_mm())
    }

    fn noise_of_row_mm(&self) -> f64 {
        match self.samples_a_row {
            Some(_) => self.rig_file.row_noise_mm(),
            None => self.setting.given_noise_mm.unwrap_or(self.setting.expected_noise_mm),
        }
    }

    /// The standard deviation of the centre from the same poses less the offsets that were found, as if these were known.
    fn worst_sigma_if_homed_mm<T: Real>(&self, rig: &Rig<T>, poses: &[Pose<T>], found: &Identified<T>) -> Option<f64> {
        let homed = |pose: &Pose<T>| {
            let mut homed = Pose::new(pose.lengths().less(&found.offsets_mm).ok()?);
            homed.samples = pose.samples;
            Some(homed)
        };
        let homed = poses.iter().map(homed).collect::<Option<Vec<_>>>()?;
        let machine = Machine::with_offset_prior(rig, T::zero());
        let identified = estimate_poses(&machine, rig, self.settings(rig), None, homed).outcome.ok()?;
        Some(identified.worst_centre_sigma_mm().0.to_f64())
    }

    fn machine<T: Real>(&self, rig: &Rig<T>) -> Machine<T> {
        match self.setting.zero_prior_mm {
            Some(prior) => Machine::with_offset_prior(rig, T::of(prior)),
            None => self.rig_file.machine(rig),
        }
    }

    fn settings<T: Real>(&self, rig: &Rig<T>) -> EstimatorSettings<T> {
        let noise = match self.setting.given_noise_mm {
            Some(noise_mm) => Noise::Known(T::of(noise_mm)),
            None => Noise::EstimatedUpTo(T::of(self.setting.noise_limit_mm)),
        };
        EstimatorSettings { noise, joint: self.setting.joint, ..EstimatorSettings::for_rig(rig) }
    }
}

/// The lengths of the poses in double precision.
fn in_double<T: Real>(poses: &[Pose<T>]) -> Option<Vec<CableLengths<f64>>> {
    poses.iter().map(|pose| CableLengths::new(pose.lengths().as_mm().map(Real::to_f64)).ok()).collect()
}

/// Is it a refusal of what was measured, not of how few or how alike the poses are?
const fn may_have_a_cause(refusal: &Refusal) -> bool {
    matches!(
        refusal,
        Refusal::TooManyOutliers { .. }
            | Refusal::CentreNotFixed { .. }
            | Refusal::TooFewForMovingCentre { .. }
            | Refusal::MissingMotion { .. }
            | Refusal::SlippedMidway { .. }
            | Refusal::NotExplained { .. }
            | Refusal::MachineNotAsStated
            | Refusal::PlatformDoesNotClose { .. }
            | Refusal::IterationCap
            | Refusal::Singular
    )
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
