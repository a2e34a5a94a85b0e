//! From a set of values to a machine, and back.

use super::config::Config;
use super::set::ParameterSet;
use super::table::Key;
use crate::can::BaseId;
use crate::procedure::{Limits, LimitsError, ModuleRig, Plausibility, Settings};
use crate::restart::Restart;
use crate::rig::{CableEnds, Correction, Drum, Parameters, Pulley, Rig, RigError, Tolerance};
use nalgebra::Vector3;

use Key::*;

const BASE: [[Key; 3]; 3] = [[Base1X, Base1Y, Base1Z], [Base2X, Base2Y, Base2Z], [Base3X, Base3Y, Base3Z]];
const EDGES: [Key; 3] = [Edge12, Edge23, Edge31];
pub(super) const HOMES: [Key; 6] = [Home1, Home2, Home3, Home4, Home5, Home6];
const NOMINAL: [Key; 6] = [NominalX, NominalY, NominalZ, NominalRadius1, NominalRadius2, NominalRadius3];
pub(super) const OFFSETS: [Key; 6] = [Offset1, Offset2, Offset3, Offset4, Offset5, Offset6];
pub(super) const SCALES: [Key; 6] = [Scale1, Scale2, Scale3, Scale4, Scale5, Scale6];
/// Of each cable: base, end, radius and axis of the pulley.
const CABLES: [[Key; 10]; 6] = [
    [
        Cable1BaseX,
        Cable1BaseY,
        Cable1BaseZ,
        Cable1EndX,
        Cable1EndY,
        Cable1EndZ,
        Cable1PulleyRadius,
        Cable1PulleyAxisX,
        Cable1PulleyAxisY,
        Cable1PulleyAxisZ,
    ],
    [
        Cable2BaseX,
        Cable2BaseY,
        Cable2BaseZ,
        Cable2EndX,
        Cable2EndY,
        Cable2EndZ,
        Cable2PulleyRadius,
        Cable2PulleyAxisX,
        Cable2PulleyAxisY,
        Cable2PulleyAxisZ,
    ],
    [
        Cable3BaseX,
        Cable3BaseY,
        Cable3BaseZ,
        Cable3EndX,
        Cable3EndY,
        Cable3EndZ,
        Cable3PulleyRadius,
        Cable3PulleyAxisX,
        Cable3PulleyAxisY,
        Cable3PulleyAxisZ,
    ],
    [
        Cable4BaseX,
        Cable4BaseY,
        Cable4BaseZ,
        Cable4EndX,
        Cable4EndY,
        Cable4EndZ,
        Cable4PulleyRadius,
        Cable4PulleyAxisX,
        Cable4PulleyAxisY,
        Cable4PulleyAxisZ,
    ],
    [
        Cable5BaseX,
        Cable5BaseY,
        Cable5BaseZ,
        Cable5EndX,
        Cable5EndY,
        Cable5EndZ,
        Cable5PulleyRadius,
        Cable5PulleyAxisX,
        Cable5PulleyAxisY,
        Cable5PulleyAxisZ,
    ],
    [
        Cable6BaseX,
        Cable6BaseY,
        Cable6BaseZ,
        Cable6EndX,
        Cable6EndY,
        Cable6EndZ,
        Cable6PulleyRadius,
        Cable6PulleyAxisX,
        Cable6PulleyAxisY,
        Cable6PulleyAxisZ,
    ],
];
/// The geometry of an elbow.
pub(super) const ELBOW: u32 = 2;
/// The four words of the key of the lock.
pub const LOCK_KEYS: [Key; 4] = [LockKey1, LockKey2, LockKey3, LockKey4];

/// Values that do not fit each other, and one of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Contradiction {
    /// Index of a parameter that is part of it.
    pub index: u16,
}

impl Contradiction {
    pub(super) fn about(key: Key) -> Self {
        Self { index: super::TABLE.get(key as usize).map_or(0, |entry| entry.index) }
    }

    pub(super) fn of_rig(error: RigError) -> Self {
        Self::about(match error {
            RigError::BaseCollapsed | RigError::BaseOnEdge | RigError::NotFinite => Base1X,
            RigError::EndsCoincide => Cable1EndX,
            RigError::DrawingMissing => HingeDrawing,
            RigError::PulleyImpossible => Cable1PulleyRadius,
            RigError::ToleranceImpossible => ToleranceBase,
            RigError::CorrectionImpossible => Offset1,
            RigError::PlatformCollapsed => Edge12,
            RigError::DrumNotPositive => DrumRadius,
            RigError::NoiseNotPositive => LengthNoise,
            RigError::RadiusNotPositive => NominalRadius1,
        })
    }

    fn of_limits(error: LimitsError) -> Self {
        Self::about(match error {
            LimitsError::NotPositive => StillBand,
            LimitsError::TooFewPoses => EnoughPoses,
            LimitsError::NoVerification => VerificationPoses,
            LimitsError::ZeroCount => MinSamples,
            LimitsError::BadTime => HoldTime,
            LimitsError::BadPlausibility => PlausibleMinRadius,
        })
    }
}

