//! What a press of the button asks for in each state.

use super::commands::Asked;
use super::{Action, BlinkPattern, Device, Held, LogEntry, Press};
use crate::procedure::{Command, Reason, StateName};

/// The command that a press stands for; None when it stands for nothing in this state.
///
/// | | short | long | very long |
/// |---|---|---|---|
/// | idle | (acknowledge a warning of the slip monitor) | start | start with the shoulder blade held |
/// | collecting | capture | identify | abort |
/// | identifying | | | abort |
/// | verifying | capture | verify | abort |
/// | review | count | accept, after as many short presses as the LED blinks | abort |
/// | failed | acknowledge | acknowledge | abort |
pub(super) const fn command_of(press: Press, state: StateName) -> Option<Command> {
    match (press, state) {
        (Press::VeryLong, StateName::Idle) => Some(start(true)),
        (Press::VeryLong, _) => Some(Command::Abort),
        (Press::Short, StateName::Collecting | StateName::Verifying) => Some(Command::Capture),
        (Press::Short | Press::Long, StateName::Failed) => Some(Command::Acknowledge),
        (Press::Long, StateName::Idle) => Some(start(false)),
        (Press::Long, StateName::Collecting) => Some(Command::Identify),
        (Press::Long, StateName::Verifying) => Some(Command::Verify),
        (Press::Long, StateName::Review) => Some(Command::Accept),
        (Press::Short, StateName::Idle | StateName::Review) | (_, StateName::Identifying) => None,
    }
}

/// Whether poses are captured in motion as well, a parameter says.
const fn start(held_first: bool) -> Command {
    Command::Start { by_command_only: false, held_first, in_motion: false }
}

/// Short presses in review may lie so far apart, ms, and the long one so far behind them.
const BETWEEN_MS: u32 = 3_000;

/// The short presses with which an accept begins: as many as the LED blinks.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ConfirmingPresses {
    count: u8,
    last_ms: u32,
}

impl ConfirmingPresses {
    fn add(&mut self, now_ms: u32) {
        let goes_on = self.count != 0 && now_ms.wrapping_sub(self.last_ms) <= BETWEEN_MS;
        self.count = if goes_on { self.count.saturating_add(1) } else { 1 };
        self.last_ms = now_ms;
    }

    /// The short presses so far, if they are fresh; then none.
    fn take(&mut self, now_ms: u32) -> u8 {
        let count = if now_ms.wrapping_sub(self.last_ms) <= BETWEEN_MS { self.count } else { 0 };
        *self = Self::default();
        count
    }
}

/// How often the LED blinks for a new centre, 2 to 4: it depends on the value, so a person who presses as often has looked.
const fn blinks(checksum: u16) -> u8 {
    (checksum % 3) as u8 + 2
}

impl Device {
    /// Looks at the button. A press belongs to the state in which it began: what has come up meanwhile was not what the
    /// person meant.
    pub(super) fn tick_button(&mut self, now_ms: u32, out: &mut impl FnMut(Action)) {
        let was_up = self.button.held() == Held::Not;
        let press = self.button.tick(now_ms);
        let here = (self.procedure.state(), self.procedure.run_id());
        if was_up && self.button.held() != Held::Not {
            self.press_began = Some(here);
        }
        let Some(press) = press else { return };
        let Some((state, run_id)) = self.press_began.take() else { return };
        // a run can be aborted in whatever state it has come to
        let aborts = press == Press::VeryLong && run_id == here.1 && state != StateName::Idle;
        if (state, run_id) == here || aborts {
            self.press(now_ms, press, out);
        } else {
            self.pace.refuse(now_ms, Reason::WrongState);
            out(Action::Log(LogEntry::Press { press, reason: Reason::WrongState }));
        }
    }

    /// What the LED shows in review.
    pub(super) fn accept_pattern(&self) -> BlinkPattern {
        match self.shown_candidate().map(|shown| blinks(shown.checksum)) {
            Some(3) => BlinkPattern::Review3,
            Some(4) => BlinkPattern::Review4,
            _ => BlinkPattern::Review2,
        }
    }

    /// The long press of an accept: obeyed after as many short ones as the LED blinks, when all has been shown.
    fn accept_by_button(&mut self, now_ms: u32, out: &mut impl FnMut(Action)) -> Reason {
        let pressed = self.confirming.take(now_ms);
        match self.shown_candidate() {
            Some(shown) if blinks(shown.checksum) != pressed => Reason::WrongValue,
            Some(shown) if !self.reporter.has_shown(shown.run_id) => Reason::ReportIncomplete,
            Some(_) => self.command(now_ms, Command::Accept, out).map_or(Reason::Fine, |(reason, _)| reason),
            None if self.procedure.candidate().is_some() => Reason::ReportIncomplete,
            None => Reason::WrongState,
        }
    }

    fn press(&mut self, now_ms: u32, press: Press, out: &mut impl FnMut(Action)) {
        let asked = match (press, self.procedure.state()) {
            // A short press says that the slip monitor's warning has been seen.
            (Press::Short, StateName::Idle) if self.slip_monitor.warning().is_some() => Some(Command::Acknowledge),
            (press, state) => command_of(press, state),
        };
        let in_review = self.procedure.state() == StateName::Review;
        let reason = match asked {
            Some(Command::Accept) => self.accept_by_button(now_ms, out),
            Some(command) => match self.command(now_ms, command, out) {
                Some((reason, _)) => reason,
                None => {
                    self.capture_asked = Some(Asked::ByButton(press));
                    return;
                }
            },
            None if press == Press::Short && in_review => {
                self.confirming.add(now_ms);
                Reason::Fine
            }
            None => Reason::WrongState,
        };
        self.answer_press(now_ms, press, reason, out);
    }

    /// Shows and notes what became of a press.
    pub(super) fn answer_press(&mut self, now_ms: u32, press: Press, reason: Reason, out: &mut impl FnMut(Action)) {
        if reason != Reason::Fine {
            self.pace.refuse(now_ms, reason);
        }
        out(Action::Log(LogEntry::Press { press, reason }));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::procedure::transition::allows;

    #[test]
    fn a_press_never_asks_for_what_the_state_forbids() {
        for press in [Press::Short, Press::Long, Press::VeryLong] {
            for state in StateName::ALL {
                if let Some(command) = command_of(press, state) {
                    assert!(allows(state, command), "{press:?} {state:?}");
                }
            }
        }
    }

    #[test]
    fn every_run_can_be_aborted_by_the_button() {
        for state in StateName::ALL.into_iter().filter(|state| *state != StateName::Idle) {
            assert_eq!(command_of(Press::VeryLong, state), Some(Command::Abort));
        }
    }
}
