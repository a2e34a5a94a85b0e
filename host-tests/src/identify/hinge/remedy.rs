//! For every refusal of a hinge: what was seen, and what to do about it.

use super::report::{DrawingOff, RefusalReport};
use crate::identify::lengths_file::LengthsFile;
use crate::identify::summary::line;
use crate::identify::wording::{counted, fixed, pose};

/// What was seen, with its figures.
pub(super) fn seen(refusal: &RefusalReport, log: &LengthsFile) -> String {
    match *refusal {
        RefusalReport::TooFewPoses { poses, wanted } => {
            format!("{} in {}; {wanted} at least are wanted", counted(poses as usize, "pose"), log.file())
        }
        RefusalReport::BadLength { pose: at, cable } => format!("{}, cable {cable}", pose(at as usize, log)),
        RefusalReport::TooFewCables { cables, determined } => {
            format!("{cables} cables determine {determined} of the nine unknowns of a hinge")
        }
        RefusalReport::TooLittleFlexion { range_deg } => {
            format!("the poses bend it by {range_deg:.0} degrees; 30 at least are wanted")
        }
        RefusalReport::TwoAxesFit { angle_deg, distance_mm } => {
            format!("their directions differ by {angle_deg:.1} degrees, their places by {distance_mm:.0} mm")
        }
        RefusalReport::Weak { sigma_deg: Some(sigma), .. } => {
            format!(
                "1 sigma of {sigma:.1} degrees; at most 5 are accepted; with fewer than four cables, of the drawing 4"
            )
        }
        RefusalReport::Weak { part, sigma_mm, .. } => {
            let limit = if part == "along" { "20" } else { "10 (with fewer than four cables, of the drawing 4)" };
            format!("1 sigma of {:.1} mm; at most {limit} are accepted", sigma_mm.unwrap_or(f64::INFINITY))
        }
        RefusalReport::TooManyOutliers { rejected, poses } => format!("{rejected} of {poses}"),
        RefusalReport::SecondAxis { axis_in_platform, size_deg } => {
            let [x, y, z] = axis_in_platform.map(|component| fixed(component, 2));
            format!("by {size_deg:.1} degrees (1 sigma) about ({x}, {y}, {z}) in the platform")
        }
        RefusalReport::NotAHinge { residual_mm } => format!("{residual_mm:.2} mm are left of the lengths"),
    }
}

/// What to do.
pub(super) fn remedy(refusal: &RefusalReport) -> &'static str {
    match refusal {
        RefusalReport::TooFewPoses { .. } => "Hold the joint at more angles.",
        RefusalReport::BadLength { .. } => "Correct the row, or take it out.",
        RefusalReport::TooFewCables { .. } => {
            "Add cables; or give what the drawing knows of the hinge in the section [hinge], with sigma_deg and sigma_mm."
        }
        RefusalReport::TooLittleFlexion { .. } => {
            "Bend further: the axis shows only in the arc that the forearm describes."
        }
        RefusalReport::TwoAxesFit { .. } => {
            "Bend further, hold more poses; or say in the section [hinge] where the drawing puts the axis, better than it \
             does now. A machine whose \
             ends are turned by turns to one side and the other tells the two apart best."
        }
        RefusalReport::Weak { .. } => {
            "Bend further and hold more poses; or give the drawing as a prior in the section [hinge]."
        }
        RefusalReport::TooManyOutliers { .. } => {
            "Look for a cable that jams or an encoder that loses counts, and record again."
        }
        RefusalReport::SecondAxis { .. } => {
            "Keep the forearm from turning about that axis (pronation, a loose cuff) while the elbow bends, and record again. An \
             elbow whose carrying angle changes so much is no hinge."
        }
        RefusalReport::NotAHinge { .. } => {
            "Look for a loose cuff, exchanged cables or a wrong figure in the rig's file; give --noise, or [noise] in the rig's file, if the \
             cables are noisier than it says, and [tolerance] for what was measured by hand."
        }
    }
}

/// A hinge fits, but not where the drawing has it.
pub(super) fn of_drawing(text: &mut String, off: &DrawingOff) -> std::fmt::Result {
    let DrawingOff { axis_deg, place_mm } = off;
    let seen = format!(
        "without sigma_deg and sigma_mm of [hinge] a hinge fits: {axis_deg:.1} degrees and {place_mm:.1} mm off the drawing"
    );
    line(text, "fits better", &seen)?;
    line(
        text,
        "remedy",
        "Correct the drawing in the section [hinge], or make sigma_deg and sigma_mm as large as it is wrong.",
    )
}
