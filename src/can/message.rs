//! All messages of `glenoid.dbc` that the device sends, and the identifiers.

use super::frame::Frame;
use super::health::{BusHealth, LastStop, StopText};
use super::hinge::{HingeAngle, HingeAxis, HingePlace, Module};
use super::identity::{Identity, Naming};
use super::parameter::ParameterAnswer;
use super::payload::{PackError, Payload};
use super::report::{LeftOut, OutcomeReport, PoseReport, PoseSamples, RawLength};
use super::result::{Axis, MotionPart, Parameter, Quality, VerificationReport, WeakDirection, ZeroError};
use super::set::Piece;
use super::status::{Answer, Counters, Fault, Heartbeat, Versions};
use super::watch::WatchReport;
use embedded_can::StandardId;

/// Number of this vocabulary, sent in [`Versions`]. It grows when a message changes its meaning.
pub const PROTOCOL: u8 = 2;

/// How many identifiers, from the base on, belong to the device.
pub const BLOCK: u16 = 64;

/// The first of the [`BLOCK`] identifiers that a device uses: a multiple of 64. See the parameter `base_id`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BaseId(u16);

impl BaseId {
    /// The identifiers as they stand in `glenoid.dbc`: 0x680 to 0x6BF, which CANopen's predefined connection set (CiA
    /// 301, 7.3.3) leaves free.
    pub const DEFAULT: Self = Self(0x680);

    /// A base identifier, if it is a multiple of [`BLOCK`] within 11 bits.
    pub const fn new(base: u16) -> Option<Self> {
        if base.is_multiple_of(BLOCK) && base <= 0x7FF { Some(Self(base)) } else { None }
    }

    /// Identifier of the command frame. This one and [`BaseId::parameters`] are all that the device obeys.
    pub const fn command(self) -> StandardId {
        self.at(0)
    }

    /// Identifier of the requests about parameters.
    pub const fn parameters(self) -> StandardId {
        self.at(24)
    }

    /// The number.
    pub const fn raw(self) -> u16 {
        self.0
    }

    /// Is this one of the device's own identifiers?
    pub const fn owns(self, raw_id: u16) -> bool {
        raw_id & !(BLOCK - 1) == self.0
    }

    /// The identifier at an offset; offsets wrap within the block.
    pub(super) const fn at(self, offset: u8) -> StandardId {
        match StandardId::new(self.0 | (offset as u16 & (BLOCK - 1))) {
            Some(id) => id,
            // not reached: the constructor keeps the whole block within 11 bits
            None => StandardId::MAX,
        }
    }
}

/// Why a frame is none of the device's messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum UnpackError {
    /// The identifier is not one of the device's messages.
    Foreign = 1,
    /// A message of the device has 8 bytes.
    WrongLength = 2,
    /// A code in it is not assigned: the sender is of another version.
    UnknownCode = 3,
}

impl core::fmt::Display for UnpackError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Foreign => "not an identifier of this device",
            Self::WrongLength => "not 8 bytes",
            Self::UnknownCode => "a code that this version does not know",
        })
    }
}

impl core::error::Error for UnpackError {}

/// A message from the device. The order is that of the identifiers, hence of the priorities on the bus.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[allow(missing_docs, reason = "each variant is named after its content, which is documented")]
pub enum Message {
    Answer(Answer),
    Heartbeat(Heartbeat),
    Fault(Fault),
    Pose(PoseReport),
    Outcome(OutcomeReport),
    CandidateCentre(Parameter),
    CandidateRadius(Parameter),
    Quality(Quality),
    Verification(VerificationReport),
    WeakDirection(WeakDirection),
    LeftOut(LeftOut),
    Axis(Axis),
    LiveCentre(Parameter),
    LiveRadius(Parameter),
    RawLength(RawLength),
    Versions(Versions),
    Counters(Counters),
    BusHealth(BusHealth),
    LastStop(LastStop),
    StopText(StopText),
    CandidateZero(ZeroError),
    LiveZero(ZeroError),
    Watch(WatchReport),
    Parameter(ParameterAnswer),
    LiveSet(Piece),
    Telemetry(Piece),
    Identity(Identity),
    CandidateNaming(Naming),
    LiveNaming(Naming),
    CandidateMotion(MotionPart),
    LiveMotion(MotionPart),
    PoseSamples(PoseSamples),
    Module(Module),
    CandidateHingeAxis(HingeAxis),
    CandidateHingePlace(HingePlace),
    LiveHingeAxis(HingeAxis),
    LiveHingePlace(HingePlace),
    HingeAngle(HingeAngle),
}

