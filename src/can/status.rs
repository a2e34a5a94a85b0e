//! Messages about the device: answers, heartbeat, faults, counters, versions.

use super::live_set::Standing;
use super::payload::{Field, Payload, RUN};
use crate::procedure::{Guidance, Reason, StateName};
use crate::restart::ResetCause;

/// The answer to one command. Every command frame gets exactly one, also what is no command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Answer {
    /// The command's opcode, repeated.
    pub opcode: u8,
    /// [`Reason::Fine`] when the command was obeyed.
    pub code: Reason,
    /// The command's nonce, repeated.
    pub nonce: u16,
    /// The run after the command; 0 before the first run.
    pub run_id: u16,
    /// Depends on opcode and code: index of the captured pose, number of the cable, code of the state.
    pub detail: u16,
}

mod answer {
    use super::Field;
    pub(super) const OPCODE: Field = Field::integer(0, 8);
    pub(super) const CODE: Field = Field::integer(8, 8);
    pub(super) const NONCE: Field = Field::integer(16, 16);
    pub(super) const RUN_ID: Field = Field::integer(32, 16);
    pub(super) const DETAIL: Field = Field::integer(48, 16);
}

impl Answer {
    pub(super) fn pack(&self) -> Payload {
        Payload::new()
            .with(answer::OPCODE, self.opcode)
            .with(answer::CODE, self.code.code())
            .with(answer::NONCE, self.nonce)
            .with(answer::RUN_ID, self.run_id)
            .with(answer::DETAIL, self.detail)
    }

    pub(super) fn unpack(payload: Payload) -> Option<Self> {
        Some(Self {
            opcode: payload.get_u8(answer::OPCODE),
            code: Reason::from_code(payload.get_u8(answer::CODE))?,
            nonce: payload.get_u16(answer::NONCE),
            run_id: payload.get_u16(answer::RUN_ID),
            detail: payload.get_u16(answer::DETAIL),
        })
    }
}

/// Where the run stands. Sent at a fixed pace in every state, so that a client that comes back knows at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Heartbeat {
    /// The run that is under way, or was last; 0 before the first.
    pub run_id: u16,
    /// The state.
    pub state: StateName,
    /// What the person at the arm should do now.
    pub guidance: Guidance,
    /// Poses captured in the present set (the second set while verifying).
    pub poses: u8,
    /// How far the run is, percent. 100 only when the new centre is there and verified.
    pub progress_percent: u8,
    /// Why the run stands where it stands, or what disturbs it now.
    pub reason: Reason,
    /// The flags.
    pub flags: Flags,
    /// May the centre in use be used?
    pub standing: Standing,
    /// Counts the heartbeats; a gap shows lost frames, a restart at 0 a reset device.
    pub sequence: u8,
}

/// What is so or not so, in the heartbeat.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Flags {
    /// An accepted centre is in use.
    pub live: bool,
    /// The arm is still.
    pub still: bool,
    /// Encoder counts arrive, and none of them is frozen or has jumped.
    pub encoders: bool,
    /// The button is down (debounced).
    pub button: bool,
    /// A report waits to be acknowledged.
    pub unacknowledged: bool,
    /// Poses are captured by command only.
    pub by_command_only: bool,
    /// The first of two phases: the shoulder blade is to be held.
    pub held_phase: bool,
}

mod heartbeat {
    use super::Field;
    pub(super) const STATE: Field = Field::integer(16, 4);
    pub(super) const GUIDANCE: Field = Field::integer(20, 4);
    pub(super) const POSES: Field = Field::integer(24, 8);
    pub(super) const PROGRESS: Field = Field::integer(32, 7);
    pub(super) const HELD_PHASE: Field = Field::integer(39, 1);
    pub(super) const REASON: Field = Field::integer(40, 8);
    pub(super) const LIVE: Field = Field::integer(48, 1);
    pub(super) const STILL: Field = Field::integer(49, 1);
    pub(super) const ENCODERS: Field = Field::integer(50, 1);
    pub(super) const BUTTON: Field = Field::integer(51, 1);
    pub(super) const UNACKNOWLEDGED: Field = Field::integer(52, 1);
    pub(super) const BY_COMMAND_ONLY: Field = Field::integer(53, 1);
    pub(super) const STANDING: Field = Field::integer(54, 2);
    pub(super) const SEQUENCE: Field = Field::integer(56, 8);
}

