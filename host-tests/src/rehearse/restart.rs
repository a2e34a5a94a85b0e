//! The supply is taken away after the acceptance and comes back: what does the board still know?

use super::client::ANSWER_LIMIT_MS;
use super::session::{Person, Session};
use super::transcript::{SessionError, Transcript};
use glenoid::can::Opcode;
use glenoid::can::result::Parameter;

/// The board tells of a bad record within its first turn of faults, ms.
const FAULT_LIMIT_MS: u32 = 300;

impl Session<'_> {
    /// Restarts the board and asks which centre is in use now: x, y, z, p1, p2, p3.
    ///
    /// # Errors
    /// [`SessionError::Forgotten`] when the board has none; it then says why, if it knows.
    pub fn restart(&mut self) -> Result<[Parameter; 6], SessionError> {
        self.restart_board()?;
        self.client.command(Opcode::Query, 0, 0)?;
        self.client.wait_for("centre in use", ANSWER_LIMIT_MS, |inbox| inbox.live())
    }
}

impl<P: Person> Session<'_, P> {
    /// Restarts the board, which must come back with what was in use.
    ///
    /// # Errors
    /// As [`restart`](Session::restart).
    pub(super) fn restart_board(&mut self) -> Result<(), SessionError> {
        let stage = self.display.stage("restarting the board");
        self.client.restart()?;
        let heartbeat = self.client.wait_for("heartbeat", ANSWER_LIMIT_MS, |inbox| inbox.heartbeat)?;
        if !heartbeat.flags.live {
            let told = self.client.wait_for("fault", FAULT_LIMIT_MS, |inbox| inbox.faults.first().copied());
            return Err(SessionError::Forgotten(told.ok().map(|fault| fault.code)));
        }
        stage.done("what was accepted is in use, from the record");
        Ok(())
    }
}

/// The centre in use after a restart is not the one that was accepted before.
pub(super) fn differs(transcript: &Transcript, after_restart: &[Parameter; 6]) -> bool {
    let bits = |parameter: &Parameter| (parameter.run_id, parameter.index, parameter.value_mm.to_bits());
    transcript.parameters.iter().map(bits).ne(after_restart.iter().map(bits))
}
