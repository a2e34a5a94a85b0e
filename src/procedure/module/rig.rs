//! The machine of a module, whichever joint it is about.

use crate::procedure::elbow::ElbowRig;
use crate::procedure::limits::{Limits, LimitsError, Settings};
use crate::rig::{CABLES, Drum, Rig};

/// The machine of a module: its rig's data say which joint it is about.
// There is one of it, and no heap to box the larger one on.
#[allow(clippy::large_enum_variant)]
#[derive(Debug, Clone, PartialEq)]
pub enum ModuleRig {
    /// Six cables about a ball: a shoulder or a wrist.
    Ball(Rig<f32>),
    /// Two to four cables about a hinge: an elbow.
    Hinge(ElbowRig),
}

impl From<Rig<f32>> for ModuleRig {
    fn from(rig: Rig<f32>) -> Self {
        Self::Ball(rig)
    }
}

impl From<ElbowRig> for ModuleRig {
    fn from(rig: ElbowRig) -> Self {
        Self::Hinge(rig)
    }
}

impl ModuleRig {
    /// The rig, if the joint is a ball.
    pub const fn ball(&self) -> Option<&Rig<f32>> {
        match self {
            Self::Ball(rig) => Some(rig),
            Self::Hinge(_) => None,
        }
    }

    /// The rig, if the joint is a hinge.
    pub const fn hinge(&self) -> Option<&ElbowRig> {
        match self {
            Self::Ball(_) => None,
            Self::Hinge(rig) => Some(rig),
        }
    }

    /// Checked limits for the module.
    ///
    /// # Errors
    /// [`LimitsError`] names the first kind of setting that cannot be.
    pub fn limits(&self, settings: Settings) -> Result<Limits, LimitsError> {
        Limits::of_module_with(self.drum(), self.length_noise_mm(), settings)
    }

    /// The default limits for the module.
    pub fn default_limits(&self) -> Limits {
        match self {
            Self::Ball(rig) => Limits::for_rig(rig),
            Self::Hinge(rig) => Limits::of_module(rig.drum(), rig.hinge().length_noise_mm()),
        }
    }

    /// The drive: counts to lengths.
    pub fn drum(&self) -> &Drum<f32> {
        match self {
            Self::Ball(rig) => rig.drum(),
            Self::Hinge(rig) => rig.drum(),
        }
    }

    /// Cables, which are also the encoders in use, from the first on.
    pub fn cables(&self) -> u8 {
        match self {
            Self::Ball(_) => CABLES as u8,
            Self::Hinge(rig) => rig.cables(),
        }
    }

    /// Standard deviation of one length, mm: of what does not average over the samples of a held pose.
    pub fn length_noise_mm(&self) -> f32 {
        match self {
            Self::Ball(rig) => rig.length_noise_mm(),
            Self::Hinge(rig) => rig.hinge().length_noise_mm(),
        }
    }
}
