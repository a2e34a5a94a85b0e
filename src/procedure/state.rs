//! The states by name, and what is asked of the procedure.

/// The states of the procedure. The numbers go over CAN and are never renumbered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum StateName {
    /// No run. The live centre, if there is one, is in use.
    Idle = 0,
    /// Poses are captured for the identification.
    Collecting = 1,
    /// The solver works, one slice a tick.
    Identifying = 2,
    /// The centre is found; poses of a second set are captured to verify it.
    Verifying = 3,
    /// The new centre stands beside the old one and waits for a decision.
    Review = 4,
    /// The run ended without a centre; the reason waits to be acknowledged.
    Failed = 5,
}

impl StateName {
    /// All states, in the order of their numbers.
    pub const ALL: [Self; 6] =
        [Self::Idle, Self::Collecting, Self::Identifying, Self::Verifying, Self::Review, Self::Failed];

    /// The number on the wire.
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// The state with this number.
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|state| state.code() == code)
    }
}

/// What a person or a client can ask for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Command {
    /// Begin a run.
    Start {
        /// Poses are captured, and both sets ended, by command only.
        by_command_only: bool,
        /// Two phases: first poses with the shoulder blade held, then free ones.
        held_first: bool,
        /// Poses are captured while the arm moves slowly as well.
        in_motion: bool,
    },
    /// Capture the pose in which the arm is held.
    Capture,
    /// End the first set and identify.
    Identify,
    /// End the second set and verify.
    Verify,
    /// Put the new centre into use.
    Accept,
    /// Drop the new centre.
    Reject,
    /// Drop the run and everything collected in it.
    Abort,
    /// The end of the run has been seen.
    Acknowledge,
}

/// Which of the two sets a pose belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum PoseSet {
    /// The first set: its poses identify the centre.
    Identification,
    /// The second set: its poses are never used to identify, only to verify.
    HeldOut,
}

impl PoseSet {
    /// The second set if `held_out`, else the first.
    pub const fn held_out_if(held_out: bool) -> Self {
        if held_out { Self::HeldOut } else { Self::Identification }
    }
}
