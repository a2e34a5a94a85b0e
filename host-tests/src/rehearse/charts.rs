//! The plots at the end of a rehearsal.

use super::session::Captured;
use crate::plot::{self, Axis, Chart, Directions, PlotError, Series, Sphere};
use glenoid::identification::PaperSettings;
use nalgebra::Vector3;
use std::path::{Path, PathBuf};

/// δE before each step and after the last: `single` in the board's precision, `double` as a reference, mm.
pub fn convergence(single: &[f64], double: &[f64], subtitle: &str) -> Chart {
    let points = |deviations: &[f64]| deviations.iter().enumerate().map(|(k, d)| (k as f64, *d)).collect();
    Chart::new("Convergence of the identification", Axis::count("iteration"), Axis::log10("deviation δE (mm)"))
        .subtitled(subtitle)
        .with(Series::line("single precision, as on the board", points(single)))
        .with(Series::line("double precision", points(double)))
        .with_level("tolerance ε", PaperSettings::<f64>::default().tolerance_mm)
}

/// Where the arm pointed in the poses of both sets.
pub fn coverage(identification: &[Captured], verification: &[Captured], tilt_deg: f64, subtitle: &str) -> Sphere {
    let directions = |captured: &[Captured]| {
        captured.iter().map(|captured| (captured.pose.rotation * Vector3::z()).into()).collect()
    };
    let rim_deg = (tilt_deg / 15.0).ceil().max(1.0) * 15.0;
    Sphere::new("Where the arm pointed", rim_deg)
        .subtitled(&format!("{subtitle}\nlong axis of the arm, seen along z of {{B}}; rings: tilt from home"))
        .with(Directions::new("poses to identify", directions(identification)))
        .with(Directions::new("poses to verify", directions(verification)))
}

/// The σ of the centre that the board predicted after each pose, and `limit_mm`. None when it never predicted one.
pub fn prediction(identification: &[Captured], final_sigma_mm: f64, subtitle: &str) -> Option<Chart> {
    let points: Vec<_> = (1..)
        .zip(identification)
        .filter_map(|(number, captured)| Some((f64::from(number), f64::from(captured.predicted_sigma_mm?))))
        .filter(|(_, sigma)| *sigma > 0.0)
        .collect();
    if points.is_empty() || final_sigma_mm <= 0.0 {
        return None;
    }
    let chart = Chart::new(
        "Expected error of the joint centre",
        Axis::count("captured poses").including(0.0),
        Axis::log10("σ of the centre (mm)"),
    );
    let chart = chart.subtitled(subtitle).with(Series::line("predicted by the board while collecting", points));
    Some(chart.with_level("stated with the result", final_sigma_mm))
}

/// Writes a figure under `folder` and notes its files.
///
/// # Errors
/// [`PlotError`].
pub fn save(figure: &dyn plot::Figure, folder: &Path, name: &str, files: &mut Vec<PathBuf>) -> Result<(), PlotError> {
    files.extend(plot::save(figure, &folder.join(name))?);
    Ok(())
}
