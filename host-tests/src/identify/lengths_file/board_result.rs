//! What the board itself found in a recorded run: the centre and the radii that it showed.

use glenoid::can::command::ZERO_PRIOR_STEP_MM;
use glenoid::can::result::Parameter;
use glenoid::can::{BaseId, Frame, Message, Opcode, Request};

/// The board's own result, as far as it was recorded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoardResult {
    parameters: [Option<Parameter>; 6],
    /// How well the encoder offsets were said to be known, mm.
    pub offset_prior_mm: f64,
}

impl BoardResult {
    /// Nothing yet, of a run whose offsets are known so well, mm.
    pub(super) fn new(offset_prior_mm: f64) -> Self {
        Self { parameters: [None; 6], offset_prior_mm }
    }

    /// Takes a message of the run `run_id`.
    pub(super) fn take(&mut self, run_id: u16, message: &Message) {
        let (place, parameter) = match message {
            Message::CandidateCentre(p) | Message::LiveCentre(p) => (usize::from(p.index), *p),
            Message::CandidateRadius(p) | Message::LiveRadius(p) => (usize::from(p.index) + 3, *p),
            _ => return,
        };
        if let Some(kept) = self.parameters.get_mut(place).filter(|_| parameter.run_id == run_id) {
            *kept = Some(parameter);
        }
    }

    /// x, y, z, p1, p2, p3, when all of them were recorded.
    pub fn parameters(&self) -> Option<[Parameter; 6]> {
        let [a, b, c, d, e, f] = self.parameters;
        Some([a?, b?, c?, d?, e?, f?])
    }
}

/// The prior of the offsets that a command sets, mm.
pub(super) fn offset_prior_mm(frame: &Frame) -> Option<f64> {
    let request =
        Request::unpack(frame.data()).ok().filter(|_| frame.raw_id() == BaseId::DEFAULT.command().as_raw())?;
    let sets = request.opcode == Opcode::SetZeroPrior as u8;
    sets.then(|| f64::from(request.argument) * f64::from(ZERO_PRIOR_STEP_MM))
}
