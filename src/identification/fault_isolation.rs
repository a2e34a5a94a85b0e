//! Fault isolation: which cable made a pose contradict the others?
//!
//! With the centre known a pose has three redundant lengths, so any one cable can be left out and the other five
//! still tested (two degrees of freedom). The cable without which the pose fits is faulty. When no single cable
//! is, two may have been exchanged.

use crate::kinematics::{AttitudeFit, AttitudeSolver, CableLengths, CableSet};
use crate::rig::CABLES;
use crate::scalar::Real;
use nalgebra::UnitQuaternion;

/// χ² with two degrees of freedom up to which the five other cables count as sound: once in 8 000 poses they do not.
const SOUND: f64 = 18.0;
/// The same for all six cables after an exchange, three degrees of freedom.
const SOUND_AFTER_EXCHANGE: f64 = 25.0;
/// A second cable that explains the pose worse by less than this in χ² looks alike, and is named too.
const LOOKS_ALIKE: f64 = 9.0;

/// The faulty cables: bit k set, cable k + 1.
pub type Cables = u8;

/// Ways to a rotation that answers a question: from the known one, then in each of the four assembly modes.
const ATTEMPTS: u8 = 5;

/// The questions about one pose: first for each cable whether the pose fits without it, then for each two of them whether
/// they were exchanged. One attempt at one question a slice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Isolation<T> {
    /// The cables of the present question (from 0) are `first` and `first + apart`.
    first: usize,
    apart: usize,
    attempt: u8,
    /// Best χ² of the present question so far.
    best: T,
    /// χ² without each cable; infinite where no rotation fits.
    without: [T; CABLES],
}

impl<T: Real> Default for Isolation<T> {
    fn default() -> Self {
        let infinite = T::of(f64::INFINITY);
        Self { first: 0, apart: 0, attempt: 0, best: infinite, without: [infinite; CABLES] }
    }
}

impl<T: Real> Isolation<T> {
    /// One attempt; the answer when it is known, 0 when no cable or exchange explains the pose.
    ///
    /// `known`: the pose's rotation with all cables, near which the right one is sought first.
    pub fn advance(
        &mut self,
        solver: &AttitudeSolver<'_, T>,
        known: &UnitQuaternion<T>,
        lengths: &CableLengths<T>,
        variance_mm2: T,
    ) -> Option<Cables> {
        let (first, second) = (self.first, self.first + self.apart);
        let is_exchange = self.apart > 0;
        let cables = if is_exchange { CableSet::ALL } else { CableSet::all_but(first) };
        let limit = T::of(if is_exchange { SOUND_AFTER_EXCHANGE } else { SOUND });
        let lengths = lengths.exchanged(first, second);
        let fit = match self.attempt.checked_sub(1) {
            None => solver.track(*known, &lengths, cables),
            Some(mode) => solver.solve_in(mode, &lengths, cables),
        };
        if let Some(AttitudeFit { squares_mm2, .. }) = fit {
            let chi_square = squares_mm2 / variance_mm2;
            self.best = if chi_square < self.best { chi_square } else { self.best };
        }
        self.attempt += 1;
        // What fits near the known rotation needs no other.
        if self.attempt < ATTEMPTS && !(self.best <= limit) {
            return None;
        }
        let chi_square = core::mem::replace(&mut self.best, T::of(f64::INFINITY));
        self.attempt = 0;
        if let (false, Some(without)) = (is_exchange, self.without.get_mut(first)) {
            *without = chi_square;
        }
        self.first += 1;
        let all_asked = second + 1 == CABLES;
        if all_asked {
            (self.first, self.apart) = (0, self.apart + 1);
        }
        if is_exchange && chi_square <= limit {
            return Some(1 << first | 1 << second);
        }
        let single = if !is_exchange && all_asked { self.single_cables() } else { 0 };
        (single != 0 || self.apart == CABLES).then_some(single)
    }

    /// The cables without which the pose fits; none when it never does.
    fn single_cables(&self) -> Cables {
        let smaller = |a: T, b: T| if b < a { b } else { a };
        let best = self.without.iter().fold(T::of(f64::INFINITY), |best, chi_square| smaller(best, *chi_square));
        let limit = smaller(T::of(SOUND), best + T::of(LOOKS_ALIKE));
        let named = |(cable, chi_square): (usize, &T)| u8::from(*chi_square <= limit) << cable;
        self.without.iter().enumerate().map(named).fold(0, |bits, bit| bits | bit)
    }
}
