//! The plots at the end of a rehearsal.

use super::options::Options;
use super::replay::PaperRun;
use super::transcript::{Captured, Transcript};
use crate::plot::{self, Axis, Chart, Directions, PlotError, Series, Sphere};
use glenoid::identification::Identified;
use glenoid::paper::PaperSettings;
use glenoid::scalar::Real;
use nalgebra::Vector3;
use std::path::{Path, PathBuf};

/// How the deviation of one identification fell, from the lengths that the board used.
#[derive(Debug, Clone, PartialEq)]
pub struct Descent {
    /// Deviations step by step, mm; the last one after the last step.
    pub deviations_mm: Vec<f64>,
    /// Steps that had been taken at the first of them: 0 for an iteration from a start, 1 for a solver that has no
    /// deviation before its first step, because it needs no start.
    pub first: usize,
}

impl Descent {
    /// The descent of an identification.
    pub fn of<T: Real>(identified: &Identified<T>) -> Self {
        let deviations_mm: Vec<f64> = identified.rms_residuals_mm.iter().map(|deviation| deviation.to_f64()).collect();
        let first = (usize::from(identified.iterations) + 1).saturating_sub(deviations_mm.len());
        Self { deviations_mm, first }
    }

    fn points(&self) -> Vec<(f64, f64)> {
        (self.first..).map(|step| step as f64).zip(self.deviations_mm.iter().copied()).collect()
    }
}

/// Three identifications from the same lengths.
#[derive(Debug, Clone, PartialEq)]
pub struct Convergence {
    /// The firmware's solver in the board's precision.
    pub single: Descent,
    /// The same in double precision.
    pub double: Descent,
    /// The paper's iteration; None when it converges from nowhere near.
    pub paper: Option<PaperRun>,
}

/// Writes all plots into `folder`; returns their files.
///
/// # Errors
/// [`PlotError`].
pub fn write(
    transcript: &Transcript,
    convergence: &Convergence,
    options: &Options,
    folder: &Path,
) -> Result<Vec<PathBuf>, PlotError> {
    let conditions = format!(
        "{} poses, cable noise ±{} mm, tilt to {}°, seed {}",
        options.poses, options.noise, options.tilt, options.seed
    );
    let mut files = plot::save(&converging(convergence, &conditions), &folder.join("convergence"))?.to_vec();
    files.extend(plot::save(&coverage(transcript, options.tilt, &conditions), &folder.join("coverage"))?);
    if let Some(chart) = prediction(transcript, &conditions) {
        files.extend(plot::save(&chart, &folder.join("prediction"))?);
    }
    Ok(files)
}

/// δE step by step.
fn converging(convergence: &Convergence, conditions: &str) -> Chart {
    let mut subtitle =
        format!("{conditions}\nroot mean square of what is left of the cable lengths (paper: of the platform's edges)");
    if convergence.paper.as_ref().is_none_or(|paper| paper.share > 0.0) {
        subtitle +=
            "\nfrom the nominal centre the paper's iteration does not converge: some tetrahedron does not close";
    }
    let x = Axis::count("iteration").including(0.0);
    let chart = Chart::new("Convergence of the identification", x, Axis::log10("deviation (mm)"))
        .subtitled(&subtitle)
        .with(Series::line("start-free estimator, single precision as on the board", convergence.single.points()))
        .with(Series::line("start-free estimator, double precision", convergence.double.points()));
    let chart = match &convergence.paper {
        Some(paper) => {
            let label = format!("paper's iteration, start {:.1} mm off", paper.start_off_mm);
            chart.with(Series::line(&label, Descent::of(&paper.identified).points()))
        }
        None => chart,
    };
    chart.with_level("the paper's tolerance ε", PaperSettings::<f64>::default().tolerance_mm)
}

/// Where the arm pointed in the poses of both sets.
fn coverage(transcript: &Transcript, tilt_deg: f64, conditions: &str) -> Sphere {
    let directions = |captured: &[Captured]| {
        captured.iter().map(|captured| (captured.pose.rotation * Vector3::z()).into()).collect()
    };
    let rim_deg = (tilt_deg / 15.0).ceil().max(1.0) * 15.0;
    Sphere::new("Where the arm pointed", rim_deg)
        .subtitled(&format!("{conditions}\nlong axis of the arm, seen along z of {{B}}; rings: tilt from home"))
        .with(Directions::new("poses to identify", directions(&transcript.identification)))
        .with(Directions::new("poses to verify", directions(&transcript.verification)))
}

/// The σ of the centre that the board predicted after each pose. None when it never predicted one.
fn prediction(transcript: &Transcript, conditions: &str) -> Option<Chart> {
    let points: Vec<_> = (1..)
        .zip(&transcript.identification)
        .filter_map(|(number, captured)| Some((f64::from(number), f64::from(captured.predicted_sigma_mm?))))
        .collect();
    // A σ below the resolution of its message comes as zero, which has no place on a logarithmic axis.
    if points.is_empty() || points.iter().any(|(_, sigma)| *sigma <= 0.0) {
        return None;
    }
    let x = Axis::count("captured poses").including(0.0);
    let chart = Chart::new("Expected error of the joint centre", x, Axis::log10("σ of the centre (mm)"));
    Some(chart.subtitled(conditions).with(Series::line("predicted by the board while it collects", points)))
}
