//! A centre as it is shown on the bus: the twelve frames of its value, and what names it.

use crate::can::command::NamedValue;
use crate::can::identity::{Naming, checksum};
use crate::can::result::{Parameter, ZeroError};
use crate::can::{BaseId, Message};
use crate::identification::Identified;
use crate::procedure::Candidate;

/// Frames of a value: three coordinates, three radii, six offsets.
pub(super) const FRAMES: u8 = 12;

/// Is the value in use, or does it wait for a decision?
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Candidate,
    Live,
}

/// The message at a position of the value, 0 to 11.
pub(super) fn message(kind: Kind, run_id: u16, identified: &Identified<f32>, position: u8) -> Option<Message> {
    let index = usize::from(position);
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

/// What names a centre; None when one of its numbers cannot be shown, and then nobody can name it.
pub(super) fn naming(candidate: &Candidate) -> Option<Naming> {
    let Candidate { run_id, boot, wearer, identified, .. } = candidate;
    let mut frames = [[0; 8]; FRAMES as usize];
    for (position, frame) in (0..FRAMES).zip(&mut frames) {
        // the data bytes are the same for both kinds, and at every base
        let packed = message(Kind::Live, *run_id, identified, position)?.pack(BaseId::DEFAULT).ok()?;
        *frame = packed.data().try_into().ok()?;
    }
    let checksum = checksum(*boot, *wearer, frames.into_iter());
    Some(Naming { run_id: *run_id, boot: *boot, wearer: *wearer, checksum })
}

impl Naming {
    /// Does a command mean this value?
    pub(super) const fn is_named_by(&self, value: &NamedValue) -> bool {
        value.run_id == self.run_id && value.boot == self.boot as u8 && value.checksum == self.checksum
    }
}