impl Heartbeat {
    pub(super) fn pack(&self) -> Payload {
        Payload::new()
            .with(RUN, self.run_id)
            .with(heartbeat::STATE, self.state.code())
            .with(heartbeat::GUIDANCE, self.guidance.code())
            .with(heartbeat::POSES, self.poses)
            .with(heartbeat::PROGRESS, self.progress_percent)
            .with(heartbeat::REASON, self.reason.code())
            .with(heartbeat::LIVE, self.flags.live)
            .with(heartbeat::STILL, self.flags.still)
            .with(heartbeat::ENCODERS, self.flags.encoders)
            .with(heartbeat::BUTTON, self.flags.button)
            .with(heartbeat::UNACKNOWLEDGED, self.flags.unacknowledged)
            .with(heartbeat::BY_COMMAND_ONLY, self.flags.by_command_only)
            .with(heartbeat::HELD_PHASE, self.flags.held_phase)
            .with(heartbeat::STANDING, self.standing.code())
            .with(heartbeat::SEQUENCE, self.sequence)
    }

    pub(super) fn unpack(payload: Payload) -> Option<Self> {
        Some(Self {
            run_id: payload.get_u16(RUN),
            state: StateName::from_code(payload.get_u8(heartbeat::STATE))?,
            guidance: Guidance::from_code(payload.get_u8(heartbeat::GUIDANCE))?,
            poses: payload.get_u8(heartbeat::POSES),
            progress_percent: payload.get_u8(heartbeat::PROGRESS),
            reason: Reason::from_code(payload.get_u8(heartbeat::REASON))?,
            flags: Flags {
                live: payload.get_flag(heartbeat::LIVE),
                still: payload.get_flag(heartbeat::STILL),
                encoders: payload.get_flag(heartbeat::ENCODERS),
                button: payload.get_flag(heartbeat::BUTTON),
                unacknowledged: payload.get_flag(heartbeat::UNACKNOWLEDGED),
                by_command_only: payload.get_flag(heartbeat::BY_COMMAND_ONLY),
                held_phase: payload.get_flag(heartbeat::HELD_PHASE),
            },
            standing: Standing::from_code(payload.get_u8(heartbeat::STANDING))?,
            sequence: payload.get_u8(heartbeat::SEQUENCE),
        })
    }
}

/// Something is wrong with a cable, the button or the bus. Sent when it begins, while it lasts, and when it ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Fault {
    /// The run that it disturbs; 0 before the first.
    pub run_id: u16,
    /// What is wrong.
    pub code: Reason,
    /// Cable 1 to 6, 0 when none is meant.
    pub cable: u8,
    /// It lasts.
    pub active: bool,
    /// How often it has begun since power-up.
    pub count: u16,
}

mod fault {
    use super::Field;
    pub(super) const CODE: Field = Field::integer(16, 8);
    pub(super) const CABLE: Field = Field::integer(24, 8);
    pub(super) const ACTIVE: Field = Field::integer(32, 1);
    pub(super) const COUNT: Field = Field::integer(40, 16);
}

impl Fault {
    pub(super) fn pack(&self) -> Payload {
        Payload::new()
            .with(RUN, self.run_id)
            .with(fault::CODE, self.code.code())
            .with(fault::CABLE, self.cable)
            .with(fault::ACTIVE, self.active)
            .with(fault::COUNT, self.count)
    }

