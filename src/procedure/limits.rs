//! The limits that a run is held to, with their defaults and where those come from.

use super::encoders::EncoderLimits;
use super::plausible::Plausibility;
use super::slow_motion::SlowMotionLimits;
use super::stillness::StillnessLimits;
use crate::identification::gates::MIN_POSES;
use crate::rig::{CABLES, Drum, Rig};

/// Every number that can be set about a run.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Settings {
    /// Largest peak-to-peak movement of a cable while the arm counts as still, mm.
    pub still_band_mm: f32,
    /// How long the arm must be held still, ms.
    pub hold_ms: u32,
    /// Least number of samples of the counts in that time.
    pub min_samples: u16,
    /// Without a sample for this long the encoders are silent, ms.
    pub silence_ms: u32,
    /// Samples may reach the device this late, ms. A cable may seem to have moved for that much longer, but never for
    /// more than another mean period of the samples.
    pub sample_jitter_ms: u32,
    /// An encoder that rests while three other cables move this far is frozen, mm.
    pub frozen_mm: f32,
    /// So many samples at the new place after a jump, and the count is lost.
    pub lost_after_samples: u8,
    /// Smallest angle between two captured poses, rad.
    pub nearest_pose_rad: f32,
    /// Poses in the first set before it can be good enough.
    pub enough_poses: u8,
    /// The same when the encoder zeros are unknown and must be found from the same poses.
    pub enough_poses_with_zeros: u8,
    /// How well the encoder zeros are known at power-up, 1σ, mm; 0 = exactly. See
    /// [`Procedure::set_zero_prior`](super::Procedure::set_zero_prior).
    pub zero_prior_mm: f32,
    /// Predicted σ of the centre in its worst direction, with the zeros taken as known, at which the first set is good enough, mm.
    pub target_sigma_mm: f32,
    /// Poses in the second set.
    pub verification_poses: u8,
    /// Largest δE of the second set, mm.
    pub verification_deviation_mm: f32,
    /// Poses are captured while the arm moves slowly as well, in every run.
    pub capture_in_motion: bool,
    /// Solver runs in one run of the procedure before it gives up.
    pub max_attempts: u8,
    /// Longest time without a new pose while collecting, ms.
    pub collecting_timeout_ms: u32,
    /// Longest time without a new pose while verifying, ms.
    pub verifying_timeout_ms: u32,
    /// Longest time for the decision, ms. A candidate that outlives its wearer must not be accepted by the next.
    pub review_timeout_ms: u32,
    /// What a centre may be on the rig.
    pub plausibility: Plausibility,
}

impl Settings {
    /// The defaults for a rig.
    pub fn for_rig(rig: &Rig<f32>) -> Self {
        Self { plausibility: Plausibility::for_rig(rig), ..Self::default() }
    }
}

impl Default for Settings {
    /// The defaults for the shoulder.
    fn default() -> Self {
        Self {
            // Ten times the paper's noise, about twice the tremor of a supported arm; averaged over the window.
            still_band_mm: 1.0,
            hold_ms: 400,
            min_samples: 8,
            silence_ms: 500,
            sample_jitter_ms: 20,
            frozen_mm: 20.0,
            lost_after_samples: 5,
            nearest_pose_rad: 0.1,
            enough_poses: 12,
            // With ±10 mm of unknown zeros the centre is known to 0.4 mm then (`cargo study zeros`).
            enough_poses_with_zeros: 30,
            zero_prior_mm: 0.0,
            target_sigma_mm: 0.05,
            verification_poses: 5,
            // Between the paper's 0.07 mm for a sound joint and the 4 mm of a centre that moves by 2 mm.
            verification_deviation_mm: 0.5,
            capture_in_motion: false,
            max_attempts: 5,
            collecting_timeout_ms: 120_000,
            verifying_timeout_ms: 120_000,
            review_timeout_ms: 300_000,
            plausibility: Plausibility::SHOULDER,
        }
    }
}

/// Which setting cannot be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum LimitsError {
    /// A length or an angle is not positive and finite, or the prior of the zeros is negative.
    NotPositive = 1,
    /// Fewer than three poses never determine the centre.
    TooFewPoses = 2,
    /// Without a second set nothing is verified.
    NoVerification = 3,
    /// A count of attempts or samples is zero.
    ZeroCount = 4,
    /// A time is zero, or longer than half of the range of the clock (24 days).
    BadTime = 5,
    /// A limit of what a centre may be is not positive, or leaves room for none.
    BadPlausibility = 6,
}

impl core::fmt::Display for LimitsError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::NotPositive => "a length or an angle is not positive and finite",
            Self::TooFewPoses => "fewer than three poses never determine the centre",
            Self::NoVerification => "without a second set nothing is verified",
            Self::ZeroCount => "a count of attempts or samples is zero",
            Self::BadTime => "a time is zero or longer than 24 days",
            Self::BadPlausibility => "a limit of what a centre may be is not positive, or leaves room for none",
        })
    }
}