impl ParameterSet {
    /// What a device with these values is made for.
    ///
    /// # Errors
    /// [`Contradiction`] when they do not fit each other.
    pub fn config(&self, restart: Restart, serial: u32) -> Result<Config, Contradiction> {
        let rig = if self.integer(Geometry) == ELBOW {
            self.require_nothing_of_a_ball()?;
            ModuleRig::Hinge(self.elbow().map_err(Contradiction::of_elbow)?)
        } else {
            ModuleRig::Ball(self.rig().map_err(Contradiction::of_rig)?)
        };
        let limits = rig.limits(self.settings()).map_err(Contradiction::of_limits)?;
        // within 16 bits by its range
        let base = BaseId::new(self.integer(Key::BaseId) as u16).ok_or(Contradiction::about(Key::BaseId))?;
        Ok(Config {
            rig,
            limits,
            base,
            restart,
            serial,
            telemetry_hz: self.integer(TelemetryRate) as u16,
            live_period_ms: self.integer(LivePeriod) as u16,
            numbering_check: self.integer(NumberingCheck) != 0,
            lock_key: LOCK_KEYS.map(|key| self.integer(key)),
            parameters: *self,
        })
    }

    /// The values of a module that was made by other means.
    pub fn of_module(rig: &ModuleRig, limits: &Limits) -> Self {
        match rig {
            ModuleRig::Ball(rig) => Self::of(rig, limits),
            ModuleRig::Hinge(rig) => Self::of_elbow(rig, limits),
        }
    }

    /// The values of a machine about a ball that was made by other means.
    pub fn of(rig: &Rig<f32>, limits: &Limits) -> Self {
        let mut set = Self::new();
        set.put_rig(rig);
        set.put_settings(limits.settings());
        set
    }

    fn rig(&self) -> Result<Rig<f32>, RigError> {
        let base_mm = BASE.map(|point| Vector3::from(point.map(|key| self.single(key))));
        let drum = self.drum();
        let nominal = Parameters::from_array(NOMINAL.map(|key| self.single(key)));
        let noise_mm = self.single(LengthNoise);
        let rig = if self.integer(Geometry) == 0 {
            Rig::new(base_mm, EDGES.map(|key| self.single(key)), drum, noise_mm, nominal)
        } else {
            Rig::with_cables(self.cables(), drum, noise_mm, nominal)
        }?;
        let rig = rig.with_noise(noise_mm, self.single(SampleNoise))?.with_tolerance(self.tolerance())?;
        let found =
            Correction { offset_mm: OFFSETS.map(|key| self.single(key)), scale: SCALES.map(|key| self.single(key)) };
        let is_none = Correction { offset_mm: [0.0; 6], scale: [1.0; 6] } == found;
        if is_none { Ok(rig) } else { rig.with_correction(found) }
    }

    pub(super) fn drum(&self) -> Drum<f32> {
        Drum {
            radius_mm: self.single(DrumRadius),
            counts_per_turn: self.single(CountsPerTurn),
            home_length_mm: HOMES.map(|key| self.single(key)),
            fastest_mm_per_s: self.single(MaxSpeed),
        }
    }

    pub(super) fn tolerance(&self) -> Tolerance<f32> {
        Tolerance {
            base_mm: self.single(ToleranceBase),
            edges_mm: self.single(ToleranceEdges),
            offset_mm: self.single(ToleranceOffset),
            drum: self.single(ToleranceDrum),
        }
    }

    /// The ends of all cables.
    pub(super) fn cables(&self) -> [CableEnds<f32>; 6] {
        CABLES.map(|cable| self.cable(cable))
    }

    fn cable(&self, keys: [Key; 10]) -> CableEnds<f32> {
        let [b1, b2, b3, e1, e2, e3, radius_mm, a1, a2, a3] = keys.map(|key| self.single(key));
        let pulley = Pulley { radius_mm, axis: Vector3::new(a1, a2, a3) };
        CableEnds { base_mm: Vector3::new(b1, b2, b3), end_mm: Vector3::new(e1, e2, e3), pulley }
    }

    fn put_rig(&mut self, rig: &Rig<f32>) {
        let drum = rig.drum();
        let base = rig.base_mm().iter().flat_map(|point| point.iter());
        let geometry = BASE.iter().flatten().zip(base).chain(EDGES.iter().zip(rig.edges_mm()));
        let nominal = rig.nominal().to_array();
        for (key, value) in geometry.chain(NOMINAL.iter().zip(&nominal)) {
            self.put_single(*key, *value);
        }
        self.put_integer(Geometry, rig.cables().is_some().into());
        rig.cables().into_iter().for_each(|cables| self.put_cables(cables));
        self.put_tolerance(rig.tolerance());
        if let Some(Correction { offset_mm, scale }) = rig.correction() {
            for (key, value) in OFFSETS.iter().chain(&SCALES).zip(offset_mm.iter().chain(scale)) {
                self.put_single(*key, *value);
            }
        }
        self.put_drum(drum);
        self.put_single(LengthNoise, rig.length_noise_mm());
        self.put_single(SampleNoise, rig.sample_noise_mm());
    }

