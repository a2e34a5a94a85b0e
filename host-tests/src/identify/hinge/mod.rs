//! `cargo identify` for a rig whose joint is a hinge.

mod remedy;
mod report;
mod summary;

pub use report::{DrawingOff, HingeReport, RefusalReport};

use super::input_error::InputError;
use super::lengths_file::LengthsFile;
use super::report::{Precision, Status};
use super::rig_file::{self, HingeRigFile};
use super::{MAX_TIMES_EXPECTED_NOISE, Request, units};
use glenoid::identification::Noise;
use glenoid::identification::hinge::{
    Drawing, Hinge, HingeEstimator, HingePose, HingeRefusal, HingeRig, HingeSettings, IdentifiedHinge, MAX_CABLES,
};
use glenoid::rig::{CableEnds, Pulley, RigError, Tolerance};
use glenoid::scalar::Real;
use std::path::Path;

/// A cable of an elbow that is so many times longer than most lengths of its log is none: one such length keeps the fit from all
/// others.
const MOST_TIMES_MEDIAN: f64 = 4.0;

/// The outcome of a request about a hinge.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// What was found.
    pub report: HingeReport,
    /// The same for people.
    pub summary: String,
    /// What was asked for but is not done for a hinge, in words.
    pub warnings: Vec<String>,
    /// What the file was taken for, in words.
    pub notes: Vec<String>,
}

/// A hinge's estimator at its end, with its poses.
pub struct Solved<T: Real> {
    /// The estimator.
    pub estimator: HingeEstimator<T>,
    /// The poses.
    pub poses: Vec<HingePose<T>>,
    /// What it has found.
    pub outcome: Result<IdentifiedHinge<T>, HingeRefusal>,
}

/// Reads the files and identifies; `None` where the rig's joint is no hinge.
///
/// # Errors
/// [`InputError`] names the place that cannot be read.
pub fn run(request: &Request) -> Result<Option<Finding>, InputError> {
    let Some(path) = request.rig.as_deref() else { return Ok(None) };
    let Some(HingeRigFile { rig, noise_mm: stated_mm }) = rig_file::read_hinge(path)? else { return Ok(None) };
    let rig = with_zeros(rig, request.zero_prior_mm)?;
    let noise_mm = request.noise_mm.or(stated_mm);
    let log = read_log(&request.lengths, &rig)?.with_repeated_rows_merged(noise_mm.unwrap_or(rig.length_noise_mm()));
    let mut report = match request.precision {
        Precision::F32 => report::of(&solve::<f32>(&rig, &log, noise_mm)?, &rig, request, noise_mm),
        Precision::F64 => report::of(&solve::<f64>(&rig, &log, noise_mm)?, &rig, request, noise_mm),
    };
    if report.status == Status::Refused {
        report.drawing_off = drawing_off(&rig, &log, noise_mm)?;
    }
    let notes = log.notes().iter().map(|note| format!("{}: {note}", log.file())).collect();
    let summary = summary::of(&report, &log);
    Ok(Some(Finding { report, summary, warnings: unused(request), notes }))
}

/// Reads a log of this rig, in millimetres.
///
/// # Errors
/// [`InputError`] names the first place that cannot be read, or a length that no cable has.
pub fn read_log(path: &Path, rig: &HingeRig<f64>) -> Result<LengthsFile, InputError> {
    let cables = rig.cables().len();
    let log = LengthsFile::read_of(path, cables)?;
    let lengths = || log.rows().iter().flat_map(|row| row.lengths_mm[..cables].iter().copied());
    let line = log.rows().first().map_or(1, |row| row.line);
    if let Some(complaint) = units::complaint_about_hinge(lengths(), rig.home_length_mm()) {
        return Err(log.at(line, 0, complaint));
    }
    let most_mm = units::median(lengths()) * MOST_TIMES_MEDIAN;
    for row in log.rows() {
        if let Some(cable) = row.lengths_mm[..cables].iter().position(|length| *length > most_mm) {
            let message = format!(
                "{} mm is more than {MOST_TIMES_MEDIAN} times the median length of the log: look for a slip of the decimal point",
                row.lengths_mm[cable]
            );
            return Err(log.at(row.line, cable, message));
        }
    }
    Ok(log)
}