impl core::error::Error for LimitsError {}

/// Settings that have been checked, for one rig.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Limits {
    settings: Settings,
    mm_per_count: f32,
    noise_mm: f32,
}

/// The fastest cable of a motion that gives poses, mm/s: an arm that turns by 40 degrees a second, at the shoulder's nominal radius
/// of 141 mm.
const SLOW_MM_PER_S: f32 = 100.0;
/// By so much of the noise of a length may acceleration have put off the mean of a window. The noise of the window's thirds is half
/// of that.
const NOISES: f32 = 1.5;

impl Limits {
    /// Checked limits for a rig.
    ///
    /// # Errors
    /// [`LimitsError`] names the first kind of setting that cannot be.
    pub fn new(rig: &Rig<f32>, settings: Settings) -> Result<Self, LimitsError> {
        check(&settings)?;
        Ok(Self::unchecked(rig, settings))
    }

    /// The same for a module with this drum, the noise of whose lengths is `noise_mm`, 1σ.
    ///
    /// # Errors
    /// As for [`new`](Self::new).
    pub(super) fn of_module_with(drum: &Drum<f32>, noise_mm: f32, settings: Settings) -> Result<Self, LimitsError> {
        check(&settings)?;
        Ok(Self { settings, mm_per_count: drum.mm_per_count(), noise_mm })
    }

    /// The default limits for a rig.
    pub fn for_rig(rig: &Rig<f32>) -> Self {
        // The defaults pass the check; a test shows it.
        Self::unchecked(rig, Settings::for_rig(rig))
    }

    fn unchecked(rig: &Rig<f32>, settings: Settings) -> Self {
        Self { settings, mm_per_count: rig.drum().mm_per_count(), noise_mm: rig.length_noise_mm() }
    }

    /// The default limits of a module with this drum, the noise of whose lengths is `noise_mm`, 1σ.
    pub(super) fn of_module(drum: &Drum<f32>, noise_mm: f32) -> Self {
        Self { settings: Settings::default(), mm_per_count: drum.mm_per_count(), noise_mm }
    }

    /// The settings.
    pub const fn settings(&self) -> &Settings {
        &self.settings
    }

    /// What counts as still, in counts of the rig's drum.
    pub fn stillness(&self) -> StillnessLimits {
        StillnessLimits {
            band_counts: self.counts(self.settings.still_band_mm),
            hold_ms: self.settings.hold_ms,
            min_samples: self.settings.min_samples,
        }
    }

    /// Every number of them: the bits of a fraction, an integer as it is.
    pub(crate) fn words(&self) -> [u32; 26] {
        let Settings {
            still_band_mm,
            hold_ms,
            min_samples,
            silence_ms,
            sample_jitter_ms,
            frozen_mm,
            lost_after_samples,
            nearest_pose_rad,
            enough_poses,
            enough_poses_with_zeros,
            zero_prior_mm,
            target_sigma_mm,
            verification_poses,
            verification_deviation_mm,
            capture_in_motion,
            max_attempts,
            collecting_timeout_ms,
            verifying_timeout_ms,
            review_timeout_ms,
            plausibility: Plausibility { centre_mm, min_radius_mm, max_radius_mm, sigma_mm, offset_mm },
        } = self.settings;
        [
            still_band_mm.to_bits(),
            hold_ms,
            min_samples.into(),
            silence_ms,
            sample_jitter_ms,
            frozen_mm.to_bits(),
            lost_after_samples.into(),
            nearest_pose_rad.to_bits(),
            enough_poses.into(),
            enough_poses_with_zeros.into(),
            zero_prior_mm.to_bits(),
            target_sigma_mm.to_bits(),
            verification_poses.into(),
            verification_deviation_mm.to_bits(),
            capture_in_motion.into(),
            max_attempts.into(),
            collecting_timeout_ms,
            verifying_timeout_ms,
            review_timeout_ms,
            centre_mm.to_bits(),
            min_radius_mm.to_bits(),
            max_radius_mm.to_bits(),
            sigma_mm.to_bits(),
            offset_mm.to_bits(),
            self.mm_per_count.to_bits(),
            self.noise_mm.to_bits(),
        ]
    }

    /// What counts as slow motion, in counts of the rig's drum.
    pub fn slow_motion(&self) -> SlowMotionLimits {
        SlowMotionLimits {
            counts_per_s: SLOW_MM_PER_S / self.mm_per_count,
            error_counts: NOISES * self.noise_mm / self.mm_per_count,
        }
    }

