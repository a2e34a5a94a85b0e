//! The answer to a command.

use super::outcome::PoseNotice;
use super::reason::Reason;
use super::state::{Command, StateName};
use super::transition::allows;

/// The answer to a command.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Reply {
    /// [`Reason::Fine`] when the command was obeyed.
    pub reason: Reason,
    /// Index of the captured pose, number of the cable that is meant, or code of the state; 0 otherwise.
    pub detail: u16,
    /// The pose, when one was refused.
    pub pose: Option<PoseNotice>,
    /// A pose is being captured, and the answer comes with a tick to come ([`Procedure::take_answer`](super::Procedure::take_answer)).
    pub is_later: bool,
}

impl Reply {
    pub(super) const FINE: Self = Self { reason: Reason::Fine, detail: 0, pose: None, is_later: false };
    pub(super) const LATER: Self = Self { is_later: true, ..Self::FINE };

    pub(super) const fn refused(reason: Reason, detail: u16) -> Self {
        Self { reason, detail, ..Self::FINE }
    }

    /// Why a command cannot be obeyed in this state; None when it can.
    pub(super) fn objection(state: StateName, command: Command) -> Option<Self> {
        if allows(state, command) {
            return None;
        }
        let reason = match (command, state) {
            (Command::Start { .. }, StateName::Failed) => Reason::AcknowledgeFirst,
            (Command::Start { .. }, _) => Reason::AlreadyRunning,
            _ => Reason::WrongState,
        };
        Some(Self::refused(reason, u16::from(state.code())))
    }
}
