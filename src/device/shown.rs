//! A joint as it is shown on the bus: the twelve frames of a centre's value, twenty of one that moves, thirteen of a hinge's,
//! and what names it.

use crate::can::command::NamedValue;
use crate::can::hinge::{HingeAxis, HingePlace};
use crate::can::identity::{Naming, checksum};
use crate::can::result::{MotionPart, Parameter, ZeroError};
use crate::can::{BaseId, Message};
use crate::identification::Identified;
use crate::identification::joint::{MOTION_PARTS, ShownMotion};
use crate::procedure::elbow::{FoundHinge, SHOWN_NUMBERS};
use crate::procedure::module::{FoundJoint, JointValue};

/// Frames of a value: three coordinates, three radii, six offsets; then the parts of its motion, if it moves.
pub(super) const FRAMES: u8 = FRAMES_OF_BALL + MOTION_PARTS as u8;
const FRAMES_OF_BALL: u8 = 12;

/// Is the value in use, or does it wait for a decision?
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Candidate,
    Live,
}

/// How many frames show a value.
const fn frames_of(value: &JointValue<'_>) -> u8 {
    match value {
        JointValue::Ball(_, Some(_)) => FRAMES,
        JointValue::Ball(_, None) => FRAMES_OF_BALL,
        JointValue::Hinge(_) => SHOWN_NUMBERS as u8,
    }
}

/// The message at a position of the value that a run has found, 0 to 19; None past its end.
pub(super) fn message(kind: Kind, run_id: u16, value: &JointValue<'_>, position: u8) -> Option<Message> {
    match value {
        JointValue::Ball(identified, motion) => message_of_ball(kind, run_id, identified, *motion, position),
        JointValue::Hinge(found) => message_of_hinge(kind, run_id, found, position),
    }
}

/// Axis and foot point in the base, three frames each, then in the platform, then the offset along the axis.
fn message_of_hinge(kind: Kind, run_id: u16, found: &FoundHinge, position: u8) -> Option<Message> {
    if usize::from(position) >= SHOWN_NUMBERS {
        return None;
    }
    let [value, sigma] = found.number(position.into());
    // x, y, z of the base, then of the platform, then what is left
    let index = position / 6 * 3 + position % 3;
    let axis = HingeAxis { run_id, index, value, sigma };
    let place = HingePlace { run_id, index, value_mm: value, sigma_mm: sigma };
    let is_axis = position % 6 < 3 && position < 12;
    Some(match (kind, is_axis) {
        (Kind::Candidate, true) => Message::CandidateHingeAxis(axis),
        (Kind::Candidate, false) => Message::CandidateHingePlace(place),
        (Kind::Live, true) => Message::LiveHingeAxis(axis),
        (Kind::Live, false) => Message::LiveHingePlace(place),
    })
}

fn message_of_ball(
    kind: Kind,
    run_id: u16,
    identified: &Identified<f32>,
    motion: Option<&ShownMotion>,
    position: u8,
) -> Option<Message> {
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

    /// The next frames, of the same joint in every call; after the last what names it. That is None when one of its numbers
    /// cannot be shown, and then nobody can name it.
    pub fn advance(&mut self, found: &FoundJoint<'_>) -> Option<Option<Naming>> {
        let (run_id, boot, wearer, value) = (found.run_id(), found.boot(), found.wearer(), found.value());
        let count = frames_of(&value);
        for _ in 0..FRAMES_A_CALL.min(count.saturating_sub(self.next)) {
            // the data bytes are the same for both kinds, and at every base
            let packed =
                message(Kind::Live, run_id, &value, self.next).and_then(|message| message.pack(BaseId::DEFAULT).ok());
            let Some(data) = packed.and_then(|frame| frame.data().try_into().ok()) else { return Some(None) };
            if let Some(frame) = self.frames.get_mut(usize::from(self.next)) {
                *frame = data;
            }
            self.next += 1;
        }
        if self.next < count {
            return None;
        }
        let checksum = checksum(boot, wearer, self.frames.into_iter().take(usize::from(count)));
        Some(Some(Naming { run_id, boot, wearer, checksum }))
    }
}

/// What names a centre, at once.
pub(super) fn naming(found: &FoundJoint<'_>) -> Option<Naming> {
    let mut in_work = NamingInWork::new();
    loop {
        if let Some(naming) = in_work.advance(found) {
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
