//! Fault isolation: which cable made a pose contradict the others?
//!
//! With the centre known a pose has three redundant lengths. So any one cable can be left out and the other five still
//! be tested (two degrees of freedom): the cable without which the pose fits is faulty. When there is no such cable,
//! each pair of cables is tested for an exchange (three degrees of freedom).

use crate::kinematics::{AttitudeSolver, AttitudeTrack, CableLengths, CableSet};
use crate::rig::CABLES;
use crate::scalar::Real;
use nalgebra::UnitQuaternion;

/// χ² with two degrees of freedom up to which the five other cables are sound; sound ones exceed it once in 8 000
/// poses.
const FIVE_CABLES_LIMIT: f64 = 18.0;
/// The same for all six cables after an exchange, three degrees of freedom: once in 65 000.
const EXCHANGE_LIMIT: f64 = 25.0;
/// A second cable whose χ² is larger by less than this cannot be excluded (3σ), and is named too.
const AMBIGUOUS: f64 = 9.0;

/// The faulty cables: bit k set, cable k + 1.
pub type Cables = u8;

/// Assembly modes to start from when the known rotation leads to no fit.
const MODES: u8 = 4;

/// A hypothesis about a pose.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Hypothesis {
    /// This cable (from 0) is faulty: the other five fit near the known rotation.
    Without(usize),
    /// The same, starting in one of the assembly modes.
    WithoutInMode(usize, u8),
    /// Two cables (from 0) were exchanged; starting from the known rotation (`None`) or in an assembly mode.
    Exchanged(usize, usize, Option<u8>),
}

/// Fault isolation of one pose, some steps of one attempt at one hypothesis a slice. Most poses are explained near the
/// known rotation, so that is tried first.
#[derive(Clone, Copy, Debug)]
pub struct Isolation<T> {
    hypothesis: Hypothesis,
    /// The attempt under way.
    track: Option<AttitudeTrack<T>>,
    /// χ² without each cable; infinite where no rotation fits.
    without: [T; CABLES],
}

impl<T: Real> Default for Isolation<T> {
    fn default() -> Self {
        Self { hypothesis: Hypothesis::Without(0), track: None, without: [T::of(f64::INFINITY); CABLES] }
    }
}

impl<T: Real> Isolation<T> {
    /// A slice of an attempt. `Some` when it is the last one needed: the faulty cables, 0 when no cable or exchange explains the
    /// pose.
    ///
    /// `known`: the pose's rotation ({P} to {B}) by all cables, the first start. `variance_mm2`: of a length, mm².
    pub fn advance(
        &mut self,
        solver: &AttitudeSolver<'_, T>,
        known: &UnitQuaternion<T>,
        lengths: &CableLengths<T>,
        variance_mm2: T,
    ) -> Option<Cables> {
        let (lengths, cables, mode) = match self.hypothesis {
            Hypothesis::Without(cable) => (*lengths, CableSet::all_but(cable), None),
            Hypothesis::WithoutInMode(cable, mode) => (*lengths, CableSet::all_but(cable), Some(mode)),
            Hypothesis::Exchanged(first, second, mode) => (lengths.exchanged(first, second), CableSet::ALL, mode),
        };
        let start = || mode.map_or(*known, |mode| solver.start_in(mode, &lengths, cables));
        let mut track = self.track.take().unwrap_or_else(|| AttitudeTrack::new(start()));
        let Some(fit) = track.advance(solver, &lengths, cables) else {
            self.track = Some(track);
            return None;
        };
        let chi_square = fit.map_or(T::of(f64::INFINITY), |fit| fit.squares_mm2 / variance_mm2);
        match self.hypothesis {
            Hypothesis::Without(cable) => {
                self.keep(cable, chi_square);
                if cable + 1 < CABLES {
                    self.hypothesis = Hypothesis::Without(cable + 1);
                    return None;
                }
                self.hypothesis = Hypothesis::WithoutInMode(0, 0);
                self.single_cables()
            }
            Hypothesis::WithoutInMode(cable, mode) => {
                self.keep(cable, chi_square);
                if mode + 1 < MODES && !(chi_square <= T::of(FIVE_CABLES_LIMIT)) {
                    self.hypothesis = Hypothesis::WithoutInMode(cable, mode + 1);
                    return None;
                }
                if cable + 1 < CABLES {
                    self.hypothesis = Hypothesis::WithoutInMode(cable + 1, 0);
                    return None;
                }
                self.hypothesis = Hypothesis::Exchanged(0, 1, None);
                self.single_cables()
            }
            Hypothesis::Exchanged(first, second, mode) => {
                if chi_square <= T::of(EXCHANGE_LIMIT) {
                    return Some(1 << first | 1 << second);
                }
                let next_mode = mode.map_or(0, |mode| mode + 1);
                self.hypothesis = if next_mode < MODES {
                    Hypothesis::Exchanged(first, second, Some(next_mode))
                } else if second + 1 < CABLES {
                    Hypothesis::Exchanged(first, second + 1, None)
                } else if first + 2 < CABLES {
                    Hypothesis::Exchanged(first + 1, first + 2, None)
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
        let limit = smaller(T::of(FIVE_CABLES_LIMIT), best + T::of(AMBIGUOUS));
        let named = |(cable, chi_square): (usize, &T)| u8::from(*chi_square <= limit) << cable;
        let cables = self.without.iter().enumerate().map(named).fold(0, |bits, bit| bits | bit);
        (cables != 0).then_some(cables)
    }
}
