//! A centre as it is shown on the bus: the twelve frames of its value, twenty of one that moves, and what names it.

use crate::can::command::NamedValue;
use crate::can::identity::{Naming, checksum};
use crate::can::result::{MotionPart, Parameter, ZeroError};
use crate::can::{BaseId, Message};
use crate::identification::Identified;
use crate::identification::joint::{MOTION_PARTS, ShownMotion};
use crate::procedure::Candidate;

/// Frames of a value: three coordinates, three radii, six offsets; then the parts of its motion, if it moves.
pub(super) const FRAMES: u8 = FRAMES_OF_BALL + MOTION_PARTS as u8;
const FRAMES_OF_BALL: u8 = 12;

/// Is the value in use, or does it wait for a decision?
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Candidate,
    Live,
}

/// A value that is shown.
#[derive(Debug, Clone, Copy)]
pub(super) struct Value<'a> {
    pub run_id: u16,
    pub identified: &'a Identified<f32>,
    pub motion: Option<&'a ShownMotion>,
}

impl<'a> Value<'a> {
    /// The value of a candidate.
    pub fn of(candidate: &'a Candidate) -> Self {
        Self { run_id: candidate.run_id, identified: &candidate.identified, motion: candidate.motion.as_ref() }
    }
}

/// The message at a position of the value, 0 to 19; None past its end.
pub(super) fn message(kind: Kind, value: &Value, position: u8) -> Option<Message> {
    let Value { run_id, identified, motion } = *value;
    let index = usize::from(position);
    if let Some(part) = position.checked_sub(FRAMES_OF_BALL) {
        let numbers = *motion?.parts().get(usize::from(part))?;
        let part = MotionPart { run_id, part, numbers };
        return Some(match kind {
            Kind::Candidate => Message::CandidateMotion(part),
            Kind::Live => Message::LiveMotion(part),
        });
    }
    if position < 6 {
        let value_mm = *identified.parameters.to_array().get(index)?;
        let sigma_mm = *identified.sigma_mm().get(index)?;
        let parameter = Parameter { run_id, index: position % 3, value_mm, sigma_mm };
        return Some(match (kind, position < 3) {
            (Kind::Candidate, true) => Message::CandidateCentre(parameter),
            (Kind::Candidate, false) => Message::CandidateRadius(parameter),
            (Kind::Live, true) => Message::LiveCentre(parameter),
            (Kind::Live, false) => Message::LiveRadius(parameter),
        });
    }
    let value_mm = *identified.offsets_mm.get(index - 6)?;
    let sigma_mm = *identified.offset_sigmas_mm.get(index - 6)?;
    let zero = ZeroError { run_id, cable: position - 5, value_mm, sigma_mm };
    Some(match kind {
        Kind::Candidate => Message::CandidateZero(zero),
        Kind::Live => Message::LiveZero(zero),
    })
}

/// Frames of a naming that are formed in one call.
const FRAMES_A_CALL: u8 = 4;

/// What names a centre, formed a few frames a call: packing all of them takes 15 000 cycles of a Cortex-M4F.
#[derive(Debug, Clone, Copy)]
pub(super) struct NamingInWork {
    frames: [[u8; 8]; FRAMES as usize],
    next: u8,
}

impl NamingInWork {
    pub const fn new() -> Self {
        Self { frames: [[0; 8]; FRAMES as usize], next: 0 }
    }

    /// The next frames, of the same centre in every call; after the last what names it. That is None when one of its numbers
    /// cannot be shown, and then nobody can name it.
    pub fn advance(&mut self, candidate: &Candidate) -> Option<Option<Naming>> {
        let Candidate { run_id, boot, wearer, motion, .. } = candidate;
        let value = Value::of(candidate);
        let count = if motion.is_some() { FRAMES } else { FRAMES_OF_BALL };
        for _ in 0..FRAMES_A_CALL.min(count.saturating_sub(self.next)) {
            // the data bytes are the same for both kinds, and at every base
            let packed = message(Kind::Live, &value, self.next).and_then(|message| message.pack(BaseId::DEFAULT).ok());
            let Some(data) = packed.and_then(|frame| frame.data().try_into().ok()) else { return Some(None) };
            if let Some(frame) = self.frames.get_mut(usize::from(self.next)) {
                *frame = data;
            }
            self.next += 1;
        }
        if self.next < count {
            return None;
        }
        let checksum = checksum(*boot, *wearer, self.frames.into_iter().take(usize::from(count)));
        Some(Some(Naming { run_id: *run_id, boot: *boot, wearer: *wearer, checksum }))
    }
}

/// What names a centre, at once.
pub(super) fn naming(candidate: &Candidate) -> Option<Naming> {
    let mut in_work = NamingInWork::new();
    loop {
        if let Some(naming) = in_work.advance(candidate) {
            return naming;
        }
    }
}

impl Naming {
    /// Does a command mean this value?
    pub(super) const fn is_named_by(&self, value: &NamedValue) -> bool {
        value.run_id == self.run_id && value.boot == self.boot as u8 && value.checksum == self.checksum
    }
}
