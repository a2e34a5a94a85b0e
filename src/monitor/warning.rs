//! What a watch warns of, and which of the possible causes it names.

use crate::scalar::Real;
use nalgebra::Vector3;

/// χ² per degree of freedom up to which a cause explains the evidence. 1 is noise alone; the equations are linear in
/// the slip, which adds a little at 3 mm.
const EXPLAINED: f64 = 4.0;

/// A cause with more unknowns must leave a χ² smaller by this factor than a simpler one that explains the evidence.
const CLEARLY: f64 = 1.4;

/// What has happened.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cause<T> {
    /// The joint moved in {B}: the base strap slipped. By how much, mm, axes of {B}.
    StrapSlipped(Vector3<T>),
    /// The joint moved in {P}: the cuff slipped on the arm. By how much, mm, axes of {P}.
    CuffSlipped(Vector3<T>),
    /// One cable slipped on its drum or stretched.
    CableSlipped {
        /// Cable, 1 to 6.
        cable: u8,
        /// Error of its length (reading minus true), mm.
        error_mm: T,
    },
    /// The centre moves with the arm's elevation: not a ball joint. Movement per 10 degrees, mm, axes of {B}.
    NotABall(Vector3<T>),
    /// Something has moved that none of the causes explains alone.
    Unknown,
}

/// A warning: the cause, and how well it explains the evidence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Warning<T> {
    /// The cause that explains the evidence best.
    pub cause: Cause<T>,
    /// χ² per degree of freedom before any explanation, and with this one; 1 is noise.
    pub chi_square: [T; 2],
}

/// A cause, the squares that it explains, mm², and how many unknowns it has; `None` where the evidence does not determine it.
pub(super) type Explanation<T> = Option<(Cause<T>, T, i32)>;

/// The squares of a suspicious stretch of motion, before any explanation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Squares<T> {
    samples: u16,
    squares_mm2: T,
    /// Degrees of freedom of a sample: lengths to spare.
    spare: i32,
}

impl<T: Real> Squares<T> {
    /// Of no sample yet; `spare` degrees of freedom each.
    pub fn none(spare: i32) -> Self {
        Self { samples: 0, squares_mm2: T::zero(), spare }
    }

    /// Adds those of a sample, mm².
    pub fn add(&mut self, squares_mm2: T) {
        self.samples = self.samples.saturating_add(1);
        self.squares_mm2 += squares_mm2;
    }

    /// Degrees of freedom of a sample.
    pub fn spare(&self) -> i32 {
        self.spare
    }

    /// Samples added.
    pub fn samples(&self) -> u16 {
        self.samples
    }

    /// The cause that explains the evidence; `None` when there is nothing to explain: less than `suspicious` per degree of
    /// freedom. `usual`: χ² per degree of freedom before the suspicion, 1 or more. `causes`: from the simplest to the richest.
    pub fn judge(&self, variance_mm2: T, suspicious: T, usual: T, causes: &[Explanation<T>]) -> Option<Warning<T>> {
        let before = self.left(T::zero(), 0) / variance_mm2;
        if before < suspicious {
            return None;
        }
        // The first that explains everything is named, else the best of all.
        let mut best = Warning { cause: Cause::Unknown, chi_square: [before, before] };
        for (cause, explained, unknowns) in causes.iter().flatten() {
            let after = self.left(*explained, *unknowns) / variance_mm2;
            if after <= T::of(EXPLAINED) && after < best.chi_square[1] {
                let first = best.cause == Cause::Unknown;
                // A cause with more unknowns must explain clearly more. Differences below the usual χ² do not count:
                // the noise and the error of what is in use leave that much anyway.
                if first || after.max(usual) * T::of(CLEARLY) < best.chi_square[1] {
                    best = Warning { cause: *cause, chi_square: [before, after] };
                }
            }
        }
        Some(best)
    }

    /// Squares per degree of freedom that an explanation leaves, mm².
    fn left(&self, explained: T, unknowns: i32) -> T {
        let freedom = (self.spare * i32::from(self.samples) - unknowns).max(1);
        (self.squares_mm2 - explained).max(T::zero()) / T::of_integer(freedom)
    }
}

/// The cable whose error explains most; `sums`: weight and gradient of each over the samples.
pub(super) fn best_cable<T: Real>(sums: &[(T, T)]) -> Explanation<T> {
    let explained = |&(weight, gradient): &(T, T)| {
        if weight > T::zero() { gradient * gradient / weight } else { T::zero() }
    };
    let (first, _) = sums.split_first()?;
    let better = |best: (u8, _), next: (u8, _)| if explained(next.1) > explained(best.1) { next } else { best };
    let (cable, best) = (1..).zip(sums).fold((1, first), better);
    let &(weight, gradient) = best;
    (weight > T::zero()).then(|| (Cause::CableSlipped { cable, error_mm: gradient / weight }, explained(best), 1))
}
