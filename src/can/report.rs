//! Messages about what was captured and how the run ended: poses, readings left out, the outcome, raw lengths.

use super::payload::{Field, PackError, Payload, RUN};
use super::rounding::Scale;
use crate::procedure::{Guidance, PoseSet, Reason};

/// What became of one pose that was captured or refused.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PoseReport {
    /// The run.
    pub run_id: u16,
    /// Index of the pose in its set, from 0. For a refused pose: the index that it would have had.
    pub index: u8,
    /// What the person at the arm should do now.
    pub guidance: Guidance,
    /// The set that the pose belongs to.
    pub set: PoseSet,
    /// [`Reason::Fine`] when the pose was taken, else why not.
    pub reason: Reason,
    /// Predicted σ of the centre with the poses so far, mm, up to 32; None while they do not fix it to that.
    pub sigma_mm: Option<f32>,
    /// Angle between this pose and the nearest one in the set, degrees; None for the first.
    pub distance_deg: Option<f32>,
}

mod pose {
    use super::{Field, Scale};
    pub(super) const INDEX: Field = Field::integer(16, 8);
    pub(super) const REASON: Field = Field::integer(24, 8);
    pub(super) const GUIDANCE: Field = Field::integer(32, 4);
    pub(super) const HELD_OUT: Field = Field::integer(36, 1);
    pub(super) const SIGMA_KNOWN: Field = Field::integer(37, 1);
    pub(super) const DISTANCE_KNOWN: Field = Field::integer(38, 1);
    pub(super) const SIGMA: Field = Field::scaled(40, Scale::unsigned(14, -9));
    pub(super) const DISTANCE: Field = Field::scaled(54, Scale::unsigned(10, -2));
}

impl PoseReport {
    /// The largest σ that the report can carry, mm.
    pub const SIGMA_LIMIT_MM: f32 = 31.9;

    pub(super) fn pack(&self) -> Result<Payload, PackError> {
        Payload::new()
            .with(RUN, self.run_id)
            .with(pose::INDEX, self.index)
            .with(pose::GUIDANCE, self.guidance.code())
            .with(pose::HELD_OUT, self.set == PoseSet::HeldOut)
            .with(pose::REASON, self.reason.code())
            .with_optional(pose::SIGMA_KNOWN, pose::SIGMA, self.sigma_mm)?
            .with_optional(pose::DISTANCE_KNOWN, pose::DISTANCE, self.distance_deg)
    }

    pub(super) fn unpack(payload: Payload) -> Option<Self> {
        Some(Self {
            run_id: payload.get_u16(RUN),
            index: payload.get_u8(pose::INDEX),
            guidance: Guidance::from_code(payload.get_u8(pose::GUIDANCE))?,
            set: PoseSet::held_out_if(payload.get_flag(pose::HELD_OUT)),
            reason: Reason::from_code(payload.get_u8(pose::REASON))?,
            sigma_mm: payload.get_optional(pose::SIGMA_KNOWN, pose::SIGMA),
            distance_deg: payload.get_optional(pose::DISTANCE_KNOWN, pose::DISTANCE),
        })
    }
}

/// A pose that was left out of the identification because it contradicts the others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LeftOut {
    /// The run.
    pub run_id: u16,
    /// Which of the poses left out this is, from 0.
    pub index: u8,
    /// How many there are.
    pub of: u8,
    /// Pose, from 0.
    pub pose: u8,
    /// The faulty cables: bit k for cable k + 1. None when no single cable explains the pose.
    pub cables: u8,
}

mod left_out {
    use super::Field;
    pub(super) const INDEX: Field = Field::integer(16, 8);
    pub(super) const OF: Field = Field::integer(24, 8);
    pub(super) const POSE: Field = Field::integer(32, 8);
    pub(super) const CABLES: Field = Field::integer(40, 6);
}

impl LeftOut {
    pub(super) fn pack(&self) -> Payload {
        Payload::new()
            .with(RUN, self.run_id)
            .with(left_out::INDEX, self.index)
            .with(left_out::OF, self.of)
            .with(left_out::POSE, self.pose)
            .with(left_out::CABLES, self.cables)
    }

    pub(super) fn unpack(payload: Payload) -> Self {
        Self {
            run_id: payload.get_u16(RUN),
            index: payload.get_u8(left_out::INDEX),
            of: payload.get_u8(left_out::OF),
            pose: payload.get_u8(left_out::POSE),
            cables: payload.get_u8(left_out::CABLES),
        }
    }
}

/// How the run ended. Complete by itself, and repeated until acknowledged.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct OutcomeReport {
    /// The run.
    pub run_id: u16,
    /// Accepted, rejected, aborted, or why it failed.
    pub reason: Reason,
    /// The pose meant by the reason, from 0.
    pub pose: Option<u8>,
    /// The cable meant by the reason, 1 to 6; 0 when none is meant.
    pub cable: u8,
    /// The centre in use is the one of this run.
    pub live: bool,
    /// Poses in the first set; they can be read out until the next run starts.
    pub poses: u8,
    /// What the reason is about, mm: migration of the centre, δE, σ; up to 64, None when it is about no length.
    pub size_mm: Option<f32>,
}