    /// When an encoder is not believed, in counts of the rig's drum.
    pub fn encoders(&self) -> EncoderLimits {
        EncoderLimits {
            silence_ms: self.settings.silence_ms,
            jitter_ms: self.settings.sample_jitter_ms,
            frozen_counts: self.counts(self.settings.frozen_mm),
            lost_after_samples: self.settings.lost_after_samples,
            cables: CABLES as u8,
        }
    }

    /// A distance along a cable in counts, rounded up.
    fn counts(&self, distance_mm: f32) -> u32 {
        // the cast saturates
        libm::ceilf(distance_mm / self.mm_per_count) as u32
    }
}

/// Can the settings be?
fn check(s: &Settings) -> Result<(), LimitsError> {
    let sizes = [s.still_band_mm, s.frozen_mm, s.nearest_pose_rad, s.target_sigma_mm, s.verification_deviation_mm];
    let times = [s.hold_ms, s.silence_ms, s.collecting_timeout_ms, s.verifying_timeout_ms, s.review_timeout_ms];
    let prior_fits = s.zero_prior_mm >= 0.0 && s.zero_prior_mm.is_finite();
    if !(prior_fits && sizes.iter().all(|size| *size > 0.0 && size.is_finite())) {
        Err(LimitsError::NotPositive)
    } else if usize::from(s.enough_poses.min(s.enough_poses_with_zeros)) < MIN_POSES {
        Err(LimitsError::TooFewPoses)
    } else if s.verification_poses == 0 {
        Err(LimitsError::NoVerification)
    } else if s.min_samples == 0 || s.lost_after_samples == 0 || s.max_attempts == 0 {
        Err(LimitsError::ZeroCount)
    } else if !times.iter().all(|time| (1..=u32::MAX / 2).contains(time)) || s.sample_jitter_ms > u32::MAX / 2 {
        Err(LimitsError::BadTime)
    } else if !s.plausibility.is_sound() {
        Err(LimitsError::BadPlausibility)
    } else {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rig() -> Rig<f32> {
        Rig::shoulder(150.0).unwrap()
    }

    fn with(change: impl Fn(&mut Settings)) -> Result<Limits, LimitsError> {
        let mut settings = Settings::for_rig(&rig());
        change(&mut settings);
        Limits::new(&rig(), settings)
    }

    #[test]
    fn the_defaults_pass_the_check() {
        assert_eq!(with(|_| ()), Ok(Limits::for_rig(&rig())));
    }

    #[test]
    fn what_cannot_be_is_refused() {
        assert_eq!(with(|s| s.still_band_mm = 0.0), Err(LimitsError::NotPositive));
        assert_eq!(with(|s| s.target_sigma_mm = f32::NAN), Err(LimitsError::NotPositive));
        assert_eq!(with(|s| s.nearest_pose_rad = f32::INFINITY), Err(LimitsError::NotPositive));
        assert_eq!(with(|s| s.enough_poses = 2), Err(LimitsError::TooFewPoses));
        assert_eq!(with(|s| s.enough_poses_with_zeros = 2), Err(LimitsError::TooFewPoses));
        assert_eq!(with(|s| s.zero_prior_mm = -1.0), Err(LimitsError::NotPositive));
        assert_eq!(with(|s| s.zero_prior_mm = f32::NAN), Err(LimitsError::NotPositive));
        assert_eq!(with(|s| s.verification_poses = 0), Err(LimitsError::NoVerification));
        assert_eq!(with(|s| s.max_attempts = 0), Err(LimitsError::ZeroCount));
        assert_eq!(with(|s| s.min_samples = 0), Err(LimitsError::ZeroCount));
        assert_eq!(with(|s| s.review_timeout_ms = 0), Err(LimitsError::BadTime));
        assert_eq!(with(|s| s.hold_ms = 1 << 31), Err(LimitsError::BadTime));
        assert_eq!(with(|s| s.plausibility.sigma_mm = f32::NAN), Err(LimitsError::BadPlausibility));
        assert_eq!(with(|s| s.plausibility.min_radius_mm = 1e6), Err(LimitsError::BadPlausibility));
    }

    #[test]
    fn distances_become_counts_rounded_up() {
        // 2 pi 15 mm / 4096 = 0.0230 mm a count: 1 mm is 43.5 counts, 20 mm are 869.2
        let limits = Limits::for_rig(&rig());
        assert_eq!((limits.stillness().band_counts, limits.encoders().frozen_counts), (44, 870));
    }

    #[test]
    fn codes_never_change() {
        use LimitsError::*;
        let codes =
            [NotPositive, TooFewPoses, NoVerification, ZeroCount, BadTime, BadPlausibility].map(|error| error as u8);
        assert_eq!(codes, [1, 2, 3, 4, 5, 6]);
    }
}
