//! What a press of the button asks for in each state.

use super::{Action, Device, LogEntry, Press};
use crate::procedure::{Command, Reason, StateName};

/// The command that a press stands for; None when it stands for nothing in this state.
///
/// | | short | long | very long |
/// |---|---|---|---|
/// | idle | (acknowledge a warning of the slip monitor) | start | |
/// | collecting | capture | identify | abort |
/// | identifying | | | abort |
/// | verifying | capture | verify | abort |
/// | review | | accept | abort |
/// | failed | acknowledge | acknowledge | abort |
pub(super) const fn command_of(press: Press, state: StateName) -> Option<Command> {
    match (press, state) {
        (Press::VeryLong, StateName::Idle) => None,
        (Press::VeryLong, _) => Some(Command::Abort),
        (Press::Short, StateName::Collecting | StateName::Verifying) => Some(Command::Capture),
        (Press::Short | Press::Long, StateName::Failed) => Some(Command::Acknowledge),
        (Press::Long, StateName::Idle) => Some(Command::Start { by_command_only: false }),
        (Press::Long, StateName::Collecting) => Some(Command::Identify),
        (Press::Long, StateName::Verifying) => Some(Command::Verify),
        (Press::Long, StateName::Review) => Some(Command::Accept),
        (Press::Short, StateName::Idle | StateName::Review) | (_, StateName::Identifying) => None,
    }
}

impl Device {
    pub(super) fn press(&mut self, now_ms: u32, press: Press, out: &mut impl FnMut(Action)) {
        let asked = match (press, self.procedure.state()) {
            // A short press says that the slip monitor's warning has been seen.
            (Press::Short, StateName::Idle) if self.slip_monitor.warning().is_some() => Some(Command::Acknowledge),
            (press, state) => command_of(press, state),
        };
        let reason = match asked {
            Some(command) => self.command(now_ms, command, out).0,
            None => Reason::WrongState,
        };
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