mod outcome {
    use super::{Field, Scale};
    pub(super) const REASON: Field = Field::integer(16, 8);
    pub(super) const POSE: Field = Field::integer(24, 8);
    pub(super) const CABLE: Field = Field::integer(32, 4);
    pub(super) const LIVE: Field = Field::integer(36, 1);
    pub(super) const POSE_KNOWN: Field = Field::integer(37, 1);
    pub(super) const SIZE_KNOWN: Field = Field::integer(38, 1);
    pub(super) const POSES: Field = Field::integer(40, 8);
    pub(super) const SIZE: Field = Field::scaled(48, Scale::unsigned(16, -10));
}

impl OutcomeReport {
    /// The largest size that the report can carry, mm.
    pub const SIZE_LIMIT_MM: f32 = 63.9;

    pub(super) fn pack(&self) -> Result<Payload, PackError> {
        Payload::new()
            .with(RUN, self.run_id)
            .with(outcome::REASON, self.reason.code())
            .with(outcome::POSE_KNOWN, self.pose.is_some())
            .with(outcome::POSE, self.pose.unwrap_or(0))
            .with(outcome::CABLE, self.cable)
            .with(outcome::LIVE, self.live)
            .with(outcome::POSES, self.poses)
            .with_optional(outcome::SIZE_KNOWN, outcome::SIZE, self.size_mm)
    }

    pub(super) fn unpack(payload: Payload) -> Option<Self> {
        Some(Self {
            run_id: payload.get_u16(RUN),
            reason: Reason::from_code(payload.get_u8(outcome::REASON))?,
            pose: payload.get_flag(outcome::POSE_KNOWN).then(|| payload.get_u8(outcome::POSE)),
            cable: payload.get_u8(outcome::CABLE),
            live: payload.get_flag(outcome::LIVE),
            poses: payload.get_u8(outcome::POSES),
            size_mm: payload.get_optional(outcome::SIZE_KNOWN, outcome::SIZE),
        })
    }
}

/// One cable length of one captured pose, for an identification elsewhere.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RawLength {
    /// The run.
    pub run_id: u16,
    /// Index of the pose in its set, from 0.
    pub index: u8,
    /// Cable, 1 to 6.
    pub cable: u8,
    /// The set.
    pub set: PoseSet,
    /// Length, mm, up to 4096; an `f32` of 16 mm or more comes through to the bit.
    pub length_mm: f32,
}

mod raw_length {
    use super::{Field, Scale};
    pub(super) const INDEX: Field = Field::integer(16, 8);
    pub(super) const CABLE: Field = Field::integer(24, 4);
    pub(super) const HELD_OUT: Field = Field::integer(28, 1);
    pub(super) const LENGTH: Field = Field::scaled(32, Scale::unsigned(32, -20));
}

impl RawLength {
    pub(super) fn pack(&self) -> Result<Payload, PackError> {
        Payload::new()
            .with(RUN, self.run_id)
            .with(raw_length::INDEX, self.index)
            .with(raw_length::CABLE, self.cable)
            .with(raw_length::HELD_OUT, self.set == PoseSet::HeldOut)
            .with_value(raw_length::LENGTH, self.length_mm)
    }

    pub(super) fn unpack(payload: Payload) -> Self {
        Self {
            run_id: payload.get_u16(RUN),
            index: payload.get_u8(raw_length::INDEX),
            cable: payload.get_u8(raw_length::CABLE),
            set: PoseSet::held_out_if(payload.get_flag(raw_length::HELD_OUT)),
            length_mm: payload.get_value(raw_length::LENGTH),
        }
    }
}

/// How many samples of the encoders a captured pose is the mean of: sent behind its lengths by a rig that knows the noise of a
/// sample apart from that of a length.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PoseSamples {
    /// The run.
    pub run_id: u16,
    /// Index of the pose in its set, from 0.
    pub index: u8,
    /// The set.
    pub set: PoseSet,
    /// Samples, 1 or more.
    pub samples: u16,
}

mod pose_samples {
    use super::Field;
    pub(super) const INDEX: Field = Field::integer(16, 8);
    pub(super) const HELD_OUT: Field = Field::integer(24, 1);
    pub(super) const SAMPLES: Field = Field::integer(32, 16);
}

impl PoseSamples {
    pub(super) fn pack(&self) -> Payload {
        Payload::new()
            .with(RUN, self.run_id)
            .with(pose_samples::INDEX, self.index)
            .with(pose_samples::HELD_OUT, self.set == PoseSet::HeldOut)
            .with(pose_samples::SAMPLES, self.samples)
    }

    pub(super) fn unpack(payload: Payload) -> Self {
        Self {
            run_id: payload.get_u16(RUN),
            index: payload.get_u8(pose_samples::INDEX),
            set: PoseSet::held_out_if(payload.get_flag(pose_samples::HELD_OUT)),
            samples: payload.get_u16(pose_samples::SAMPLES),
        }
    }
}
