//! When a watch grows suspicious: means of χ² over the samples of a moving arm.

use super::DetectorState;
use crate::scalar::Real;

/// Weight of a new sample in the running mean of χ².
const SHARE: f64 = 1.0 / 16.0;

/// Weight of a new sample in the slow mean of χ², and the maximum that one sample counts there, so that the first
/// samples of a slip hardly change it.
const USUAL_SHARE: f64 = 1.0 / 128.0;
const MAX_USUAL: f64 = 4.0;

/// Running mean of χ² per degree of freedom (1 when all is well) at which suspicion begins. The mean of sixteen
/// sound samples is 1 ± 0.2; ten is what 0.5 mm of slip leaves.
pub(super) const SUSPICIOUS: f64 = 10.0;

/// What a watch thinks of the samples so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct Suspicion<T> {
    chi_square: T,
    /// Slow mean of χ² per degree of freedom while all is well: 1, and more where what is in use is itself a little off.
    usual: T,
    state: DetectorState,
}

/// What a sample has changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Change {
    /// Nothing.
    None,
    /// Suspicion begins.
    Begins,
    /// Suspicion goes on: the sample is evidence.
    GoesOn,
}

impl<T: Real> Suspicion<T> {
    /// None.
    pub fn none() -> Self {
        Self { chi_square: T::one(), usual: T::one(), state: DetectorState::Quiet }
    }

    pub fn state(&self) -> DetectorState {
        self.state
    }

    /// Running mean of χ² per degree of freedom; 1 when all is well.
    pub fn chi_square(&self) -> T {
        self.chi_square
    }

    /// What that was on average while all was well, 1 or more.
    pub fn usual(&self) -> T {
        self.usual.max(T::one())
    }

    /// Back to quiet; what is usual stays.
    pub fn rearm(&mut self) {
        self.state = DetectorState::Quiet;
        self.chi_square = T::one();
    }

    /// Takes in χ² of a sample per degree of freedom.
    pub fn see(&mut self, chi_square: T) -> Change {
        self.chi_square += (chi_square - self.chi_square) * T::of(SHARE);
        if self.state == DetectorState::Quiet {
            self.usual += (chi_square.min(T::of(MAX_USUAL)) - self.usual) * T::of(USUAL_SHARE);
        }
        match self.state {
            DetectorState::Quiet if self.chi_square > T::of(SUSPICIOUS) => {
                self.state = DetectorState::Suspicious;
                Change::Begins
            }
            DetectorState::Suspicious => Change::GoesOn,
            DetectorState::Quiet | DetectorState::Warned => Change::None,
        }
    }

    /// The evidence is judged: it warns, or there was nothing.
    pub fn judged(&mut self, warns: bool) {
        if warns {
            self.state = DetectorState::Warned;
        } else {
            self.rearm();
        }
    }
}
