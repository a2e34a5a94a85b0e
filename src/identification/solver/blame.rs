//! Which cable made a pose contradict the others?
//!
//! With the centre known a pose has three redundant lengths, so any one cable can be left out and the other five
//! still checked (two degrees of freedom). The cable without which the pose fits is to blame. When no single cable
//! is, two may have been exchanged.

use super::placement::Placer;
use crate::identification::outcome::Identified;
use crate::identification::zeros::Zeros;
use crate::kinematics::arm::CableSet;
use crate::kinematics::{CableLengths, Pivot};
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
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Blame<T> {
    next: usize,
    question: usize,
    /// Squares without each cable, mm².
    without: [Option<T>; CABLES],
}

impl<T: Real> Blame<T> {
    pub fn new() -> Self {
        Self { next: 0, question: 0, without: [None; CABLES] }
    }

    pub fn is_done(&self, result: &Identified<T>) -> bool {
        self.next >= result.rejected.len()
    }

    /// Asks one question of the next pose left out: six times "which cable", fifteen times "which exchange".
    pub fn advance(
        &mut self,
        result: &mut Identified<T>,
        placer: &Placer<T>,
        pivot: &Pivot<T>,
        zeros: &impl Zeros<T>,
        poses: &[CableLengths<T>],
    ) {
        let noise = result.noise_mm.max(placer.rig_noise_mm);
        let variance = noise * noise;
        let Some(rejected) = result.rejected.get_mut(self.next) else { return };
        let Some(measured) = poses.get(usize::from(rejected.pose)) else { return };
        let lengths = &zeros.corrected(measured);
        if let Some(slot) = self.without.get_mut(self.question) {
            let cable = self.question;
            *slot = placer.arm(pivot).fit(lengths, CableSet::all_but(cable)).map(|fit| fit.squares_mm2);
            self.question += 1;
            if self.question == CABLES {
                let named = self.single_cables(variance);
                if named != 0 {
                    rejected.cables = named;
                    *self = Self { next: self.next + 1, ..Self::new() };
                }
            }
            return;
        }
        match pair(self.question - CABLES) {
            Some((i, j)) => {
                self.question += 1;
                let exchanged = lengths.exchanged(i, j);
                let fit = placer.arm(pivot).fit(&exchanged, CableSet::ALL);
                if fit.is_some_and(|fit| fit.squares_mm2 <= variance * T::of(SOUND_AFTER_EXCHANGE)) {
                    rejected.cables = 1 << i | 1 << j;
                    *self = Self { next: self.next + 1, ..Self::new() };
                }
            }
            None => *self = Self { next: self.next + 1, ..Self::new() },
        }
    }

    /// Bits of the cables without which the pose fits; none when it never does.
    fn single_cables(&self, variance: T) -> u8 {
        let (sound, alike) = (variance * T::of(SOUND), variance * T::of(LOOKS_ALIKE));
        let best = self.without.iter().flatten().fold(T::of(f64::INFINITY), |best, s| best.min(*s));
        let limit = sound.min(best + alike);
        self.without
            .iter()
            .enumerate()
            .fold(0, |bits, (cable, squares)| bits | u8::from(squares.is_some_and(|squares| squares <= limit)) << cable)
    }
}

/// The `index`-th of the fifteen pairs of cables.
fn pair(index: usize) -> Option<(usize, usize)> {
    (0..CABLES).flat_map(|i| (i + 1..CABLES).map(move |j| (i, j))).nth(index)
}
