//! A solution with factored equations, half of it a slice.

use super::Equations;
use crate::identification::hinge::pose::MAX_UNKNOWNS;
use crate::scalar::Real;

/// The solution under way.
#[derive(Clone, Copy, Debug)]
pub struct Solve<T> {
    x: [T; MAX_UNKNOWNS],
    halves: u8,
}

impl<T: Real> Solve<T> {
    /// Before the first half. `right`: the right-hand side.
    pub const fn new(right: [T; MAX_UNKNOWNS]) -> Self {
        Self { x: right, halves: 0 }
    }

    /// For a column of the inverse.
    pub fn column(unknown: usize) -> Self {
        Self::new(core::array::from_fn(|k| if k == unknown { T::one() } else { T::zero() }))
    }

    /// One slice; the solution in the slice after the last half.
    pub fn advance(&mut self, equations: &Equations<T>) -> Option<&[T; MAX_UNKNOWNS]> {
        let rows = 0..equations.unknowns();
        match self.halves {
            0 => equations.solve_forwards(&mut self.x, 0, rows),
            1 => equations.solve_backwards(&mut self.x, 0, rows),
            _ => return Some(&self.x),
        }
        self.halves += 1;
        None
    }
}
