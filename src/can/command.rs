//! What a client asks of the device, and how a frame becomes a command or a reason why it is none.

use super::frame::Frame;
use super::payload::{Field, Payload};
use crate::procedure::{Command, PoseSet, Reason};

const OPCODE: Field = Field::integer(0, 8);
/// Accept and Confirm: low byte of the boot number. Otherwise 0.
const BOOT: Field = Field::integer(8, 8);
const NONCE: Field = Field::integer(16, 16);
const RUN_ID: Field = Field::integer(32, 16);
const ARGUMENT: Field = Field::integer(48, 16);
/// One step of the argument of [`Opcode::SetZeroPrior`], mm: 2^-10.
pub const ZERO_PRIOR_STEP_MM: f32 = 1.0 / 1024.0;
/// In the argument of [`Opcode::Start`]: poses are captured by command only.
pub const BY_COMMAND_ONLY: u16 = 1;
/// In the argument of [`Opcode::Start`]: two phases, the first with the shoulder blade held.
pub const HELD_FIRST: u16 = 2;
/// In the argument of [`Opcode::Start`]: poses are captured while the arm moves slowly as well, even by a run that captures
/// the others by command only.
pub const IN_MOTION: u16 = 4;
/// In the argument of [`Opcode::ReadPose`]: the second set is meant.
const HELD_OUT: u16 = 0x100;

/// The commands' numbers on the wire. Never renumbered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Opcode {
    /// Start a run. Argument bit 0: poses are captured by command only; bit 1: two phases, the first with the shoulder
    /// blade held; bit 2: poses are captured while the arm moves slowly as well.
    Start = 1,
    /// Take the pose in which the arm is now.
    Capture = 2,
    /// End the collecting and identify.
    Identify = 3,
    /// End the second collecting and verify.
    Verify = 4,
    /// Put the new centre into use. Must name run, boot and checksum of the value that was shown.
    Accept = 5,
    /// Drop the new centre. Must name the run.
    Reject = 6,
    /// Drop the run and everything collected in it.
    Abort = 7,
    /// The report has been received. Must name the run.
    Acknowledge = 8,
    /// Send the six lengths of pose k. Argument: k, plus 256 for the second set. Must name the run.
    ReadPose = 9,
    /// Send everything that is known: versions, counters, live centre, the report of the run.
    Query = 10,
    /// How well the encoder zeros are known in the runs to come. Argument: 1σ in steps of 2^-10 mm; 0 = exactly.
    SetZeroPrior = 11,
    /// Whose arm the runs to come are made for. Argument: the wearer's number, 0 = not said.
    SetWearer = 12,
    /// The centre in use is right for the arm that is in the machine now. Must name run, boot and checksum of the value
    /// in use, as Accept does of the new one.
    Confirm = 13,
    /// Has the named cable been pulled since this was first asked, and moved its own encoder? Argument: the cable, 1 to 6.
    CheckCable = 14,
}

impl Opcode {
    /// All opcodes in order.
    pub const ALL: [Opcode; 14] = [
        Self::Start,
        Self::Capture,
        Self::Identify,
        Self::Verify,
        Self::Accept,
        Self::Reject,
        Self::Abort,
        Self::Acknowledge,
        Self::ReadPose,
        Self::Query,
        Self::SetZeroPrior,
        Self::SetWearer,
        Self::Confirm,
        Self::CheckCable,
    ];

    /// The opcode with this number.
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|opcode| *opcode as u8 == code)
    }

    /// Must the command name the run that it is meant for? Then a late frame of an old client cannot decide on a run
    /// that it has never seen.
    const fn must_name_run(self) -> bool {
        matches!(self, Self::Accept | Self::Reject | Self::Acknowledge | Self::ReadPose | Self::Confirm)
    }

    /// Does the command name a value, by boot, run and checksum?
    const fn names_value(self) -> bool {
        matches!(self, Self::Accept | Self::Confirm)
    }

    /// May the command name a run at all?
    const fn may_name_run(self) -> bool {
        !matches!(self, Self::Start | Self::Query | Self::SetZeroPrior | Self::SetWearer | Self::CheckCable)
    }
}

/// A command frame, taken apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Request {
    /// The opcode as it was sent, known or not: the answer repeats it.
    pub opcode: u8,
    /// Accept and Confirm: low byte of the number of the boot in which the value was found. Otherwise 0.
    pub boot: u8,
    /// Chosen by the client; the answer repeats it. 0 = no nonce.
    pub nonce: u16,
    /// The run that the command is meant for; 0 = whichever is under way.
    pub run_id: u16,
    /// Meaning depends on the opcode.
    pub argument: u16,
}

/// What a well-formed request asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Order {
    /// For the procedure.
    Procedure(Command),
    /// Send the lengths of one pose.
    ReadPose {
        /// Which set of poses.
        set: PoseSet,
        /// Index of the pose in it, from 0.
        index: u8,
    },
    /// Send everything that is known.
    Query,
    /// Put the new centre into use, if it is the one that is named.
    Accept(NamedValue),
    /// Confirm the centre in use, if it is the one that is named.
    Confirm(NamedValue),
    /// The runs to come are made for this wearer.
    SetWearer {
        /// The wearer's number; 0 = not said.
        wearer: u16,
    },
    /// Look whether this cable, 1 to 6, was pulled and moved its own encoder.
    CheckCable {
        /// The cable.
        cable: u8,
    },
    /// The zeros of the runs to come are known to so many steps of [`ZERO_PRIOR_STEP_MM`], 1σ; 0 = exactly.
    SetZeroPrior {
        /// Steps.
        steps: u16,
    },
}

