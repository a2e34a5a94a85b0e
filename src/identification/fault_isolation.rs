//! Fault isolation: which cable made a pose contradict the others?
//!
//! With the centre known a pose has three redundant lengths, so any one cable can be left out and the other five
//! still tested (two degrees of freedom). The cable without which the pose fits is faulty. When no single cable
//! is, two may have been exchanged.

use crate::kinematics::{AttitudeSolver, CableLengths, CableSet};
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

/// Assembly modes in which a rotation is sought where the known one leads to none that fits.
const MODES: u8 = 4;

/// The question about a pose.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Question {
    /// Does it fit without this cable (from 0), at a rotation near the known one?
    Without(usize),
    /// The same at a rotation in one of the assembly modes.
    WithoutInMode(usize, u8),
    /// Does it fit with two cables exchanged, near the known rotation (`None`) or in an assembly mode?
    Exchanged(usize, usize, Option<u8>),
}

/// The questions about one pose, one attempt at one of them a slice. Most poses are explained near the known rotation; only
/// what fits nothing there is sought elsewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Isolation<T> {
    question: Question,
    /// χ² without each cable; infinite where no rotation fits.
    without: [T; CABLES],
}

impl<T: Real> Default for Isolation<T> {
    fn default() -> Self {
        Self { question: Question::Without(0), without: [T::of(f64::INFINITY); CABLES] }
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
        let fit = match self.question {
            Question::Without(cable) => solver.track(*known, lengths, CableSet::all_but(cable)),
            Question::WithoutInMode(cable, mode) => solver.solve_in(mode, lengths, CableSet::all_but(cable)),
            Question::Exchanged(first, second, None) => {
                solver.track(*known, &lengths.exchanged(first, second), CableSet::ALL)
            }
            Question::Exchanged(first, second, Some(mode)) => {
                solver.solve_in(mode, &lengths.exchanged(first, second), CableSet::ALL)
            }
        };
        let chi_square = fit.map_or(T::of(f64::INFINITY), |fit| fit.squares_mm2 / variance_mm2);
        match self.question {
            Question::Without(cable) => {
                self.keep(cable, chi_square);
                if cable + 1 < CABLES {
                    self.question = Question::Without(cable + 1);
                    return None;
                }
                self.question = Question::WithoutInMode(0, 0);
                self.single_cables()
            }
            Question::WithoutInMode(cable, mode) => {
                self.keep(cable, chi_square);
                if mode + 1 < MODES && !(chi_square <= T::of(SOUND)) {
                    self.question = Question::WithoutInMode(cable, mode + 1);
                    return None;
                }
                if cable + 1 < CABLES {
                    self.question = Question::WithoutInMode(cable + 1, 0);
                    return None;
                }
                self.question = Question::Exchanged(0, 1, None);
                self.single_cables()
            }
            Question::Exchanged(first, second, mode) => {
                if chi_square <= T::of(SOUND_AFTER_EXCHANGE) {
                    return Some(1 << first | 1 << second);
                }
                let next_mode = mode.map_or(0, |mode| mode + 1);
                self.question = if next_mode < MODES {
                    Question::Exchanged(first, second, Some(next_mode))
                } else if second + 1 < CABLES {
                    Question::Exchanged(first, second + 1, None)
                } else if first + 2 < CABLES {
                    Question::Exchanged(first + 1, first + 2, None)
                } else {
                    return Some(0);
                };
                None
            }
        }
    }

    /// Keeps the smallest χ² without a cable.
    fn keep(&mut self, cable: usize, chi_square: T) {
        if let Some(without) = self.without.get_mut(cable)
            && chi_square < *without
        {
            *without = chi_square;
        }
    }

    /// The cables without which the pose fits; `None` when it never does.
    fn single_cables(&self) -> Option<Cables> {
        let smaller = |a: T, b: T| if b < a { b } else { a };
        let best = self.without.iter().fold(T::of(f64::INFINITY), |best, chi_square| smaller(best, *chi_square));
        let limit = smaller(T::of(SOUND), best + T::of(LOOKS_ALIKE));
        let named = |(cable, chi_square): (usize, &T)| u8::from(*chi_square <= limit) << cable;
        let cables = self.without.iter().enumerate().map(named).fold(0, |bits, bit| bits | bit);
        (cables != 0).then_some(cables)
    }
}
