//! Rows that show one pose many times over.
//!
//! The device captures a pose only where the arm stands elsewhere than in every pose before. A log may hold the same
//! pose a hundred times; its errors (friction, hysteresis, rounding) are the same in all of them, and whoever counts
//! them as a hundred poses gets a standard deviation ten times too small.

use super::{LengthsFile, Row};
use crate::identify::wording::counted;
use glenoid::rig::CABLES;
use std::collections::HashMap;

/// Differences up to this many standard deviations of a length are noise: two lengths of one pose differ by √2 of one.
const EQUAL_WITHIN_SIGMAS: f64 = 4.0 * std::f64::consts::SQRT_2;

/// What stands together: the first row of a pose, and the sum of all its rows.
struct Group {
    first: Row,
    sum_mm: [f64; CABLES],
    rows: usize,
}

impl LengthsFile {
    /// The same log with rows whose lengths are all equal to within noise (`noise_mm`: standard deviation of a length, mm)
    /// made one row: the mean of them, at the line of the first. Said in the notes.
    #[must_use]
    pub fn with_repeated_rows_merged(mut self, noise_mm: f64) -> Self {
        let before = self.rows.len();
        self.rows = merged(&self.rows, noise_mm * EQUAL_WITHIN_SIGMAS);
        let repeated = before - self.rows.len();
        if repeated > 0 {
            self.notes.push(format!(
                "{repeated} of {before} rows repeat a pose that stands there already (all lengths equal to within the \
                 noise): they count as one pose each, as their mean; {} left",
                counted(self.rows.len(), "pose")
            ));
        }
        self
    }
}

/// Each row joins the first pose that it equals. A row is compared with the first of a pose, not with the last that has
/// joined: a slow motion does not become one pose.
fn merged(rows: &[Row], limit_mm: f64) -> Vec<Row> {
    let mut groups: Vec<Group> = Vec::with_capacity(rows.len());
    // Poses by the cell of their first two lengths: equal poses lie in the same cell or beside it.
    let mut cells: HashMap<[i64; 2], Vec<usize>> = HashMap::with_capacity(rows.len());
    for row in rows {
        let cell = [0, 1].map(|k| (row.lengths_mm[k] / limit_mm) as i64);
        let beside = [-1, 0, 1].into_iter().flat_map(|x| [-1, 0, 1].map(|y| [cell[0] + x, cell[1] + y]));
        let known = beside.filter_map(|cell| cells.get(&cell)).flatten().copied();
        let same = known.filter(|&group| are_equal(&groups[group].first, row, limit_mm)).min();
        match same {
            Some(group) => groups[group].add(row),
            None => {
                cells.entry(cell).or_default().push(groups.len());
                groups.push(Group { first: *row, sum_mm: row.lengths_mm, rows: 1 });
            }
        }
    }
    groups.iter().map(Group::mean).collect()
}

fn are_equal(one: &Row, other: &Row, limit_mm: f64) -> bool {
    one.lengths_mm.iter().zip(&other.lengths_mm).all(|(a, b)| (a - b).abs() <= limit_mm)
}

impl Group {
    fn add(&mut self, row: &Row) {
        self.sum_mm.iter_mut().zip(&row.lengths_mm).for_each(|(sum, length)| *sum += length);
        self.rows += 1;
    }

    /// A row that stands alone stays as it is, to the bit.
    fn mean(&self) -> Row {
        let samples = usize::from(self.first.samples).saturating_mul(self.rows);
        Row {
            lengths_mm: self.sum_mm.map(|sum| sum / self.rows as f64),
            samples: u16::try_from(samples).unwrap_or(u16::MAX),
            ..self.first
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(line: usize, lengths_mm: [f64; CABLES]) -> Row {
        Row { line, lengths_mm, samples: 1 }
    }

    #[test]
    fn rows_within_the_noise_are_one_pose_and_their_mean() {
        let rows = [row(2, [100.0; 6]), row(3, [200.0; 6]), row(4, [100.2; 6]), row(5, [100.0; 6])];
        let merged = merged(&rows, 0.3);
        assert_eq!(merged.len(), 2);
        assert_eq!((merged[0].line, merged[0].samples), (2, 3));
        assert!(merged[0].lengths_mm.iter().all(|length| (length - 300.2 / 3.0).abs() < 1e-12));
        assert_eq!(merged[1], rows[1]);
    }

    #[test]
    fn one_cable_that_differs_is_another_pose() {
        let rows = [row(2, [100.0; 6]), row(3, [100.0, 100.0, 100.0, 100.0, 100.0, 100.4])];
        assert_eq!(merged(&rows, 0.3), rows);
    }

    #[test]
    fn a_slow_motion_does_not_become_one_pose() {
        let rows: Vec<_> = (0..100).map(|k| row(k, [100.0 + 0.2 * k as f64; 6])).collect();
        let merged = merged(&rows, 0.3);
        assert!((45..=60).contains(&merged.len()), "19.8 mm in steps of at most 0.4 mm: {}", merged.len());
    }

    #[test]
    fn equal_rows_on_both_sides_of_a_cell_are_found() {
        let rows = [row(2, [299.99; 6]), row(3, [300.01; 6])];
        assert_eq!(merged(&rows, 0.3).len(), 1);
    }
}
