//! The normal equations at the present estimate, a few rows a slice.

use super::Fit;
use crate::identification::hinge::pose::{HingePose, PoseAt, PoseRows};
use crate::identification::hinge::rig::MAX_CABLES;
use crate::scalar::Real;

/// Rows that a slice adds where the machine's constants take part: a row of 33 unknowns takes as long as ten of 9.
const LONG_ROWS_A_SLICE: usize = 2;

/// The sum under way.
#[derive(Clone, Copy, Debug)]
pub struct Equate {
    /// The next pose, or the one whose rows are being added.
    next: usize,
    /// Its next row; none while it has no rows yet.
    row: Option<usize>,
    has_begun: bool,
}

impl Equate {
    /// Before the first pose.
    pub const fn new() -> Self {
        Self { next: 0, row: None, has_begun: false }
    }

    /// One slice; true at the end.
    pub fn advance<T: Real>(&mut self, fit: &mut Fit<T>, rows: &mut PoseRows<T>, poses: &[HingePose<T>]) -> bool {
        if !self.has_begun {
            fit.equations.clear(fit.unknowns());
            self.has_begun = true;
        }
        if let Some(row) = self.row {
            self.add(fit, rows, row, LONG_ROWS_A_SLICE);
            return false;
        }
        while poses.get(self.next).is_some_and(|pose| !pose.is_used()) {
            self.next += 1;
        }
        let Some(pose) = poses.get(self.next) else {
            fit.add_priors();
            return true;
        };
        rows.set(&PoseAt::new(&fit.hinge, &fit.machine), &pose.lengths_mm, pose.angle_rad, fit.constants);
        let by_angle = rows.by_angle;
        rows.eliminate(&by_angle, fit.unknowns());
        rows.scale(pose.weight.root());
        self.add(fit, rows, 0, if fit.constants { 0 } else { MAX_CABLES });
        false
    }

    /// Adds some of the pose's rows; after the last one the next pose follows.
    fn add<T: Real>(&mut self, fit: &mut Fit<T>, rows: &PoseRows<T>, from: usize, count: usize) {
        let cables = fit.machine.cables();
        let pairs = rows.jacobian.iter().zip(&rows.residual_mm).take(cables);
        pairs.skip(from).take(count).for_each(|(row, residual)| fit.equations.add_row(row, *residual));
        self.row = Some(from + count).filter(|next| *next < cables);
        if self.row.is_none() {
            self.next += 1;
        }
    }
}
