//! What the encoders say about the arm: whether they can be trusted, whether it is still, and where it is.

use super::encoders::{EncoderFault, EncoderLimits, Encoders};
use super::limits::Limits;
use super::loose::LooseWatch;
use super::reason::Reason;
use super::slow_motion::SlowMotion;
use super::stillness::{HeldCounts, Stillness};
use crate::kinematics::CableLengths;
use crate::rig::{CABLES, Drum, Rig};

/// Why the arm is not in a pose that can be captured, and which cable is at fault (0: none).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NotReady {
    /// The reason.
    pub reason: Reason,
    /// Cable 1 to 6, 0 when none is meant.
    pub cable: u8,
}

impl From<EncoderFault> for NotReady {
    fn from(fault: EncoderFault) -> Self {
        Self { reason: fault.reason, cable: fault.cable }
    }
}

/// The watch over the arm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arm {
    encoders: Encoders,
    stillness: Stillness,
    loose: LooseWatch,
    slow_motion: SlowMotion,
}

impl Arm {
    /// A watch that has seen nothing yet.
    pub fn new(limits: &Limits, encoders: EncoderLimits) -> Self {
        let stillness = limits.stillness();
        Self {
            encoders: Encoders::new(encoders),
            stillness: Stillness::new(stillness),
            loose: LooseWatch::new(stillness.band_counts),
            slow_motion: SlowMotion::new(limits.slow_motion()),
        }
    }

    /// Takes in one sample of the six counts.
    pub fn sample(&mut self, now_ms: u32, counts: &[i32; CABLES], drum: &Drum<f32>) {
        if !self.encoders.sample(now_ms, counts, drum) {
            self.stillness.restart();
            self.slow_motion.restart();
            return;
        }
        self.stillness.sample(now_ms, counts);
        self.slow_motion.sample(now_ms, counts);
        self.loose.sample(counts);
        if self.stillness.is_still(now_ms) {
            self.loose.restart();
        }
    }

    /// Time passes.
    pub fn tick(&mut self, now_ms: u32) {
        self.encoders.tick(now_ms);
    }

    /// What is wrong with the encoders now.
    pub fn fault(&self, now_ms: u32) -> Option<EncoderFault> {
        self.encoders.fault(now_ms)
    }

    /// The cable whose count is lost for good.
    pub const fn lost(&self) -> Option<u8> {
        self.encoders.lost()
    }

    /// A new run begins: a count lost in an earlier one is no longer held against the encoder.
    pub fn forgive(&mut self) {
        self.encoders.forgive();
    }

    /// Is the arm held still, with believable encoders and every cable at rest?
    ///
    /// # Errors
    /// What is in the way.
    pub fn ready(&self, now_ms: u32) -> Result<(), NotReady> {
        if let Some(fault) = self.fault(now_ms) {
            return Err(fault.into());
        }
        if self.stillness.is_still(now_ms) {
            Ok(())
        } else if let Some(cable) = self.loose.cable() {
            Err(NotReady { reason: Reason::CableLoose, cable })
        } else {
            Err(NotReady { reason: Reason::ArmMoving, cable: 0 })
        }
    }

    /// The mean counts of the pose in which the arm is held.
    ///
    /// # Errors
    /// As for [`ready`](Self::ready).
    pub fn held(&self, now_ms: u32) -> Result<HeldCounts, NotReady> {
        self.ready(now_ms)?;
        self.stillness.pose().ok_or(NotReady { reason: Reason::ArmMoving, cable: 0 })
    }

    /// The lengths of the pose in which the arm is held, from the mean of the counts while it was still, corrected by what
    /// commissioning found; and how many samples they are the mean of.
    ///
    /// # Errors
    /// As for [`ready`](Self::ready), and [`Reason::LengthImpossible`].
    pub fn pose(&self, now_ms: u32, rig: &Rig<f32>) -> Result<(CableLengths<f32>, u16), NotReady> {
        let held = self.held(now_ms)?;
        let impossible = |cable| NotReady { reason: Reason::LengthImpossible, cable };
        let lengths = CableLengths::from_mean_counts(rig, &held.first, &held.above);
        lengths.map(|lengths| (lengths, held.samples)).map_err(|error| impossible(error.cable))
    }

    /// The same of the pose through which the arm has just moved slowly, once; `None` when there is none that can be believed.
    pub fn pose_in_motion(&mut self, now_ms: u32, rig: &Rig<f32>) -> Option<(CableLengths<f32>, u16)> {
        let passed = self.slow_motion.take()?;
        if self.fault(now_ms).is_some() || self.loose.cable().is_some() {
            return None;
        }
        let lengths = CableLengths::from_mean_counts(rig, &passed.first, &passed.above).ok()?;
        Some((lengths, passed.samples))
    }
}
