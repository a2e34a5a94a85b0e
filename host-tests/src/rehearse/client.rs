//! A client on the bus that keeps the encoders alive: commands, answers and waiting.

use super::bench::Bench;
use super::inbox::Inbox;
use super::transcript::SessionError;
use glenoid::can::status::Answer;
use glenoid::can::{BaseId, Opcode, ParameterAnswer, ParameterRequest, Request};
use glenoid::procedure::{Reason, StateName};
use glenoid::rig::CABLES;

/// A sample of the encoders every so many milliseconds, as long as the session lasts: 100 Hz.
pub(super) const PERIOD_MS: u32 = 10;
/// Longest wait for something that the board says at once, ms.
pub(super) const ANSWER_LIMIT_MS: u32 = 2_000;
/// Without an answer for this long a command is sent again, ms. The board knows it by its nonce and obeys it once.
const REPEAT_MS: u32 = 500;
/// Longest wait for the arm to count as still, ms, and pause between two attempts.
const STILL_LIMIT_MS: u32 = 5_000;
const RETRY_MS: u32 = 50;

/// The bench with the arm in it as it stands, and what has been heard so far.
pub(super) struct Client<'a> {
    bench: &'a mut dyn Bench,
    counts: [i32; CABLES],
    /// Where the board is on the bus.
    pub(super) base: BaseId,
    nonce: u16,
    /// Time that has passed for the wearer, ms.
    pub(super) elapsed_ms: u32,
    pub(super) inbox: Inbox,
}

impl<'a> Client<'a> {
    /// A client of the board at the usual identifiers that begins with these encoder counts.
    pub(super) fn new(bench: &'a mut dyn Bench, counts: [i32; CABLES]) -> Self {
        Self { bench, counts, base: BaseId::DEFAULT, nonce: 0, elapsed_ms: 0, inbox: Inbox::default() }
    }

    /// What the encoders show from now on.
    pub(super) fn stand(&mut self, counts: [i32; CABLES]) {
        self.counts = counts;
    }

    /// The next sample of the encoders.
    pub(super) fn sample(&mut self, counts: [i32; CABLES]) -> Result<(), SessionError> {
        self.counts = counts;
        self.step()
    }

    /// Holds the arm where it is.
    pub(super) fn hold(&mut self, ms: u32) -> Result<(), SessionError> {
        for _ in 0..ms / PERIOD_MS {
            self.step()?;
        }
        Ok(())
    }

    /// One sample of the encoders; takes in what the board sends meanwhile.
    fn step(&mut self) -> Result<(), SessionError> {
        self.elapsed_ms += PERIOD_MS;
        self.bench.set_counts(&self.counts)?;
        for frame in self.bench.pass(PERIOD_MS)? {
            self.inbox.take(&frame, self.base);
        }
        Ok(())
    }

    /// Takes the board's supply away and gives it back; nothing heard before counts any more.
    pub(super) fn restart(&mut self) -> Result<(), SessionError> {
        self.bench.restart()?;
        self.inbox = Inbox::default();
        Ok(())
    }

    /// Holds still until `found` finds something in the inbox. `what` names it, should it not come.
    pub(super) fn wait_for<T>(
        &mut self,
        what: &'static str,
        limit_ms: u32,
        mut found: impl FnMut(&Inbox) -> Option<T>,
    ) -> Result<T, SessionError> {
        for _ in 0..=limit_ms / PERIOD_MS {
            if let Some(found) = found(&self.inbox) {
                return Ok(found);
            }
            self.step()?;
        }
        Err(SessionError::Silence(what))
    }

    /// Holds still until the run has left `from` for `to`.
    ///
    /// # Errors
    /// [`SessionError::Failed`] or [`SessionError::WantsMore`] when it went elsewhere.
    pub(super) fn wait_for_state(&mut self, from: StateName, to: StateName, limit_ms: u32) -> Result<(), SessionError> {
        let now = self.wait_for("change of state", limit_ms, |inbox| {
            let left_at = inbox.states.iter().rposition(|heartbeat| heartbeat.state == from)?;
            inbox.states.get(left_at + 1).copied()
        })?;
        match now.state {
            state if state == to => Ok(()),
            StateName::Collecting => Err(SessionError::WantsMore(now.reason)),
            _ => Err(SessionError::Failed(self.wait_for("outcome", ANSWER_LIMIT_MS, |inbox| inbox.outcome)?)),
        }
    }

    /// Sends a command and waits for its answer.
    ///
    /// # Errors
    /// [`SessionError::Refused`] when the board does not obey.
    pub(super) fn command(&mut self, opcode: Opcode, run_id: u16, argument: u16) -> Result<Answer, SessionError> {
        let nonce = self.next_nonce();
        self.send_until_answered(opcode, Request { opcode: opcode as u8, boot: 0, nonce, run_id, argument })
    }

