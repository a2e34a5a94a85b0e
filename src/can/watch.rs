//! The message of the watch over the centre in use: what has slipped, how far, and which way.

use super::payload::{Field, PackError, Payload, RUN};
use super::rounding::Scale;
use crate::monitor::Cause;
use crate::procedure::Reason;

/// What the watch has found. The centre in use stays as it is.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WatchReport {
    /// The run that found the centre in use.
    pub run_id: u16,
    /// What has happened: a reason of the band [`Watch`](crate::procedure::Band::Watch).
    pub cause: Reason,
    /// The cable meant, 1 to 6; 0 for none.
    pub cable: u8,
    /// How far and which way, mm, each within ±64: for the strap in {B}, for the cuff in {P}, for a centre that drifts
    /// in {B} and for 10 degrees of elevation. For a cable x is what its length reads too much, y and z are 0.
    pub moved_mm: [f32; 3],
}

/// A movement further than the field holds is sent as this, mm.
const MAX_MM: f32 = 63.9;

mod field {
    use super::{Field, Scale};
    const MOVED: Scale = Scale::signed(12, -5);
    pub(super) const CAUSE: Field = Field::integer(16, 8);
    pub(super) const CABLE: Field = Field::integer(24, 4);
    pub(super) const MOVED_MM: [Field; 3] =
        [Field::scaled(28, MOVED), Field::scaled(40, MOVED), Field::scaled(52, MOVED)];
}

impl WatchReport {
    /// A cause in the terms of the message, about the centre of a run.
    pub fn of(run_id: u16, cause: &Cause<f32>) -> Self {
        let (reason, cable, moved_mm) = match cause {
            Cause::StrapSlipped(moved) => (Reason::StrapSlipped, 0, (*moved).into()),
            Cause::CuffSlipped(moved) => (Reason::CuffSlipped, 0, (*moved).into()),
            Cause::CableSlipped { cable, error_mm } => (Reason::CableSlipped, *cable, [*error_mm, 0.0, 0.0]),
            Cause::NotABall(drift) => (Reason::CentreDrifts, 0, (*drift).into()),
            Cause::Unknown => (Reason::CentreMoved, 0, [0.0; 3]),
        };
        Self { run_id, cause: reason, cable, moved_mm: moved_mm.map(|mm: f32| mm.clamp(-MAX_MM, MAX_MM)) }
    }

    pub(super) fn pack(&self) -> Result<Payload, PackError> {
        let mut payload =
            Payload::new().with(RUN, self.run_id).with(field::CAUSE, self.cause.code()).with(field::CABLE, self.cable);
        for (field, moved_mm) in field::MOVED_MM.into_iter().zip(self.moved_mm) {
            payload = payload.with_value(field, moved_mm)?;
        }
        Ok(payload)
    }

    pub(super) fn unpack(payload: Payload) -> Option<Self> {
        Some(Self {
            run_id: payload.get_u16(RUN),
            cause: Reason::from_code(payload.get_u8(field::CAUSE))?,
            cable: payload.get_u8(field::CABLE),
            moved_mm: field::MOVED_MM.map(|field| payload.get_value(field)),
        })
    }
}