/// Runs the estimator on every row of a log. `noise_mm`: 1σ of a length where it is known.
///
/// # Errors
/// [`InputError`] for a rig that a precision cannot hold.
pub fn solve<T: Real>(rig: &HingeRig<f64>, log: &LengthsFile, noise_mm: Option<f64>) -> Result<Solved<T>, InputError> {
    let rig = in_precision::<T>(rig).map_err(|error| InputError::Request(error.text().to_owned()))?;
    let noise = match noise_mm {
        Some(noise) => Noise::Known(T::of(noise)),
        None => Noise::EstimatedUpTo(rig.length_noise_mm() * T::of(MAX_TIMES_EXPECTED_NOISE)),
    };
    let settings = HingeSettings { noise, ..HingeSettings::for_rig(&rig) };
    let of_row = |lengths: &[f64]| std::array::from_fn(|k| T::of(lengths[k]));
    let mut poses: Vec<HingePose<T>> =
        log.rows().iter().map(|row| HingePose::new(of_row(&row.lengths_mm[..MAX_CABLES]))).collect();
    let mut estimator = HingeEstimator::new(&rig, settings);
    let outcome = estimator.run(&mut poses);
    Ok(Solved { estimator, poses, outcome })
}

/// How far the drawing is off, where the poses fit a hinge that its standard deviations exclude.
fn drawing_off(
    rig: &HingeRig<f64>,
    log: &LengthsFile,
    noise_mm: Option<f64>,
) -> Result<Option<DrawingOff>, InputError> {
    let Some(drawing) = rig.drawing().filter(|drawing| drawing.sigma.is_some()) else { return Ok(None) };
    let vague = rig.clone().with_drawing(Drawing { sigma: None, ..*drawing });
    let solved = solve::<f64>(&vague, log, noise_mm)?;
    let Ok(found) = &solved.outcome else { return Ok(None) };
    let (axis, at_mm) = (found.hinge.axis(), solved.estimator.axis_point().at_mm);
    let cosine = axis.dot(drawing.hinge.axis()).abs();
    Ok(Some(DrawingOff {
        axis_deg: cosine.min(1.0).acos().to_degrees(),
        place_mm: (at_mm - drawing.hinge.nearest_mm(&at_mm)).norm(),
    }))
}

/// The rig with encoder offsets that are known to this only.
fn with_zeros(rig: HingeRig<f64>, zero_prior_mm: Option<f64>) -> Result<HingeRig<f64>, InputError> {
    let Some(offset_mm) = zero_prior_mm else { return Ok(rig) };
    let (tolerance, home) = (Tolerance { offset_mm, ..*rig.tolerance() }, *rig.home_length_mm());
    rig.with_tolerance(tolerance, home).map_err(|error| InputError::Request(error.text().to_owned()))
}

/// The rig in a precision.
pub(crate) fn in_precision<T: Real>(rig: &HingeRig<f64>) -> Result<HingeRig<T>, RigError> {
    let point = |point: &nalgebra::Vector3<f64>| point.map(T::of);
    let ends = |cable: &CableEnds<f64>| CableEnds {
        base_mm: point(&cable.base_mm),
        end_mm: point(&cable.end_mm),
        pulley: Pulley { radius_mm: T::of(cable.pulley.radius_mm), axis: point(&cable.pulley.axis) },
    };
    let cables: Vec<_> = rig.cables().iter().map(ends).collect();
    let tolerance = rig.tolerance();
    let tolerance = Tolerance {
        base_mm: T::of(tolerance.base_mm),
        edges_mm: T::of(tolerance.edges_mm),
        offset_mm: T::of(tolerance.offset_mm),
        drum: T::of(tolerance.drum),
    };
    let cast = HingeRig::new(&cables, T::of(rig.length_noise_mm()))?
        .with_tolerance(tolerance, rig.home_length_mm().map(T::of))?;
    let Some(drawing) = rig.drawing() else { return Ok(cast) };
    let hinge = &drawing.hinge;
    Ok(cast.with_drawing(Drawing {
        hinge: Hinge::through(
            &point(hinge.axis()),
            &point(&hinge.platform_foot_mm()),
            &point(&hinge.axis_in_platform()),
            &point(hinge.foot_in_platform_mm()),
        ),
        sigma: drawing.sigma.map(|sigma| sigma.map(T::of)),
        range_rad: (T::of(drawing.range_rad.0), T::of(drawing.range_rad.1)),
    }))
}

fn unused(request: &Request) -> Vec<String> {
    let mut warnings = Vec::new();
    let mut warn = |option: &str| warnings.push(format!("{option} is not for a hinge, and was left out of account"));
    if request.start_mm.is_some() {
        warn("--start");
    }
    if request.method == super::report::Method::Paper {
        warn("--method paper");
    }
    if request.still.is_some() {
        warn("--still");
    }
    if request.verify.is_some() {
        warn("--verify");
    }
    if request.joint != glenoid::identification::JointChoice::Auto {
        warn("--joint");
    }
    warnings
}
