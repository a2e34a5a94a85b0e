//! The table of all transitions. The procedure has no other way to change its state.

use super::state::{Command, StateName};

/// Everything that can move the procedure from one state to another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Trigger {
    /// A run is asked for and the arm is ready.
    Start,
    /// The first set is ended: by command, or because it is good enough, full, or overdue.
    Identify,
    /// The solver found the centre.
    Found,
    /// The held phase has fixed the centre in the platform: the free phase begins.
    HeldFound,
    /// The solver refused the set, and more poses can cure it.
    WantsMore,
    /// The solver refused the set for good, or too often.
    GaveUp,
    /// The second set agrees with the centre.
    Verified,
    /// The second set contradicts the centre.
    Contradicted,
    /// The new centre is taken into use.
    Accept,
    /// The new centre is dropped.
    Reject,
    /// The run is dropped.
    Abort,
    /// The end of the run has been seen.
    Acknowledge,
    /// The time of the state has run out.
    Timeout,
    /// An encoder lost its count: poses before and after do not belong together.
    CountLost,
}

impl Trigger {
    /// All triggers.
    pub const ALL: [Self; 14] = [
        Self::Start,
        Self::Identify,
        Self::Found,
        Self::HeldFound,
        Self::WantsMore,
        Self::GaveUp,
        Self::Verified,
        Self::Contradicted,
        Self::Accept,
        Self::Reject,
        Self::Abort,
        Self::Acknowledge,
        Self::Timeout,
        Self::CountLost,
    ];
}

/// The state that follows, None when the trigger means nothing in this state.
pub const fn next(state: StateName, trigger: Trigger) -> Option<StateName> {
    use StateName::{Collecting, Failed, Identifying, Idle, Review, Verifying};
    use Trigger as T;
    Some(match (state, trigger) {
        (Idle, T::Start) => Collecting,
        (Idle, T::Abort | T::Acknowledge) => Idle,

        (Collecting, T::Identify) => Identifying,
        (Collecting, T::Timeout | T::CountLost) => Failed,
        (Collecting, T::Abort) => Idle,

        (Identifying, T::Found) => Verifying,
        (Identifying, T::HeldFound | T::WantsMore) => Collecting,
        (Identifying, T::GaveUp) => Failed,
        (Identifying, T::Abort) => Idle,

        (Verifying, T::Verified) => Review,
        (Verifying, T::Contradicted | T::Timeout | T::CountLost) => Failed,
        (Verifying, T::Abort) => Idle,

        (Review, T::Accept | T::Reject | T::Abort) => Idle,
        (Review, T::Acknowledge) => Review,
        (Review, T::Timeout) => Failed,

        (Failed, T::Acknowledge | T::Abort) => Idle,

        _ => return None,
    })
}

/// Has the command a meaning in the state? Whether it is obeyed depends on more: the arm, the poses, the encoders.
pub const fn allows(state: StateName, command: Command) -> bool {
    use StateName::{Collecting, Verifying};
    match command {
        Command::Start { .. } => next(state, Trigger::Start).is_some(),
        Command::Capture => matches!(state, Collecting | Verifying),
        Command::Identify => next(state, Trigger::Identify).is_some(),
        Command::Verify => matches!(state, Verifying),
        Command::Accept => next(state, Trigger::Accept).is_some(),
        Command::Reject => next(state, Trigger::Reject).is_some(),
        Command::Abort => next(state, Trigger::Abort).is_some(),
        Command::Acknowledge => next(state, Trigger::Acknowledge).is_some(),
    }
}
