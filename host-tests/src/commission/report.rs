//! The outcome, as JSON and for people.

use super::constants::Constant;
use super::determined::Determined;
use super::fit::Fit;
use super::normal_equations::Solution;
use super::refusal::Refused;
use serde::Serialize;
use std::fmt::Write as _;

/// Poses left out that are named; of more, their number is told.
const NAMED_POSES: usize = 20;

/// The outcome.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// "commissioned" or "refused".
    pub status: &'static str,
    /// Why it is refused, with file and line.
    pub reason: Option<String>,
    /// Standard deviation of a length, mm.
    pub noise_mm: Option<f64>,
    /// The logs.
    pub logs: Vec<LogReport>,
    /// The machine's constants that have a tolerance.
    pub constants: Vec<Constant>,
    /// What is well determined and what is not.
    pub determined: Vec<String>,
    /// What to record next.
    pub next: Vec<String>,
    /// Total 1σ of a next wearing's joint centre from thirty such poses: with the rig as stated, and as found, mm.
    pub next_centre_sigma_mm: Option<[f64; 2]>,
}

/// What was made of one log.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LogReport {
    /// Its name.
    pub file: String,
    /// Poses in it, repeated rows counted once.
    pub poses: usize,
    /// Poses that took part.
    pub used: usize,
    /// Lines of poses that were left out, the first of them.
    pub left_out_lines: Vec<usize>,
    /// χ² over its degrees of freedom.
    pub chi_square_ratio: f64,
    /// Its joint centre in {B}, mm.
    pub centre_mm: [f64; 3],
    /// 1σ of the same, mm.
    pub centre_sigma_mm: [f64; 3],
    /// Found minus stated place, mm.
    pub off_stated_mm: Option<[f64; 3]>,
}

impl Report {
    /// A refusal.
    pub fn refused(refused: &Refused) -> Self {
        Self {
            status: "refused",
            reason: Some(refused.to_string()),
            noise_mm: None,
            logs: Vec::new(),
            constants: Vec::new(),
            determined: Vec::new(),
            next: Vec::new(),
            next_centre_sigma_mm: None,
        }
    }

    /// A commissioned machine.
    pub fn commissioned(fit: &Fit<'_>, solution: &Solution, constants: Vec<Constant>, found: Determined) -> Self {
        let logs = fit.wearings.iter().zip(&solution.centre_covariances).map(|(wearing, covariance)| {
            let (chi_square, freedom) = wearing.chi_square();
            let centre = &wearing.centre.in_base_mm;
            let lines = wearing.left_out();
            LogReport {
                file: wearing.file.clone(),
                poses: wearing.poses.len(),
                used: wearing.used(),
                left_out_lines: lines.iter().take(NAMED_POSES).map(|(line, _)| *line).collect(),
                chi_square_ratio: chi_square / freedom,
                centre_mm: (*centre).into(),
                centre_sigma_mm: [0, 1, 2].map(|k| covariance[(k, k)].sqrt() * fit.noise_mm),
                off_stated_mm: wearing.known.as_ref().map(|known| (centre - known.in_base_mm).into()),
            }
        });
        Self {
            status: "commissioned",
            reason: None,
            noise_mm: Some(fit.noise_mm),
            logs: logs.collect(),
            constants,
            determined: found.known,
            next: found.next,
            next_centre_sigma_mm: Some(found.next_centre_sigma_mm),
        }
    }

    /// The same for people.
    pub fn summary(&self) -> String {
        let mut text = String::new();
        if let Some(reason) = &self.reason {
            let _ = writeln!(text, "refused: {reason}");
            return text;
        }
        let _ = writeln!(text, "noise of a length: {:.3} mm (1 sigma)\n", self.noise_mm.unwrap_or(f64::NAN));
        for log in &self.logs {
            let ([x, y, z], [sx, sy, sz]) = (log.centre_mm, log.centre_sigma_mm);
            let _ = write!(
                text,
                "{}: {} of {} poses, chi-square ratio {:.2}, centre ({x:.2}, {y:.2}, {z:.2}) ± ({sx:.2}, {sy:.2}, {sz:.2}) mm",
                log.file, log.used, log.poses, log.chi_square_ratio
            );
            if let Some([x, y, z]) = log.off_stated_mm {
                let _ = write!(text, ", ({x:+.2}, {y:+.2}, {z:+.2}) mm from where it is stated");
            }
            let _ = writeln!(text);
            if !log.left_out_lines.is_empty() {
                let lines: Vec<_> = log.left_out_lines.iter().map(usize::to_string).collect();
                let more = log.poses - log.used - lines.len();
                let more = if more > 0 { format!(" and {more} more") } else { String::new() };
                let _ = writeln!(text, "  left out, for they fit no common centre: line {}{more}", lines.join(", "));
            }
        }
        let _ =
            writeln!(text, "\n{:<8} {:>12} {:>12} {:>14} {:>14}", "", "stated", "found", "sigma before", "sigma now");
        for c in &self.constants {
            let digits = if c.unit.is_empty() { 5 } else { 3 };
            let _ = writeln!(
                text,
                "{:<8} {:>12.digits$} {:>12.digits$} {:>14.digits$} {:>14.digits$} {}",
                c.name, c.stated, c.found, c.stated_sigma, c.sigma, c.unit
            );
        }
        let _ = writeln!(text);
        for sentence in &self.determined {
            let _ = writeln!(text, "{sentence}");
        }
        if let Some([before, after]) = self.next_centre_sigma_mm {
            let _ = writeln!(
                text,
                "the joint centre of a next wearer, from 30 such poses: 1 sigma {after:.2} mm (with the rig as stated {before:.2} mm)"
            );
        }
        match &self.next[..] {
            [] => text.push_str("nothing more need be recorded\n"),
            next => next.iter().for_each(|advice| {
                let _ = writeln!(text, "next: {advice}");
            }),
        }
        text
    }
}
