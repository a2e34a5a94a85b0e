//! The scatter of a pose's own joint centre about the model's: the humeral head slides in its socket. Its variance is
//! estimated from the residuals.

use crate::scalar::Real;

/// Scatter of the head in its socket to begin with, mm an axis (Ludewig et al. 2009, from bone pins).
const FIRST_SCATTER_MM: f64 = 0.35;
/// Smallest variance of the scatter, mm².
const MIN_SCATTER_MM2: f64 = 1e-4;

/// Variance along each axis, mm².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatter<T>(T);

impl<T: Real> Default for Scatter<T> {
    fn default() -> Self {
        Self(T::of(FIRST_SCATTER_MM * FIRST_SCATTER_MM))
    }
}

impl<T: Real> Scatter<T> {
    /// A scatter with this standard deviation along each axis, mm.
    pub fn of_sigma(sigma_mm: T) -> Self {
        Self((sigma_mm * sigma_mm).max(T::of(MIN_SCATTER_MM2)))
    }

    /// The variance along each axis, mm².
    pub fn variance_mm2(&self) -> T {
        self.0
    }

    /// The standard deviation along each axis, mm.
    pub fn sigma_mm(&self) -> T {
        self.0.root()
    }

    /// Moves the variance towards the one for which the median of χ² has its expected value. `ratio`: the median over
    /// that.
    pub fn follow_median(&mut self, ratio: T) {
        let bounded = ratio.max(T::of(0.1)).min(T::of(10.0));
        // To the power of three quarters: with the whole ratio the variance would swing.
        let root = bounded.root();
        self.0 = (self.0 * root * root.root()).max(T::of(MIN_SCATTER_MM2));
    }

    /// Improves the variance of the scatter, so that χ² equals its degrees of freedom (Paule and Mandel 1982, a step of
    /// Newton's method). `excess`: χ² less its degrees of freedom; `sensitivity`: by how much χ² falls with the
    /// variance, 1/mm². Returns the relative change.
    pub fn improve(&mut self, excess: T, sensitivity: T) -> T {
        let before = self.0;
        let least = (before * T::of(0.1)).max(T::of(MIN_SCATTER_MM2));
        let improved = before + excess / sensitivity;
        self.0 = if improved > least { improved } else { least };
        (self.0 - before).abs() / before
    }
}