    pub(super) fn unpack(payload: Payload) -> Option<Self> {
        Some(Self {
            run_id: payload.get_u16(RUN),
            code: Reason::from_code(payload.get_u8(fault::CODE))?,
            cable: payload.get_u8(fault::CABLE),
            active: payload.get_flag(fault::ACTIVE),
            count: payload.get_u16(fault::COUNT),
        })
    }
}

/// Which device this is. Sent at power-up and on query.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Versions {
    /// Number of this vocabulary; a client that knows another must not go on.
    pub protocol: u8,
    /// Firmware version major.minor.patch.
    pub firmware: [u8; 3],
    /// Why the device last started.
    pub reset_cause: ResetCause,
    /// Poses that the first set has room for.
    pub capacity: u8,
    /// Fingerprint of the rig's constants.
    pub rig: u16,
}

mod versions {
    use super::Field;
    pub(super) const PROTOCOL: Field = Field::integer(0, 8);
    pub(super) const MAJOR: Field = Field::integer(8, 8);
    pub(super) const MINOR: Field = Field::integer(16, 8);
    pub(super) const PATCH: Field = Field::integer(24, 8);
    pub(super) const RESET_CAUSE: Field = Field::integer(32, 8);
    pub(super) const CAPACITY: Field = Field::integer(40, 8);
    pub(super) const RIG: Field = Field::integer(48, 16);
}

impl Versions {
    pub(super) fn pack(&self) -> Payload {
        let [major, minor, patch] = self.firmware;
        Payload::new()
            .with(versions::PROTOCOL, self.protocol)
            .with(versions::MAJOR, major)
            .with(versions::MINOR, minor)
            .with(versions::PATCH, patch)
            .with(versions::RESET_CAUSE, self.reset_cause.code())
            .with(versions::CAPACITY, self.capacity)
            .with(versions::RIG, self.rig)
    }

    pub(super) fn unpack(payload: Payload) -> Option<Self> {
        Some(Self {
            protocol: payload.get_u8(versions::PROTOCOL),
            firmware: [versions::MAJOR, versions::MINOR, versions::PATCH].map(|field| payload.get_u8(field)),
            reset_cause: ResetCause::from_code(payload.get_u8(versions::RESET_CAUSE))?,
            capacity: payload.get_u8(versions::CAPACITY),
            rig: payload.get_u16(versions::RIG),
        })
    }
}

/// What went by or went wrong on the bus since power-up. All counters stop at their largest value.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Counters {
    /// Frames of others, up to 2^24 - 1.
    pub foreign: u32,
    /// Frames with our command identifier that were no command.
    pub malformed: u16,
    /// Frames that the board lost before they were read, up to 4095.
    pub overruns: u16,
    /// Values that did not fit their field and were reported as a fault instead, up to 4095.
    pub unsendable: u16,
}

mod counters {
    use super::Field;
    pub(super) const FOREIGN: Field = Field::integer(0, 24);
    pub(super) const MALFORMED: Field = Field::integer(24, 16);
    pub(super) const OVERRUNS: Field = Field::integer(40, 12);
    pub(super) const UNSENDABLE: Field = Field::integer(52, 12);
}

impl Counters {
    pub(super) fn pack(&self) -> Payload {
        Payload::new()
            .with(counters::FOREIGN, self.foreign.min(0xFF_FFFF))
            .with(counters::MALFORMED, self.malformed)
            .with(counters::OVERRUNS, self.overruns.min(0xFFF))
            .with(counters::UNSENDABLE, self.unsendable.min(0xFFF))
    }

    pub(super) fn unpack(payload: Payload) -> Self {
        Self {
            foreign: payload.get(counters::FOREIGN),
            malformed: payload.get_u16(counters::MALFORMED),
            overruns: payload.get_u16(counters::OVERRUNS),
            unsendable: payload.get_u16(counters::UNSENDABLE),
        }
    }
}