/// The value that an accept or a confirmation means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NamedValue {
    /// The run that found it.
    pub run_id: u16,
    /// Low byte of the boot's number.
    pub boot: u8,
    /// [`checksum`](super::identity::checksum) of the frames that showed it.
    pub checksum: u16,
}

impl Request {
    /// The accept or the confirmation of a value that was shown, for clients and tests.
    pub const fn naming(opcode: Opcode, nonce: u16, value: &super::identity::Naming) -> Self {
        Self { opcode: opcode as u8, boot: value.boot as u8, nonce, run_id: value.run_id, argument: value.checksum }
    }

    /// The frame of this request, for clients and tests.
    pub fn pack(&self, id: embedded_can::StandardId) -> Frame {
        let payload = Payload::new()
            .with(OPCODE, self.opcode)
            .with(BOOT, self.boot)
            .with(NONCE, self.nonce)
            .with(RUN_ID, self.run_id)
            .with(ARGUMENT, self.argument);
        Frame::of_eight(id, payload.to_bytes())
    }

    /// Takes a command frame's bytes apart. Even what is no command yields what can be read of it, so that the answer
    /// can repeat opcode and nonce.
    ///
    /// # Errors
    /// The request as far as it could be read, with [`Reason::WrongLength`] or [`Reason::ReservedNotZero`].
    pub fn unpack(data: &[u8]) -> Result<Self, (Self, Reason)> {
        let (payload, is_whole) = Payload::of_data(data);
        let request = Self {
            opcode: payload.get_u8(OPCODE),
            boot: payload.get_u8(BOOT),
            nonce: payload.get_u16(NONCE),
            run_id: payload.get_u16(RUN_ID),
            argument: payload.get_u16(ARGUMENT),
        };
        if !is_whole {
            Err((request, Reason::WrongLength))
        } else if request.boot != 0 && !Opcode::from_code(request.opcode).is_some_and(Opcode::names_value) {
            Err((request, Reason::ReservedNotZero))
        } else {
            Ok(request)
        }
    }

    /// What the request asks for, given the run that is under way (or was last).
    ///
    /// # Errors
    /// [`Reason::UnknownOpcode`], [`Reason::BadArgument`] (also: a run id where none belongs, or none where one must
    /// stand), [`Reason::StaleRun`].
    pub fn order(&self, current_run: u16) -> Result<Order, Reason> {
        let opcode = Opcode::from_code(self.opcode).ok_or(Reason::UnknownOpcode)?;
        if self.run_id == 0 && opcode.must_name_run() || self.run_id != 0 && !opcode.may_name_run() {
            return Err(Reason::BadArgument);
        }
        let value = NamedValue { run_id: self.run_id, boot: self.boot, checksum: self.argument };
        if opcode == Opcode::Confirm {
            return Ok(Order::Confirm(value));
        }
        if self.run_id != 0 && self.run_id != current_run {
            return Err(Reason::StaleRun);
        }
        let order = match (opcode, self.argument) {
            (Opcode::Start, 0..=7) => Order::Procedure(Command::Start {
                by_command_only: self.argument & BY_COMMAND_ONLY != 0,
                held_first: self.argument & HELD_FIRST != 0,
                in_motion: self.argument & IN_MOTION != 0,
            }),
            (Opcode::ReadPose, argument) if argument < 2 * HELD_OUT => Order::ReadPose {
                set: if argument & HELD_OUT == 0 { PoseSet::Identification } else { PoseSet::HeldOut },
                index: (argument & 0xFF) as u8,
            },
            (Opcode::SetZeroPrior, steps) => Order::SetZeroPrior { steps },
            (Opcode::SetWearer, wearer) => Order::SetWearer { wearer },
            // within six by its range
            (Opcode::CheckCable, cable @ 1..=6) => Order::CheckCable { cable: cable as u8 },
            (Opcode::Accept, _) => Order::Accept(value),
            (_, argument) if argument != 0 => return Err(Reason::BadArgument),
            (Opcode::Capture, _) => Order::Procedure(Command::Capture),
            (Opcode::Identify, _) => Order::Procedure(Command::Identify),
            (Opcode::Verify, _) => Order::Procedure(Command::Verify),
            (Opcode::Reject, _) => Order::Procedure(Command::Reject),
            (Opcode::Abort, _) => Order::Procedure(Command::Abort),
            (Opcode::Acknowledge, _) => Order::Procedure(Command::Acknowledge),
            (Opcode::Query, _) => Order::Query,
            (Opcode::Start | Opcode::ReadPose | Opcode::Confirm | Opcode::CheckCable, _) => {
                return Err(Reason::BadArgument);
            }
        };
        Ok(order)
    }
}