    /// Accepts the new centre of a run, by the name under which it was shown.
    ///
    /// # Errors
    /// As [`command`](Self::command), and [`SessionError::Silence`] when it was not shown.
    pub(super) fn accept(&mut self, run_id: u16) -> Result<Answer, SessionError> {
        let shown = |inbox: &Inbox| {
            let decided =
                inbox.outcome.is_some_and(|outcome| outcome.run_id == run_id && outcome.reason == Reason::Fine);
            inbox.naming.filter(|naming| naming.run_id == run_id && decided)
        };
        let naming = self.wait_for("whole report of the new centre", ANSWER_LIMIT_MS, shown)?;
        let nonce = self.next_nonce();
        self.send_until_answered(Opcode::Accept, Request::naming(Opcode::Accept, nonce, &naming))
    }

    /// Asks about a parameter and waits for the answer.
    ///
    /// # Errors
    /// [`SessionError::ParameterRefused`] when the board does not obey.
    pub(super) fn parameter(&mut self, request: ParameterRequest) -> Result<(), SessionError> {
        let frame = request.pack(self.base.parameters());
        for _ in 0..ANSWER_LIMIT_MS / REPEAT_MS {
            self.inbox.parameter = None;
            self.bench.send(&frame)?;
            let meant = |inbox: &Inbox| {
                let is_meant =
                    |answer: &ParameterAnswer| (answer.operation, answer.index) == (request.operation, request.index);
                inbox.parameter.filter(is_meant)
            };
            match self.wait_for("answer about a parameter", REPEAT_MS, meant) {
                Ok(answer) if answer.code == Reason::Fine => return Ok(()),
                Ok(answer) => return Err(SessionError::ParameterRefused(answer)),
                Err(SessionError::Silence(_)) => {}
                Err(error) => return Err(error),
            }
        }
        Err(SessionError::Silence("answer about a parameter"))
    }

    fn next_nonce(&mut self) -> u16 {
        // 0 means that there is no nonce.
        self.nonce = self.nonce.checked_add(1).unwrap_or(1);
        self.nonce
    }

    fn send_until_answered(&mut self, opcode: Opcode, request: Request) -> Result<Answer, SessionError> {
        let (nonce, frame) = (request.nonce, request.pack(self.base.command()));
        for _ in 0..ANSWER_LIMIT_MS / REPEAT_MS {
            self.bench.send(&frame)?;
            match self.wait_for("answer", REPEAT_MS, |inbox| inbox.answers.get(&nonce).copied()) {
                Ok(answer) if answer.code == Reason::Fine => return Ok(answer),
                Ok(answer) => return Err(SessionError::Refused(opcode, answer)),
                Err(SessionError::Silence(_)) => {}
                Err(error) => return Err(error),
            }
        }
        Err(SessionError::Silence("answer"))
    }

    /// Sends a command that needs a still arm, again and again until the board agrees that it is still.
    ///
    /// # Errors
    /// As [`command`](Self::command); [`SessionError::Refused`] also when it never agrees.
    pub(super) fn command_when_still(&mut self, opcode: Opcode, argument: u16) -> Result<Answer, SessionError> {
        let mut result = self.command(opcode, 0, argument);
        for _ in 1..STILL_LIMIT_MS / RETRY_MS {
            match result {
                // An arm that is coming to rest may for a moment move one cable only; a host that had too much to do may
                // have sent no counts for a while.
                Err(SessionError::Refused(_, Answer { code, .. })) if passes_by_holding_still(code) => {
                    self.hold(RETRY_MS)?;
                    result = self.command(opcode, 0, argument);
                }
                _ => break,
            }
        }
        result
    }

    /// A command about a run, again while the board is still sending a read-out: it sends every captured pose by itself.
    ///
    /// # Errors
    /// As [`command`](Self::command), and [`SessionError::Silence`] when the read-out never ends.
    pub(super) fn command_when_sent(
        &mut self,
        opcode: Opcode,
        run: u16,
        argument: u16,
    ) -> Result<Answer, SessionError> {
        for _ in 0..STILL_LIMIT_MS / RETRY_MS {
            match self.command(opcode, run, argument) {
                Err(SessionError::Refused(_, Answer { code: Reason::Busy, .. })) => self.hold(RETRY_MS)?,
                result => return result,
            }
        }
        Err(SessionError::Silence("end of the read-out"))
    }
}

fn passes_by_holding_still(reason: Reason) -> bool {
    matches!(reason, Reason::ArmMoving | Reason::CableLoose | Reason::EncoderSilent)
}
