//! Makes the board another machine, by its parameters alone.

use super::client::{ANSWER_LIMIT_MS, Client};
use super::display::Display;
use super::session::Session;
use super::transcript::SessionError;
use glenoid::can::{BaseId, Operation, ParameterRequest};
use glenoid::parameters::{Key, ParameterSet, TABLE};

impl Session<'_> {
    /// Has the board become this machine: see `become_machine`.
    ///
    /// # Errors
    /// [`SessionError`]; the board is as it was then.
    pub fn become_machine(&mut self, set: &ParameterSet) -> Result<usize, SessionError> {
        become_machine(&mut self.client, set, self.display)
    }
}

/// Writes what differs from the defaults, has the board check and store it as a whole, and takes the board's supply
/// away and gives it back. Returns how many were written.
///
/// # Errors
/// [`SessionError`]; the board is as it was then.
pub(super) fn become_machine(
    client: &mut Client<'_>,
    set: &ParameterSet,
    display: &Display,
) -> Result<usize, SessionError> {
    let defaults = ParameterSet::new();
    let differs = |entry: &&glenoid::parameters::Entry| set.bits(entry.index) != defaults.bits(entry.index);
    let mut changed: Vec<_> = TABLE.iter().filter(differs).collect();
    // It acts at once: on a bus with other boards a new one is to become quiet first.
    changed.sort_by_key(|entry| entry.index != TABLE[Key::TelemetryRate as usize].index);
    let stage = display.counted("telling the machine", changed.len() as u64);
    client.wait_for("heartbeat", ANSWER_LIMIT_MS, |inbox| inbox.heartbeat)?;
    let request = |operation: Operation, index, value| ParameterRequest {
        operation: operation as u8,
        index,
        // What is written twice is written once.
        nonce: 0,
        value,
    };
    client.parameter(request(Operation::Reset, 0, 0))?;
    for (done, entry) in (1..).zip(&changed) {
        let bits = set.bits(entry.index).unwrap_or(entry.default);
        client.parameter(request(Operation::Write, entry.index, bits))?;
        stage.reached(done, entry.description().name);
    }
    client.parameter(request(Operation::Save, 0, 0))?;
    client.restart()?;
    client.base = BaseId::new(set.integer(Key::BaseId) as u16).unwrap_or(BaseId::DEFAULT);
    stage.done(&format!("{} parameters over CAN", changed.len()));
    Ok(changed.len())
}
