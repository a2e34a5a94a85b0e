//! Which cable made a pose contradict the others?
//!
//! With the centre known a pose has three redundant lengths, so any one cable can be left out and the other five
//! still checked (two degrees of freedom). The cable without which the pose fits is to blame. When no single cable
//! is, two may have been exchanged.

use crate::identification::outcome::Identified;
use crate::identification::zeros::Zeros;
use crate::kinematics::CableLengths;
use crate::kinematics::arm::{Arm, CableSet};
use crate::rig::CABLES;
use crate::scalar::Real;

/// Sum of squares over variance, with two degrees of freedom, up to which the five other cables count as sound: once
/// in 8 000 poses they do not.
const SOUND: f64 = 18.0;
/// The same for all six cables after an exchange, three degrees of freedom.
const SOUND_AFTER_EXCHANGE: f64 = 25.0;
/// A second cable that explains the pose worse by less than this looks alike, and is named too.
const LOOKS_ALIKE: f64 = 9.0;

/// The fifteen exchanges of two cables.
const EXCHANGES: [(usize, usize); 15] = {
    let mut exchanges = [(0, 0); 15];
    let (mut at, mut first) = (0, 0);
    while first < CABLES {
        let mut second = first + 1;
        while second < CABLES {
            exchanges[at] = (first, second);
            (at, second) = (at + 1, second + 1);
        }
        first += 1;
    }
    exchanges
};

/// Progress over the poses left out: one question a slice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Blame<T> {
    next: usize,
    question: usize,
    /// Squares without each cable, mm²; infinite where no rotation fits.
    without: [T; CABLES],
}

impl<T: Real> Blame<T> {
    pub fn new() -> Self {
        Self { next: 0, question: 0, without: [T::zero(); CABLES] }
    }

    pub fn is_done(&self, result: &Identified<T>) -> bool {
        self.next >= result.rejected.len()
    }

    /// Asks one question of the next pose left out: six times "which cable", fifteen times "which exchange".
    #[inline(never)]
    pub fn advance(
        &mut self,
        result: &mut Identified<T>,
        arm: &Arm<'_, T>,
        rig_noise_mm: T,
        zeros: &impl Zeros<T>,
        poses: &[CableLengths<T>],
    ) {
        let noise = result.noise_mm.max(rig_noise_mm);
        let variance = noise * noise;
        let Some(rejected) = result.rejected.get_mut(self.next) else { return };
        let Some(measured) = poses.get(usize::from(rejected.pose)) else { return };
        let mut lengths = zeros.corrected(measured);
        let mut cables = CableSet::ALL;
        let mut suspects = 0;
        if self.question < CABLES {
            cables = CableSet::all_but(self.question);
        } else if let Some((i, j)) = EXCHANGES.get(self.question - CABLES) {
            lengths = lengths.exchanged(*i, *j);
            suspects = 1 << i | 1 << j;
        }
        let squares = arm.fit(&lengths, cables).map_or(T::of(f64::INFINITY), |fit| fit.squares_mm2);
        if let Some(without) = self.without.get_mut(self.question) {
            *without = squares;
        }
        self.question += 1;
        let named = if self.question == CABLES {
            self.single_cables(variance)
        } else if squares <= variance * T::of(SOUND_AFTER_EXCHANGE) {
            suspects
        } else {
            0
        };
        if named != 0 {
            rejected.cables = named;
        }
        if named != 0 || self.question == CABLES + EXCHANGES.len() {
            (self.next, self.question) = (self.next + 1, 0);
        }
    }

    /// Bits of the cables without which the pose fits; none when it never does.
    fn single_cables(&self, variance: T) -> u8 {
        let best = self.without.iter().fold(T::of(f64::INFINITY), |best, squares| best.min(*squares));
        let limit = (variance * T::of(SOUND)).min(best + variance * T::of(LOOKS_ALIKE));
        let named = |(cable, squares): (usize, &T)| u8::from(*squares <= limit) << cable;
        self.without.iter().enumerate().map(named).fold(0, |bits, bit| bits | bit)
    }
}
