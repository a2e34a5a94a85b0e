//! Are the cables numbered as the rig says? A symmetric machine fits its lengths under a shifted or a mirrored numbering as
//! well, with a centre that is somewhere else, and no residual shows it. So a person pulls one cable after the other, and the
//! device looks which encoder moves.

use super::Device;
use crate::procedure::{Reason, StateName};
use crate::rig::CABLES;

/// So far a cable must be pulled, mm: ten times what an arm at rest moves.
const PULLED_MM: f32 = 5.0;
/// Every other cable may move by this share of it meanwhile: the arm gives way a little.
const SHARE_OF_OTHERS: f32 = 0.5;
/// A bit for every cable.
const ALL: u8 = 0x3F;

/// What has been seen of the cables' numbering since power-up.
#[derive(Debug, Clone, Copy)]
pub(super) struct Numbering {
    /// The first centre on this machine is accepted only after the check.
    required: bool,
    asked: Option<Asked>,
    /// A bit for every cable that moved its own encoder, cable 1 the lowest.
    found: u8,
}

/// The cable that is to be pulled, the counts before, and the cable that moved.
#[derive(Debug, Clone, Copy)]
struct Asked {
    cable: u8,
    from: [i32; CABLES],
    moved: Option<u8>,
}

impl Numbering {
    pub const fn new(required: bool) -> Self {
        Self { required, asked: None, found: 0 }
    }

    /// Takes in a sample of the encoders.
    pub fn sample(&mut self, counts: &[i32; CABLES], mm_per_count: f32) {
        if let Some(asked) = self.asked.as_mut().filter(|asked| asked.moved.is_none()) {
            match alone(&asked.from, counts, mm_per_count) {
                // a cable that was pulled before is let go
                Some(moved) if self.found & bit(moved) != 0 => asked.from = *counts,
                moved => asked.moved = moved,
            }
            if asked.moved == Some(asked.cable) {
                self.found |= bit(asked.cable);
            }
        }
    }

    /// Has this cable, 1 to 6, moved its own encoder, and no other one, since it was first asked for?
    fn ask(&mut self, cable: u8, counts: [i32; CABLES]) -> (Reason, u16) {
        if self.found & bit(cable) != 0 {
            return (Reason::Fine, self.found.into());
        }
        match self.asked {
            Some(Asked { cable: asked, moved: Some(moved), .. }) if asked == cable => {
                self.asked = None;
                (Reason::WrongCable, moved.into())
            }
            Some(Asked { cable: asked, .. }) if asked == cable => (Reason::CableNotPulled, self.found.into()),
            _ => {
                self.asked = Some(Asked { cable, from: counts, moved: None });
                (Reason::CableNotPulled, self.found.into())
            }
        }
    }
}

impl Device {
    /// The answer to [`Opcode::CheckCable`](crate::can::Opcode::CheckCable).
    pub(super) fn check_cable(&mut self, now_ms: u32, cable: u8) -> (Reason, u16) {
        if matches!(self.procedure.state(), StateName::Collecting | StateName::Identifying | StateName::Verifying) {
            return (Reason::WrongState, 0);
        }
        match (self.procedure.fault(now_ms), self.counts) {
            (Some(fault), _) => (fault.reason, fault.cable.into()),
            (None, None) => (Reason::EncoderSilent, 0),
            (None, Some(counts)) => self.numbering.ask(cable, counts),
        }
    }

    /// Why the new centre may not be accepted yet: nobody has seen that the cables are numbered as the rig says. A centre
    /// in use was accepted on this very machine, hence after the check.
    pub(super) fn numbering_unchecked(&self) -> bool {
        let Numbering { required, found, .. } = self.numbering;
        required && found != ALL && self.procedure.live().is_none() && self.procedure.state() == StateName::Review
    }
}

/// The cable, from 1, that moved far while every other one rested.
fn alone(from: &[i32; CABLES], counts: &[i32; CABLES], mm_per_count: f32) -> Option<u8> {
    let moved_mm = |(from, count): (&i32, &i32)| from.abs_diff(*count) as f32 * mm_per_count;
    let mut farthest = (0, 0.0);
    let mut second = 0.0;
    for (cable, moved_mm) in (1..).zip(from.iter().zip(counts).map(moved_mm)) {
        if moved_mm > farthest.1 {
            second = farthest.1;
            farthest = (cable, moved_mm);
        } else if moved_mm > second {
            second = moved_mm;
        }
    }
    let (cable, moved_mm) = farthest;
    (moved_mm >= PULLED_MM && second < moved_mm * SHARE_OF_OTHERS).then_some(cable)
}

/// The bit of a cable, 1 to 6.
const fn bit(cable: u8) -> u8 {
    1 << (cable.saturating_sub(1) & 7)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_cable_that_moves_alone_was_pulled() {
        let alone = |counts| alone(&[0; CABLES], &counts, 0.02);
        assert_eq!(alone([0, 0, 0, 0, 0, 249]), None);
        assert_eq!(alone([0, 0, 0, 0, 0, -250]), Some(6));
        assert_eq!(alone([400, 199, -199, 0, 0, 0]), Some(1));
        // the arm moved
        assert_eq!(alone([400, 201, 0, 0, 0, 0]), None);
        assert_eq!(alone([199, 201, 400, 0, 0, 0]), None);
        assert_eq!(alone([i32::MAX, 0, 0, 0, 0, i32::MIN]), None);
    }

    #[test]
    fn the_counts_before_are_those_of_the_first_question() {
        let mut numbering = Numbering::new(true);
        assert_eq!(numbering.ask(2, [7; CABLES]), (Reason::CableNotPulled, 0));
        numbering.sample(&[7, 307, 7, 7, 7, 7], 0.02);
        assert_eq!(numbering.ask(2, [0; CABLES]), (Reason::Fine, 0b10));
        assert_eq!(numbering.ask(3, [7; CABLES]), (Reason::CableNotPulled, 0b10));
        numbering.sample(&[7, 7, 7, 7, 307, 7], 0.02);
        assert_eq!(numbering.ask(3, [7; CABLES]), (Reason::WrongCable, 5));
        // it is asked for anew, and the cable pulled before is let go meanwhile
        assert_eq!(numbering.ask(3, [7, 607, 7, 7, 7, 7]), (Reason::CableNotPulled, 0b10));
        numbering.sample(&[7, 307, 7, 7, 7, 7], 0.02);
        numbering.sample(&[7, 7, 7, 7, 7, 7], 0.02);
        numbering.sample(&[7, 7, 607, 7, 7, 7], 0.02);
        assert_eq!(numbering.ask(3, [7; CABLES]), (Reason::Fine, 0b110));
    }
}
