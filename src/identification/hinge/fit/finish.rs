//! The last, undamped step; then the equations are factored for the covariance, and the poses have their χ².

use super::equate::Equate;
use super::place::Place;
use super::scratch::{PRODUCTS_A_SLICE, Scratch};
use super::solve::Solve;
use super::{Estimate, Fit, take_angles};
use crate::identification::hinge::pose::HingePose;
use crate::linear_algebra::Singular;
use crate::scalar::Real;

/// A last step that leaves more squares than this, in variances of the noise, is taken back.
const WORSE: f64 = 0.01;

/// The end of a fit under way.
#[derive(Clone, Debug)]
pub enum Finish<T: Real> {
    /// The equations for the step.
    Equate(Equate),
    /// They are factored, solved, and the step is taken.
    Factor,
    Solve(Solve<T>),
    /// The poses' angles after the step from this estimate.
    Try {
        before: Estimate<T>,
        place: Place<T>,
    },
    /// The same after it was taken back.
    Back(Place<T>),
    /// The next pose to get its χ².
    Settle(usize),
    /// The equations for the covariance.
    EquateAgain(Equate),
    /// They are factored.
    FactorAgain,
}

impl<T: Real> Finish<T> {
    /// Before the step.
    pub const fn new() -> Self {
        Self::Equate(Equate::new())
    }

    /// One slice; the outcome at the end: [`Singular`] when some combination of the unknowns is not determined.
    pub fn advance(
        &mut self,
        fit: &mut Fit<T>,
        scratch: &mut Scratch<T>,
        poses: &mut [HingePose<T>],
    ) -> Option<Result<(), Singular>> {
        match self {
            Self::Equate(equate) => {
                if equate.advance(fit, &mut scratch.rows, poses) {
                    *self = Self::Factor;
                }
            }
            Self::Factor => match fit.equations.factor_some(PRODUCTS_A_SLICE) {
                Err(Singular) => return Some(Err(Singular)),
                Ok(()) if fit.equations.is_factored() => {
                    *self = Self::Solve(Solve::new(*fit.equations.gradient()));
                }
                Ok(()) => {}
            },
            Self::Solve(solve) => {
                let step = solve.advance(&fit.equations)?;
                let before = fit.estimate();
                fit.take(step);
                *self = Self::Try { before, place: Place::new(false) };
            }
            Self::Try { before, place } => {
                let squares = place.advance(fit, &mut scratch.angles, poses)?;
                if squares <= fit.squares_mm2 + fit.noise_mm * fit.noise_mm * T::of(WORSE) {
                    fit.squares_mm2 = squares;
                    take_angles(poses);
                    *self = Self::Settle(0);
                } else {
                    fit.set_estimate(*before);
                    *self = Self::Back(Place::new(false));
                }
            }
            Self::Back(place) => {
                place.advance(fit, &mut scratch.angles, poses)?;
                *self = Self::Settle(0);
            }
            Self::Settle(next) => match poses.get_mut(*next) {
                Some(pose) => {
                    fit.settle(pose);
                    *next += 1;
                }
                None => *self = Self::EquateAgain(Equate::new()),
            },
            Self::EquateAgain(equate) => {
                if equate.advance(fit, &mut scratch.rows, poses) {
                    *self = Self::FactorAgain;
                }
            }
            Self::FactorAgain => match fit.equations.factor_some(PRODUCTS_A_SLICE) {
                Ok(()) if !fit.equations.is_factored() => {}
                outcome => return Some(outcome),
            },
        }
        None
    }
}
