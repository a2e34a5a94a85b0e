//! Which rows of a long log are used: the identification holds no more poses than the drive board does.

use serde::Serialize;

/// The rows used, from 0: all of them, or as many as there is room for, evenly spread from the first to the last.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RowsUsed {
    /// Rows in the file.
    pub of: usize,
    /// Rows used.
    pub count: usize,
    /// First row used, from 0.
    pub first: usize,
    /// Rows from one used row to the next; the k-th row used is `k * step`, rounded down.
    pub step: f64,
    /// Last row used, from 0.
    pub last: usize,
}

impl RowsUsed {
    /// The rows to use of `rows` (at least one), when there is room for `room` (at least two) poses.
    pub fn of(rows: usize, room: usize) -> Self {
        let count = rows.min(room);
        let last = rows.saturating_sub(1);
        let step = if count > 1 { last as f64 / (count - 1) as f64 } else { 1.0 };
        Self { of: rows, count, first: 0, step, last }
    }

    /// Are some rows left aside?
    pub fn is_partial(&self) -> bool {
        self.count < self.of
    }

    /// The rows used, from 0, ascending.
    pub fn iter(&self) -> impl Iterator<Item = usize> + use<> {
        // In integers: no row is lost to rounding.
        let (count, last) = (self.count, self.last);
        (0..count).map(move |k| k * last / count.saturating_sub(1).max(1))
    }
}
