//! Memory for what is worked on between two slices.

use super::Equations;
use crate::identification::hinge::joint::HINGE_UNKNOWNS;
use crate::identification::hinge::pose::{AngleSearch, PoseRows};
use crate::scalar::Real;

/// Multiplications of a slice with a factor: about 8 000 cycles of a Cortex-M4F.
pub const PRODUCTS_A_SLICE: usize = 700;

/// What a slice leaves to the next one.
#[derive(Clone, Debug)]
pub struct Scratch<T: Real> {
    /// Equations that are factored while the fit's own stay as they are.
    pub equations: Equations<T>,
    /// Where the search for angles begins.
    pub angles: AngleSearch<T>,
    /// A pose on its way into the equations.
    pub rows: PoseRows<T>,
}

impl<T: Real> Scratch<T> {
    /// Nothing.
    pub fn new() -> Self {
        Self { equations: Equations::new(HINGE_UNKNOWNS), angles: AngleSearch::nowhere(), rows: PoseRows::none() }
    }
}