impl Message {
    /// Distance of the message's identifier from the base.
    pub const fn offset(&self) -> u8 {
        match self {
            Self::Answer(_) => 1,
            Self::Heartbeat(_) => 2,
            Self::Fault(_) => 3,
            Self::Pose(_) => 4,
            Self::Outcome(_) => 5,
            Self::CandidateCentre(_) => 6,
            Self::CandidateRadius(_) => 7,
            Self::Quality(_) => 8,
            Self::Verification(_) => 9,
            Self::WeakDirection(_) => 10,
            Self::LeftOut(_) => 11,
            Self::Axis(_) => 12,
            Self::LiveCentre(_) => 13,
            Self::LiveRadius(_) => 14,
            Self::RawLength(_) => 15,
            Self::Versions(_) => 16,
            Self::Counters(_) => 17,
            Self::BusHealth(_) => 18,
            Self::LastStop(_) => 19,
            Self::StopText(_) => 20,
            Self::CandidateZero(_) => 21,
            Self::LiveZero(_) => 22,
            Self::Watch(_) => 23,
            Self::Parameter(_) => 25,
            Self::LiveSet(_) => 26,
            Self::Telemetry(_) => 27,
            Self::Identity(_) => 28,
            Self::CandidateNaming(_) => 29,
            Self::LiveNaming(_) => 30,
            Self::CandidateMotion(_) => 31,
            Self::LiveMotion(_) => 32,
            Self::PoseSamples(_) => 33,
            Self::Module(_) => 34,
            Self::CandidateHingeAxis(_) => 35,
            Self::CandidateHingePlace(_) => 36,
            Self::LiveHingeAxis(_) => 37,
            Self::LiveHingePlace(_) => 38,
            Self::HingeAngle(_) => 39,
        }
    }

    /// The frame of this message.
    ///
    /// # Errors
    /// [`PackError::OutOfRange`] when a value is no number or does not fit its field.
    pub fn pack(&self, base: BaseId) -> Result<Frame, PackError> {
        let payload = match self {
            Self::Answer(m) => m.pack(),
            Self::Heartbeat(m) => m.pack(),
            Self::Fault(m) => m.pack(),
            Self::Pose(m) => m.pack()?,
            Self::Outcome(m) => m.pack()?,
            Self::CandidateCentre(m) | Self::CandidateRadius(m) | Self::LiveCentre(m) | Self::LiveRadius(m) => {
                m.pack()?
            }
            Self::Quality(m) => m.pack()?,
            Self::Verification(m) => m.pack()?,
            Self::WeakDirection(m) => m.pack()?,
            Self::LeftOut(m) => m.pack(),
            Self::Axis(m) => m.pack()?,
            Self::RawLength(m) => m.pack()?,
            Self::Versions(m) => m.pack(),
            Self::Counters(m) => m.pack(),
            Self::BusHealth(m) => m.pack(),
            Self::LastStop(m) => m.pack(),
            Self::StopText(m) => m.pack(),
            Self::CandidateZero(m) | Self::LiveZero(m) => m.pack()?,
            Self::Watch(m) => m.pack()?,
            Self::Parameter(m) => m.pack(),
            Self::LiveSet(piece) | Self::Telemetry(piece) => Payload::from_bytes(*piece),
            Self::Identity(m) => m.pack(),
            Self::CandidateNaming(m) | Self::LiveNaming(m) => m.pack(),
            Self::CandidateMotion(m) | Self::LiveMotion(m) => m.pack(),
            Self::PoseSamples(m) => m.pack(),
            Self::Module(m) => m.pack(),
            Self::CandidateHingeAxis(m) | Self::LiveHingeAxis(m) => m.pack()?,
            Self::CandidateHingePlace(m) | Self::LiveHingePlace(m) => m.pack()?,
            Self::HingeAngle(m) => m.pack()?,
        };
        Ok(Frame::of_eight(base.at(self.offset()), payload.to_bytes()))
    }

