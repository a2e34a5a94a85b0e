//! Cuffs that sit askew: the arm's direction, in which its centre moves, is not the normal of the platform.

use super::super::findings::{Plan, Table, Target};
use super::figures::{Figures, Limits};
use super::set::Trouble;
use super::{COLUMNS, EXACT, Outcome, Sets, TILTS_DEG, WORN, by_phases, sets};

/// How far askew, 1σ about each axis across the arm, degrees: what the bar allows for, and more.
const ASKEW_DEG: [f64; 2] = [5.0, 8.0];
const POSES: usize = 60;

/// Exact machines over all mountings of the base.
pub fn cuffs(plan: &Plan) -> (Table, Vec<Target>) {
    let mut table = Table::new("shoulder-askew", "Cuffs askew to the arm, 1σ about each axis across it", &COLUMNS);
    let mut targets = Vec::new();
    for askew_deg in ASKEW_DEG {
        let of = |follow: f64, tilt_deg: f64| {
            sets(plan, &Sets { machine: EXACT, follow, tilt_deg, poses: POSES, trouble: Trouble::None, askew_deg })
        };
        let of_base = |(_, follow)| TILTS_DEG.into_iter().flat_map(move |tilt_deg| of(follow, tilt_deg));
        let outcomes: Vec<Outcome> = WORN.into_iter().flat_map(of_base).collect();
        for (phases, paths) in by_phases(&outcomes) {
            let figures = Figures::of(&paths, &mut Vec::new());
            let name = format!("{askew_deg}° askew");
            table.push(figures.row(&name, "all", POSES, phases));
            targets.extend(figures.targets(&format!("{name}, {phases} phases"), &Limits::default()));
        }
    }
    (table, targets)
}
