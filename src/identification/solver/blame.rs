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

/// Progress over the poses left out: one question a slice.
///
/// The questions are the pairs of cables, by how far apart they stand: first each cable with itself, whether it is to
/// blame, then each two of them, whether they were exchanged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Blame<T> {
    next: usize,
    first: usize,
    apart: usize,
    /// Squares without each cable, mm²; infinite where no rotation fits.
    without: [T; CABLES],
}

impl<T: Real> Blame<T> {
    pub fn new() -> Self {
        Self { next: 0, first: 0, apart: 0, without: [T::zero(); CABLES] }
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
        let Some(rejected) = result.rejected.get_mut(self.next) else { return };
        let Some(measured) = poses.get(usize::from(rejected.pose)) else { return };
        let noise = result.noise_mm.max(rig_noise_mm);
        let variance = noise * noise;
        let (first, second) = (self.first, self.first + self.apart);
        let single = self.apart == 0;
        let cables = if single { CableSet::all_but(first) } else { CableSet::ALL };
        let lengths = zeros.corrected(measured).exchanged(first, second);
        let squares = arm.fit(&lengths, cables).map_or(T::of(f64::INFINITY), |fit| fit.squares_mm2);
        // Read after the sixth: what exchanges leave here is of no use.
        if let Some(without) = self.without.get_mut(first) {
            *without = squares;
        }
        self.first += 1;
        let all_asked = second + 1 == CABLES;
        if all_asked {
            (self.first, self.apart) = (0, self.apart + 1);
        }
        let named = if !single && squares <= variance * T::of(SOUND_AFTER_EXCHANGE) {
            1 << first | 1 << second
        } else if single && all_asked {
            self.single_cables(variance)
        } else {
            0
        };
        if named != 0 {
            rejected.cables = named as u8;
        }
        if named != 0 || self.apart == CABLES {
            (self.next, self.first, self.apart) = (self.next + 1, 0, 0);
        }
    }

    /// Bits of the cables without which the pose fits; none when it never does.
    fn single_cables(&self, variance: T) -> u32 {
        let smaller = |a: T, b: T| if b < a { b } else { a };
        let best = self.without.iter().fold(T::of(f64::INFINITY), |best, squares| smaller(best, *squares));
        let limit = smaller(variance * T::of(SOUND), best + variance * T::of(LOOKS_ALIKE));
        let named = |(cable, squares): (usize, &T)| u32::from(*squares <= limit) << cable;
        self.without.iter().enumerate().map(named).fold(0, |bits, bit| bits | bit)
    }
}