    pub(super) fn put_cables(&mut self, cables: &[CableEnds<f32>]) {
        for (keys, CableEnds { base_mm, end_mm, pulley }) in CABLES.iter().zip(cables) {
            let values = base_mm.iter().chain(end_mm.iter()).chain([&pulley.radius_mm]).chain(pulley.axis.iter());
            keys.iter().zip(values).for_each(|(key, value)| self.put_single(*key, *value));
        }
    }

    pub(super) fn put_tolerance(&mut self, tolerance: &Tolerance<f32>) {
        let Tolerance { base_mm, edges_mm, offset_mm, drum } = *tolerance;
        let tolerances = [ToleranceBase, ToleranceEdges, ToleranceOffset, ToleranceDrum];
        for (key, value) in tolerances.into_iter().zip([base_mm, edges_mm, offset_mm, drum]) {
            self.put_single(key, value);
        }
    }

    pub(super) fn put_drum(&mut self, drum: &Drum<f32>) {
        HOMES.iter().zip(&drum.home_length_mm).for_each(|(key, value)| self.put_single(*key, *value));
        self.put_single(DrumRadius, drum.radius_mm);
        self.put_single(CountsPerTurn, drum.counts_per_turn);
        self.put_single(MaxSpeed, drum.fastest_mm_per_s);
    }

    /// The settings of a run. Each integer fits its type by its range.
    fn settings(&self) -> Settings {
        Settings {
            still_band_mm: self.single(StillBand),
            hold_ms: self.integer(HoldTime),
            min_samples: self.integer(MinSamples) as u16,
            silence_ms: self.integer(SilenceTime),
            sample_jitter_ms: self.integer(SampleJitter),
            frozen_mm: self.single(FrozenDistance),
            lost_after_samples: self.integer(LostAfterSamples) as u8,
            nearest_pose_rad: self.single(NearestPose),
            enough_poses: self.integer(EnoughPoses) as u8,
            enough_poses_with_zeros: self.integer(EnoughPosesOffsets) as u8,
            zero_prior_mm: self.single(OffsetPrior),
            target_sigma_mm: self.single(TargetSigma),
            verification_poses: self.integer(VerificationPoses) as u8,
            verification_deviation_mm: self.single(VerificationLimit),
            capture_in_motion: self.integer(CaptureInMotion) != 0,
            max_attempts: self.integer(MaxAttempts) as u8,
            collecting_timeout_ms: self.integer(CollectingTimeout),
            verifying_timeout_ms: self.integer(VerifyingTimeout),
            review_timeout_ms: self.integer(ReviewTimeout),
            plausibility: Plausibility {
                centre_mm: self.single(PlausibleCentre),
                min_radius_mm: self.single(PlausibleMinRadius),
                max_radius_mm: self.single(PlausibleMaxRadius),
                sigma_mm: self.single(PlausibleSigma),
                offset_mm: self.single(PlausibleOffset),
            },
        }
    }

    pub(super) fn put_settings(&mut self, settings: &Settings) {
        let Plausibility { centre_mm, min_radius_mm, max_radius_mm, sigma_mm, offset_mm } = settings.plausibility;
        for (key, value) in [
            (StillBand, settings.still_band_mm),
            (FrozenDistance, settings.frozen_mm),
            (NearestPose, settings.nearest_pose_rad),
            (OffsetPrior, settings.zero_prior_mm),
            (TargetSigma, settings.target_sigma_mm),
            (VerificationLimit, settings.verification_deviation_mm),
            (PlausibleCentre, centre_mm),
            (PlausibleMinRadius, min_radius_mm),
            (PlausibleMaxRadius, max_radius_mm),
            (PlausibleSigma, sigma_mm),
            (PlausibleOffset, offset_mm),
        ] {
            self.put_single(key, value);
        }
        for (key, value) in [
            (HoldTime, settings.hold_ms),
            (MinSamples, settings.min_samples.into()),
            (SilenceTime, settings.silence_ms),
            (SampleJitter, settings.sample_jitter_ms),
            (LostAfterSamples, settings.lost_after_samples.into()),
            (EnoughPoses, settings.enough_poses.into()),
            (EnoughPosesOffsets, settings.enough_poses_with_zeros.into()),
            (VerificationPoses, settings.verification_poses.into()),
            (CaptureInMotion, settings.capture_in_motion.into()),
            (MaxAttempts, settings.max_attempts.into()),
            (CollectingTimeout, settings.collecting_timeout_ms),
            (VerifyingTimeout, settings.verifying_timeout_ms),
            (ReviewTimeout, settings.review_timeout_ms),
        ] {
            self.put_integer(key, value);
        }
    }
}
