//! Messages about a hinge, and about the module itself: which joint it is about.

use super::payload::{Field, PackError, Payload, RUN};
use super::rounding::Scale;

/// A component of a direction: ±2 in steps of 2^-26; an `f32` of 1/8 or more comes through to the bit.
const DIRECTION: Scale = Scale::signed(28, -26);
/// A distance that holds an `f32` of 64 mm or more to the bit: ±1024 mm in steps of 2^-17 mm (8 nm).
const LENGTH: Scale = Scale::signed(28, -17);

/// A component of the direction of a hinge's axis, never without its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HingeAxis {
    /// The run that identified it.
    pub run_id: u16,
    /// 0 to 2: x, y, z in {B}; 3 to 5: x, y, z in {P}.
    pub index: u8,
    /// The component of a unit vector.
    pub value: f32,
    /// Its standard deviation, up to 0.5.
    pub sigma: f32,
}

mod axis {
    use super::{DIRECTION, Field, Scale};
    pub(super) const INDEX: Field = Field::integer(16, 4);
    pub(super) const VALUE: Field = Field::scaled(20, DIRECTION);
    pub(super) const SIGMA: Field = Field::scaled(48, Scale::unsigned(16, -17));
}

impl HingeAxis {
    pub(super) fn pack(&self) -> Result<Payload, PackError> {
        Payload::new()
            .with(RUN, self.run_id)
            .with(axis::INDEX, self.index)
            .with_value(axis::VALUE, self.value)?
            .with_value(axis::SIGMA, self.sigma)
    }

    pub(super) fn unpack(payload: Payload) -> Self {
        Self {
            run_id: payload.get_u16(RUN),
            index: payload.get_u8(axis::INDEX),
            value: payload.get_value(axis::VALUE),
            sigma: payload.get_value(axis::SIGMA),
        }
    }
}

/// A component of the place of a hinge's axis, never without its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HingePlace {
    /// The run that identified it.
    pub run_id: u16,
    /// 0 to 2: x, y, z of the axis' foot point in {B}; 3 to 5: the same in {P}; 6: how far the platform's foot point stands
    /// from the base's along the axis.
    pub index: u8,
    /// The value, mm.
    pub value_mm: f32,
    /// Its standard deviation, mm, up to 32.
    pub sigma_mm: f32,
}

mod place {
    use super::{Field, LENGTH, Scale};
    pub(super) const INDEX: Field = Field::integer(16, 4);
    pub(super) const VALUE: Field = Field::scaled(20, LENGTH);
    pub(super) const SIGMA: Field = Field::scaled(48, Scale::unsigned(16, -11));
}

impl HingePlace {
    pub(super) fn pack(&self) -> Result<Payload, PackError> {
        Payload::new()
            .with(RUN, self.run_id)
            .with(place::INDEX, self.index)
            .with_value(place::VALUE, self.value_mm)?
            .with_value(place::SIGMA, self.sigma_mm)
    }

    pub(super) fn unpack(payload: Payload) -> Self {
        Self {
            run_id: payload.get_u16(RUN),
            index: payload.get_u8(place::INDEX),
            value_mm: payload.get_value(place::VALUE),
            sigma_mm: payload.get_value(place::SIGMA),
        }
    }
}

/// Which joint a module is about. The numbers go over CAN and are never renumbered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum JointKind {
    /// A ball, or a centre that moves with the arm: a shoulder or a wrist.
    #[default]
    Ball = 0,
    /// A hinge: an elbow.
    Hinge = 1,
}

impl JointKind {
    /// All of them, in the order of the numbers.
    pub const ALL: [Self; 2] = [Self::Ball, Self::Hinge];

    /// The number on the wire.
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// The kind with this number.
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.code() == code)
    }
}

/// Which module this is. Sent behind the versions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Module {
    /// The joint that it is about.
    pub joint: JointKind,
    /// Its cables, which are also the encoders in use, from the first on.
    pub cables: u8,
    /// Poses that the first set has room for.
    pub capacity: u8,
    /// The same of the second set.
    pub held_out_capacity: u8,
    /// Fingerprint of the rig's constants.
    pub rig: u32,
}

mod module {
    use super::Field;
    pub(super) const JOINT: Field = Field::integer(0, 8);
    pub(super) const CABLES: Field = Field::integer(8, 8);
    pub(super) const CAPACITY: Field = Field::integer(16, 8);
    pub(super) const HELD_OUT_CAPACITY: Field = Field::integer(24, 8);
    pub(super) const RIG: Field = Field::integer(32, 32);
}

impl Module {
    pub(super) fn pack(&self) -> Payload {
        Payload::new()
            .with(module::JOINT, self.joint.code())
            .with(module::CABLES, self.cables)
            .with(module::CAPACITY, self.capacity)
            .with(module::HELD_OUT_CAPACITY, self.held_out_capacity)
            .with(module::RIG, self.rig)
    }

    pub(super) fn unpack(payload: Payload) -> Option<Self> {
        Some(Self {
            joint: JointKind::from_code(payload.get_u8(module::JOINT))?,
            cables: payload.get_u8(module::CABLES),
            capacity: payload.get_u8(module::CAPACITY),
            held_out_capacity: payload.get_u8(module::HELD_OUT_CAPACITY),
            rig: payload.get(module::RIG),
        })
    }
}

/// How far the joint bends now, from the pose in which the platform has the smallest rotation that brings its axis onto that
/// of the base. Sent with the telemetry while a hinge is in use and the encoders are believable.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HingeAngle {
    /// The run that found the hinge in use.
    pub run_id: u16,
    /// The board's clock, ms, modulo 2^16.
    pub time_ms: u16,
    /// The angle, rad, within ±8.
    pub angle_rad: f32,
    /// What the lengths leave at that angle, root mean square over the lengths to spare, mm, up to 8.
    pub residual_mm: f32,
}

mod angle {
    use super::{Field, Scale};
    pub(super) const TIME: Field = Field::integer(16, 16);
    pub(super) const ANGLE: Field = Field::scaled(32, Scale::signed(18, -14));
    pub(super) const RESIDUAL: Field = Field::scaled(50, Scale::unsigned(14, -11));
}

impl HingeAngle {
    /// The largest residual that the message can carry, mm; a larger one is sent as this.
    pub const MAX_RESIDUAL_MM: f32 = 7.99;

    pub(super) fn pack(&self) -> Result<Payload, PackError> {
        Payload::new()
            .with(RUN, self.run_id)
            .with(angle::TIME, self.time_ms)
            .with_value(angle::ANGLE, self.angle_rad)?
            .with_value(angle::RESIDUAL, self.residual_mm)
    }

    pub(super) fn unpack(payload: Payload) -> Self {
        Self {
            run_id: payload.get_u16(RUN),
            time_ms: payload.get_u16(angle::TIME),
            angle_rad: payload.get_value(angle::ANGLE),
            residual_mm: payload.get_value(angle::RESIDUAL),
        }
    }
}
