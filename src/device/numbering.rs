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
const fn all(cables: u8) -> u8 {
    (1 << (cables & 7)) - 1
}

/// What has been seen of the cables' numbering since power-up.
#[derive(Debug, Clone, Copy)]
pub(super) struct Numbering {
    /// The first centre on this machine is accepted only after the check.
    required: bool,
    cables: u8,
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
    /// It was said that a wrong cable moved: the next question begins anew.
    answered: bool,
    /// That wrong cable while it is still pulled, and its count before: until it is let go, its motion is no answer.
    held: Option<(u8, i32)>,
}

impl Asked {
    fn new(cable: u8, from: [i32; CABLES], held: Option<(u8, i32)>) -> Self {
        Self { cable, from, moved: None, answered: false, held }
    }

    /// The wrong cable of the question before, unless it has been let go.
    fn still_held(&mut self, counts: &[i32; CABLES], mm_per_count: f32) -> Option<u8> {
        let (cable, before) = self.held?;
        let (count, from) = counts.iter().zip(&mut self.from).nth(usize::from(cable) - 1)?;
        if before.abs_diff(*count) as f32 * mm_per_count < PULLED_MM {
            *from = before;
            self.held = None;
        }
        self.held.map(|(cable, _)| cable)
    }
}

impl Numbering {
    pub const fn new(required: bool, cables: u8) -> Self {
        Self { required, cables, asked: None, found: 0 }
    }

    /// Takes in a sample of the encoders.
    pub fn sample(&mut self, counts: &[i32; CABLES], mm_per_count: f32) {
        if let Some(asked) = self.asked.as_mut().filter(|asked| asked.moved.is_none()) {
            let held = asked.still_held(counts, mm_per_count);
            match alone(&asked.from, counts, mm_per_count) {
                // a cable that was pulled before is let go
                Some(moved) if self.found & bit(moved) != 0 || held == Some(moved) => {
                    asked.from = *counts;
                }
                moved => asked.moved = moved,
            }
            if asked.moved == Some(asked.cable) {
                self.found |= bit(asked.cable);
            }
        }
    }

    /// Has this cable, 1 to 6, moved its own encoder, and no other one, since it was first asked for?
    fn ask(&mut self, cable: u8, counts: [i32; CABLES], mm_per_count: f32) -> (Reason, u16) {
        if self.found & bit(cable) != 0 {
            return (Reason::Fine, self.found.into());
        }
        let held = match self.asked.as_mut() {
            Some(asked) if asked.cable == cable && !asked.answered => {
                let Some(moved) = asked.moved else { return (Reason::CableNotPulled, self.found.into()) };
                asked.answered = true;
                return (Reason::WrongCable, moved.into());
            }
            Some(asked) if asked.answered => alone(&asked.from, &counts, mm_per_count)
                .filter(|cable| asked.moved == Some(*cable))
                .and_then(|cable| Some((cable, *asked.from.get(usize::from(cable) - 1)?))),
            _ => None,
        };
        self.asked = Some(Asked::new(cable, counts, held));
        (Reason::CableNotPulled, self.found.into())
    }
}

impl Device {
    /// The answer to [`Opcode::CheckCable`](crate::can::Opcode::CheckCable).
    pub(super) fn check_cable(&mut self, now_ms: u32, cable: u8) -> (Reason, u16) {
        if matches!(self.procedure.state(), StateName::Collecting | StateName::Identifying | StateName::Verifying) {
            return (Reason::WrongState, 0);
        }
        if cable > self.procedure.cables() {
            return (Reason::BadArgument, 0);
        }
        let mm_per_count = self.procedure.drum().mm_per_count();
        match (self.procedure.fault(now_ms), self.counts) {
            (Some(fault), _) => (fault.reason, fault.cable.into()),
            (None, None) => (Reason::EncoderSilent, 0),
            (None, Some(counts)) => self.numbering.ask(cable, counts, mm_per_count),
        }
    }

