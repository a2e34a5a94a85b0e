//! The plots of an exercise with a slip: where the centre seems to be at each instant, and what the three redundant
//! lengths leave, calculated on the host from the counts that the board was given.

use super::slip::Exercise;
use crate::plot::{self, Axis, Chart, PlotError, Series};
use glenoid::can::result::Parameter;
use glenoid::identification::marginal_information::MarginalInformation;
use glenoid::kinematics::{AttitudeSolver, CableLengths, CableSet, Geometry, JointCentre, LengthJacobian};
use glenoid::rig::{CABLES, Parameters, Rig};
use nalgebra::{UnitQuaternion, Vector3};
use std::path::{Path, PathBuf};

/// What one sample tells.
struct Seen {
    at_s: f64,
    /// The instantaneous centre less the one in use, axes of {B}, mm.
    centre_mm: Vector3<f64>,
    /// Root mean square of what the three redundant lengths leave, mm.
    residual_mm: f64,
}

/// Writes both plots into `folder`; returns their files.
///
/// # Errors
/// [`PlotError`].
pub fn write(
    exercise: &Exercise,
    rig: &Rig<f64>,
    live: &[Parameter; 6],
    zeros_mm: &[f32; CABLES],
    folder: &Path,
) -> Result<Vec<PathBuf>, PlotError> {
    let seen = look(exercise, rig, live, zeros_mm);
    let mut subtitle = format!("slip at {:.1} s", exercise.slip.at_s);
    if let Some((report, at_s)) = exercise.warning {
        subtitle += &format!("; the board said {} at {at_s:.2} s", report.cause.name());
    }
    let time = || Axis::linear("time since the arm began to move (s)");
    let mut centre =
        Chart::new("Instantaneous joint centre less the one in use", time(), Axis::linear("mm")).subtitled(&subtitle);
    for (k, name) in ["x", "y", "z"].into_iter().enumerate() {
        centre = centre.with(Series::curve(name, seen.iter().map(|s| (s.at_s, s.centre_mm[k])).collect()));
    }
    let residual = Chart::new("What the redundant cable lengths leave", time(), Axis::linear("mm, root mean square"))
        .subtitled(&subtitle)
        .with(Series::curve("residual", seen.iter().map(|s| (s.at_s, s.residual_mm)).collect()))
        .with_level("noise that the rig states", rig.length_noise_mm());
    let mut files = plot::save(&centre, &folder.join("slip-centre"))?.to_vec();
    files.extend(plot::save(&residual, &folder.join("slip-residual"))?);
    Ok(files)
}

fn look(exercise: &Exercise, rig: &Rig<f64>, live: &[Parameter; 6], zeros_mm: &[f32; CABLES]) -> Vec<Seen> {
    let geometry = Geometry::new(rig);
    let parameters = Parameters::from_array(live.map(|parameter| f64::from(parameter.value_mm)));
    let in_use = JointCentre::from_parameters(&parameters, &geometry);
    let solver = AttitudeSolver { geometry: &geometry, centre: &in_use };
    let mut attitude: Option<UnitQuaternion<f64>> = None;
    let mut see = |at_s, counts: &[i32; CABLES]| {
        let raw = CableLengths::from_counts(rig, counts).ok()?;
        let lengths = raw.less(&zeros_mm.map(f64::from)).ok()?;
        let fit = match attitude {
            Some(before) => solver.track(before, &lengths, CableSet::ALL),
            None => solver.solve(&lengths, CableSet::ALL),
        };
        attitude = fit.map(|fit| fit.attitude);
        let rotation = *attitude?.to_rotation_matrix().matrix();
        let pose = MarginalInformation::new(&LengthJacobian::new(&geometry, &in_use, &rotation, &lengths)).ok()?;
        let centre_mm = pose.information().try_inverse()? * pose.gradient_mm();
        Some(Seen { at_s, centre_mm, residual_mm: (pose.squares_mm2() / 3.0).sqrt() })
    };
    exercise.samples.iter().filter_map(|sample| see(sample.at_s, &sample.counts)).collect()
}
