//! What a control loop beside the device takes from it: the centre in use and whether it may be used, in few words.

use super::Device;
use super::snapshot::Snapshot;
use crate::can::Standing;
use crate::procedure::Procedure;
use crate::rig::{CABLES, Parameters};

/// Words of a set.
pub const CONTROL_WORDS: usize = 1 + 6 + CABLES;

/// The set as the main loop publishes it for an interrupt.
pub type PublishedControlSet = Snapshot<CONTROL_WORDS>;

/// The centre in use, and what belongs to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ControlSet {
    /// May the centre be used?
    pub standing: Standing,
    /// The run that found it; 0 without a centre.
    pub run_id: u16,
    /// The centre in {B} and the radii, mm.
    pub parameters: Parameters<f32>,
    /// Offsets of the encoders, which are taken off the lengths, mm.
    pub offsets_mm: [f32; CABLES],
}

impl ControlSet {
    /// As words.
    pub fn to_words(&self) -> [u32; CONTROL_WORDS] {
        let mut words = [u32::from(self.standing.code()) | u32::from(self.run_id) << 16; CONTROL_WORDS];
        let numbers = self.parameters.to_array().into_iter().chain(self.offsets_mm);
        for (word, number) in words.iter_mut().skip(1).zip(numbers) {
            *word = number.to_bits();
        }
        words
    }

    /// From words; None if they are no set.
    pub fn from_words(words: &[u32; CONTROL_WORDS]) -> Option<Self> {
        let [first, x, y, z, p1, p2, p3, offsets @ ..] = words;
        Some(Self {
            standing: Standing::from_code(*first as u8)?,
            run_id: (first >> 16) as u16,
            parameters: Parameters::from_array([x, y, z, p1, p2, p3].map(|bits| f32::from_bits(*bits))),
            offsets_mm: offsets.map(f32::from_bits),
        })
    }
}

impl Device {
    /// What a control loop takes. Without a centre, and where the joint is a hinge, all numbers are 0.
    pub fn control_set(&self) -> ControlSet {
        let live = self.procedure.ball().and_then(Procedure::live);
        // A hinge has no centre to go by.
        let standing = if self.procedure.hinge().is_some() { Standing::NoCentre } else { self.standing().0 };
        ControlSet {
            standing,
            run_id: live.map_or(0, |live| live.run_id),
            parameters: live.map_or(Parameters::from_array([0.0; 6]), |live| live.identified.parameters),
            offsets_mm: live.map_or([0.0; CABLES], |live| live.identified.offsets_mm),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_comes_back_from_its_words() {
        for standing in Standing::ALL {
            let set = ControlSet {
                standing,
                run_id: 0x8001,
                parameters: Parameters::from_array([1.5, -2.5, 3.5, 4.5, 5.5, 6.5]),
                offsets_mm: [7.5, -8.5, 9.5, 10.5, 11.5, 12.5],
            };
            assert_eq!(ControlSet::from_words(&set.to_words()), Some(set));
        }
        assert_eq!(ControlSet::from_words(&[0xFF; CONTROL_WORDS]), None);
    }
}