    /// Why the new centre may not be accepted yet: nobody has seen that the cables are numbered as the rig says. A centre
    /// in use was accepted on this very machine, hence after the check.
    pub(super) fn numbering_unchecked(&self) -> bool {
        let Numbering { required, found, cables, .. } = self.numbering;
        required
            && found != all(cables)
            && self.procedure.live().is_none()
            && self.procedure.state() == StateName::Review
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

    const MM_PER_COUNT: f32 = 0.02;
    const REST: [i32; CABLES] = [7; CABLES];

    fn with(cable: usize, count: i32) -> [i32; CABLES] {
        let mut counts = REST;
        counts[cable - 1] += count;
        counts
    }

    #[test]
    fn the_counts_before_are_those_of_the_first_question() {
        let mut numbering = Numbering::new(true, 6);
        assert_eq!(numbering.ask(2, REST, MM_PER_COUNT), (Reason::CableNotPulled, 0));
        numbering.sample(&with(2, 300), MM_PER_COUNT);
        assert_eq!(numbering.ask(2, [0; CABLES], MM_PER_COUNT), (Reason::Fine, 0b10));
        assert_eq!(numbering.ask(3, REST, MM_PER_COUNT), (Reason::CableNotPulled, 0b10));
        numbering.sample(&with(5, 300), MM_PER_COUNT);
        assert_eq!(numbering.ask(3, REST, MM_PER_COUNT), (Reason::WrongCable, 5));
        // it is asked for anew, and the cable pulled before is let go meanwhile
        assert_eq!(numbering.ask(3, with(2, 600), MM_PER_COUNT), (Reason::CableNotPulled, 0b10));
        numbering.sample(&with(2, 300), MM_PER_COUNT);
        numbering.sample(&REST, MM_PER_COUNT);
        numbering.sample(&with(3, 600), MM_PER_COUNT);
        assert_eq!(numbering.ask(3, REST, MM_PER_COUNT), (Reason::Fine, 0b110));
    }

    /// Asked for cable 1, somebody pulls cable 5, reads that, and begins again before it is let go.
    fn held_while_asked_again() -> Numbering {
        let mut numbering = Numbering::new(true, 6);
        numbering.ask(1, REST, MM_PER_COUNT);
        numbering.sample(&with(5, 300), MM_PER_COUNT);
        assert_eq!(numbering.ask(1, with(5, 400), MM_PER_COUNT), (Reason::WrongCable, 5));
        assert_eq!(numbering.ask(1, with(5, 500), MM_PER_COUNT), (Reason::CableNotPulled, 0));
        numbering
    }

    #[test]
    fn a_wrong_cable_is_let_go_after_it_was_asked_again() {
        let mut numbering = held_while_asked_again();
        for count in [900, 600, 300, 0] {
            numbering.sample(&with(5, count), MM_PER_COUNT);
            assert_eq!(numbering.ask(1, REST, MM_PER_COUNT), (Reason::CableNotPulled, 0), "{count}");
        }
        numbering.sample(&with(1, 300), MM_PER_COUNT);
        assert_eq!(numbering.ask(1, REST, MM_PER_COUNT), (Reason::Fine, 1));
    }

    #[test]
    fn a_wrong_cable_pulled_once_more_is_named_once_more() {
        let mut numbering = held_while_asked_again();
        for count in [490, 250, 240, 10, 150, 310] {
            numbering.sample(&with(5, count), MM_PER_COUNT);
        }
        assert_eq!(numbering.ask(1, REST, MM_PER_COUNT), (Reason::WrongCable, 5));
        // let go at once, it is as good as new
        assert_eq!(numbering.ask(1, REST, MM_PER_COUNT), (Reason::CableNotPulled, 0));
        numbering.sample(&with(5, 300), MM_PER_COUNT);
        assert_eq!(numbering.ask(1, REST, MM_PER_COUNT), (Reason::WrongCable, 5));
    }

    #[test]
    fn an_arm_that_moved_meanwhile_holds_no_cable() {
        let mut numbering = Numbering::new(true, 6);
        numbering.ask(1, REST, MM_PER_COUNT);
        numbering.sample(&with(5, 300), MM_PER_COUNT);
        numbering.ask(1, REST, MM_PER_COUNT);
        let elsewhere = REST.map(|count| count + 1000);
        assert_eq!(numbering.ask(1, elsewhere, MM_PER_COUNT), (Reason::CableNotPulled, 0));
        numbering.sample(
            &[elsewhere[0], elsewhere[1], elsewhere[2], elsewhere[3], elsewhere[4] + 300, elsewhere[5]],
            MM_PER_COUNT,
        );
        assert_eq!(numbering.ask(1, elsewhere, MM_PER_COUNT), (Reason::WrongCable, 5));
    }
}