    /// The message in a frame, for clients and tests.
    ///
    /// # Errors
    /// [`UnpackError`] says why the frame is none.
    pub fn unpack(frame: &Frame, base: BaseId) -> Result<Self, UnpackError> {
        if !base.owns(frame.raw_id()) {
            return Err(UnpackError::Foreign);
        }
        let bytes = <[u8; 8]>::try_from(frame.data()).map_err(|_| UnpackError::WrongLength)?;
        let payload = Payload::from_bytes(bytes);
        let message = match frame.raw_id() % BLOCK {
            1 => Answer::unpack(payload).map(Self::Answer),
            2 => Heartbeat::unpack(payload).map(Self::Heartbeat),
            3 => Fault::unpack(payload).map(Self::Fault),
            4 => PoseReport::unpack(payload).map(Self::Pose),
            5 => OutcomeReport::unpack(payload).map(Self::Outcome),
            6 => Some(Self::CandidateCentre(Parameter::unpack(payload))),
            7 => Some(Self::CandidateRadius(Parameter::unpack(payload))),
            8 => Some(Self::Quality(Quality::unpack(payload))),
            9 => Some(Self::Verification(VerificationReport::unpack(payload))),
            10 => Some(Self::WeakDirection(WeakDirection::unpack(payload))),
            11 => Some(Self::LeftOut(LeftOut::unpack(payload))),
            12 => Some(Self::Axis(Axis::unpack(payload))),
            13 => Some(Self::LiveCentre(Parameter::unpack(payload))),
            14 => Some(Self::LiveRadius(Parameter::unpack(payload))),
            15 => Some(Self::RawLength(RawLength::unpack(payload))),
            16 => Versions::unpack(payload).map(Self::Versions),
            17 => Some(Self::Counters(Counters::unpack(payload))),
            18 => Some(Self::BusHealth(BusHealth::unpack(payload))),
            19 => LastStop::unpack(payload).map(Self::LastStop),
            20 => Some(Self::StopText(StopText::unpack(payload))),
            21 => Some(Self::CandidateZero(ZeroError::unpack(payload))),
            22 => Some(Self::LiveZero(ZeroError::unpack(payload))),
            23 => WatchReport::unpack(payload).map(Self::Watch),
            25 => ParameterAnswer::unpack(payload).map(Self::Parameter),
            26 => Some(Self::LiveSet(bytes)),
            27 => Some(Self::Telemetry(bytes)),
            28 => Some(Self::Identity(Identity::unpack(payload))),
            29 => Some(Self::CandidateNaming(Naming::unpack(payload))),
            30 => Some(Self::LiveNaming(Naming::unpack(payload))),
            31 => Some(Self::CandidateMotion(MotionPart::unpack(payload))),
            32 => Some(Self::LiveMotion(MotionPart::unpack(payload))),
            33 => Some(Self::PoseSamples(PoseSamples::unpack(payload))),
            34 => Module::unpack(payload).map(Self::Module),
            35 => Some(Self::CandidateHingeAxis(HingeAxis::unpack(payload))),
            36 => Some(Self::CandidateHingePlace(HingePlace::unpack(payload))),
            37 => Some(Self::LiveHingeAxis(HingeAxis::unpack(payload))),
            38 => Some(Self::LiveHingePlace(HingePlace::unpack(payload))),
            39 => Some(Self::HingeAngle(HingeAngle::unpack(payload))),
            _ => return Err(UnpackError::Foreign),
        };
        message.ok_or(UnpackError::UnknownCode)
    }
}
