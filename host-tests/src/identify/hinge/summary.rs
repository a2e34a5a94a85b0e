//! The report of a hinge for people.

use super::remedy;
use super::report::HingeReport;
use crate::identify::lengths_file::LengthsFile;
use crate::identify::summary::line;
use crate::identify::wording::{counted, fixed, pose, small};
use std::fmt::Write as _;

/// The report as text.
pub(super) fn of(report: &HingeReport, log: &LengthsFile) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = match &report.refusal {
        None => accepted(&mut text, report, log),
        Some(refusal) => {
            let reason = report.reason.unwrap_or_default();
            writeln!(text, "REFUSED: {reason}")
                .and_then(|()| line(&mut text, "seen", &remedy::seen(refusal, log)))
                .and_then(|()| match &report.drawing_off {
                    Some(off) => remedy::of_drawing(&mut text, off),
                    None => line(&mut text, "remedy", remedy::remedy(refusal)),
                })
        }
    };
    text
}

fn accepted(text: &mut String, report: &HingeReport, log: &LengthsFile) -> std::fmt::Result {
    let three = |numbers: &Option<[f64; 3]>, decimals: usize| {
        numbers.map_or_else(String::new, |numbers| numbers.map(|number| fixed(number, decimals)).join(", "))
    };
    let sigma = |value: Option<f64>, unit: &str| format!("(1 sigma {} {unit})", fixed(value.unwrap_or_default(), 2));
    writeln!(text, "ACCEPTED: a hinge")?;
    let axis = format!("{} {}", three(&report.axis, 4), sigma(report.axis_sigma_deg, "degrees"));
    line(text, "axis in base", &axis)?;
    let point = format!("{} mm {}", three(&report.point_mm, 2), sigma(report.point_sigma_mm, "mm across"));
    line(text, "through", &point)?;
    let axis = three(&report.axis_in_platform, 4);
    line(text, "platform's axis", &format!("{axis} {}", sigma(report.axis_in_platform_sigma_deg, "degrees")))?;
    let point = three(&report.point_in_platform_mm, 2);
    line(text, "through", &format!("{point} mm {}", sigma(report.point_in_platform_sigma_mm, "mm across")))?;
    line(text, "along the axis", &sigma(report.along_sigma_mm, "mm"))?;
    let flexion = report.flexion_deg.unwrap_or_default();
    let used = report.poses_used.unwrap_or_default();
    line(text, "poses", &format!("{} over {flexion:.0} degrees of flexion", counted(used, "pose")))?;
    let noise = small(report.noise_mm.unwrap_or_default());
    line(text, "residual", &format!("{} mm; noise {noise} mm", small(report.deviation_mm.unwrap_or_default())))?;
    for rejected in &report.rejected {
        let cable = rejected.cable.map_or("no single cable explains it".to_owned(), |cable| format!("cable {cable}"));
        line(text, "left out", &format!("{}: {cable}", pose(rejected.pose, log)))?;
    }
    if let Some(machine) = &report.machine {
        let list = |numbers: &[f64], decimals| {
            numbers.iter().map(|number| fixed(*number, decimals)).collect::<Vec<_>>().join(", ")
        };
        line(text, "zeros", &format!("{} mm", list(&machine.zeros_mm, 2)))?;
        line(text, "drum scales", &list(&machine.drum_scale, 5))?;
    }
    Ok(())
}
