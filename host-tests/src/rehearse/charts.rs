//! The plots at the end of a rehearsal.

use super::options::Options;
use super::session::{Captured, Transcript};
use crate::plot::{self, Axis, Chart, Directions, PlotError, Series, Sphere};
use glenoid::identification::PaperSettings;
use nalgebra::Vector3;
use std::path::{Path, PathBuf};

/// Deviations before each step and after the last, mm, from the lengths that the board used.
#[derive(Debug, Clone, PartialEq)]
pub struct Convergence {
    /// The firmware's solver in the board's precision.
    pub single: Vec<f64>,
    /// The same in double precision.
    pub double: Vec<f64>,
    /// The paper's iteration from the nominal centre; None when it does not converge.
    pub paper: Option<Vec<f64>>,
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
    let points = |deviations: &[f64]| deviations.iter().enumerate().map(|(k, d)| (k as f64, *d)).collect();
    let mut subtitle = conditions.to_string();
    if convergence.paper.is_none() {
        subtitle += "\nthe paper's iteration does not converge from the nominal centre";
    }
    let chart =
        Chart::new("Convergence of the identification", Axis::count("iteration"), Axis::log10("deviation δE (mm)"));
    let chart = chart
        .subtitled(&subtitle)
        .with(Series::line("start-free, single precision as on the board", points(&convergence.single)))
        .with(Series::line("start-free, double precision", points(&convergence.double)));
    let chart = match &convergence.paper {
        Some(paper) => chart.with(Series::line("the paper's iteration from the nominal centre", points(paper))),
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
