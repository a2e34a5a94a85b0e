//! The figures of many sets, and the limits that they are held against.

use super::super::findings::{Target, percent, short};
use super::super::statistics::root_mean_square;
use super::outcome::Path;
use glenoid::identification::Refusal;
use std::collections::BTreeMap;

/// What is asked of the errors of a row, mm rms; `None` where nothing is.
#[derive(Clone, Copy, Debug, Default)]
pub struct Limits {
    /// The path of the centre.
    pub path_mm: Option<f64>,
    /// Of that, across the arm.
    pub across_mm: Option<f64>,
    /// The end-points.
    pub end_points_mm: Option<f64>,
    /// The live centre.
    pub live_mm: Option<f64>,
}

/// Of many sets.
pub struct Figures {
    sets: usize,
    accepted: usize,
    /// Root mean square over the accepted, mm.
    pub path_mm: f64,
    across_mm: f64,
    end_points_mm: f64,
    live_mm: f64,
    covered: f64,
    wrong: usize,
}

impl Figures {
    /// Of sets; what was refused is added to the remarks.
    pub fn of(paths: &[Result<Path, Refusal>], remarks: &mut Vec<String>) -> Self {
        let accepted: Vec<Path> = paths.iter().filter_map(|path| path.as_ref().ok()).copied().collect();
        let mut refused = BTreeMap::<&str, usize>::new();
        for refusal in paths.iter().filter_map(|path| path.as_ref().err()) {
            *refused.entry(refusal.text()).or_default() += 1;
        }
        remarks.extend(refused.iter().map(|(text, count)| format!("refused, {count} of {}: {text}", paths.len())));
        let rms = |of: fn(&Path) -> f64| root_mean_square(accepted.iter().map(of));
        Self {
            sets: paths.len(),
            accepted: accepted.len(),
            path_mm: rms(|path| path.centre_mm),
            across_mm: rms(|path| path.across_mm),
            end_points_mm: rms(|path| path.end_points_mm),
            live_mm: rms(|path| path.live_mm),
            covered: accepted.iter().map(|path| path.covered).sum::<f64>() / accepted.len() as f64,
            wrong: accepted.iter().filter(|path| path.is_wrong).count(),
        }
    }

    /// As a row of the table.
    pub fn row(&self, machine: &str, base: &str, poses: usize, phases: usize) -> [String; 11] {
        [
            machine.to_owned(),
            base.to_owned(),
            poses.to_string(),
            phases.to_string(),
            percent(self.accepted, self.sets),
            short(self.path_mm),
            short(self.across_mm),
            short(self.end_points_mm),
            short(self.live_mm),
            format!("{:.1} %", 100.0 * self.covered),
            self.wrong.to_string(),
        ]
    }

    /// The limits that hold for every row: share accepted, coverage, nothing wrong; and those asked.
    pub fn targets(&self, name: &str, asked: &Limits) -> Vec<Target> {
        let share = self.accepted as f64 / self.sets as f64;
        let mut targets = vec![
            Target::at_least(format!("{name}: share accepted"), 0.95, share),
            Target::between(format!("{name}: 99 % bar covers"), (0.96, 1.0), self.covered),
            Target::at_most(format!("{name}: wrong"), 0.0, self.wrong as f64),
        ];
        let sizes = [
            ("path", asked.path_mm, self.path_mm),
            ("across the arm", asked.across_mm, self.across_mm),
            ("end-points", asked.end_points_mm, self.end_points_mm),
            ("live centre", asked.live_mm, self.live_mm),
        ];
        let held = |(what, limit, measured): (&str, Option<f64>, f64)| {
            Some(Target::at_most(format!("{name}: {what} (mm)"), limit?, measured))
        };
        targets.extend(sizes.into_iter().filter_map(held));
        targets
    }
}
