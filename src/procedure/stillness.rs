//! Is the arm held still, and is every cable at rest? Judged from the encoder counts alone.
//!
//! A window begins at some sample and grows as long as every cable stays within a band (peak to peak). Once it is old
//! enough the arm counts as still, and the mean of the window is the pose: averaging lowers the encoders' noise.
//! When a cable leaves the band, the window begins anew. Constant memory, constant work a sample.

use crate::rig::CABLES;

/// What counts as still.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct StillnessLimits {
    /// Largest peak-to-peak movement of a cable within the window, counts.
    pub band_counts: u32,
    /// How long the arm must have been in the band, ms.
    pub hold_ms: u32,
    /// Minimum number of samples that a verdict can rest on.
    pub min_samples: u16,
}

/// The counts of a held pose: their mean over the window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeldCounts {
    /// How many samples, 1 or more.
    pub samples: u16,
    /// The first sample.
    pub first: [i32; CABLES],
    /// By how much the mean lies above it, counts.
    pub above: [f32; CABLES],
}

/// The window over the latest counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stillness {
    limits: StillnessLimits,
    window: Option<Window>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Window {
    began_ms: u32,
    samples: u16,
    first: [i32; CABLES],
    low: [i32; CABLES],
    high: [i32; CABLES],
    /// Sums of the counts relative to the first sample.
    sums: [i64; CABLES],
}

impl Stillness {
    /// A monitor that has seen nothing yet.
    pub const fn new(limits: StillnessLimits) -> Self {
        Self { limits, window: None }
    }

    /// Forgets the window: the samples to come do not belong with those before.
    pub fn restart(&mut self) {
        self.window = None;
    }

    /// Takes in one sample.
    pub fn sample(&mut self, now_ms: u32, counts: &[i32; CABLES]) {
        let Some(window) = &mut self.window else {
            self.window = Some(Window::new(now_ms, counts));
            return;
        };
        window.add(counts);
        if window.is_out_of_band(self.limits.band_counts) {
            self.window = Some(Window::new(now_ms, counts));
        }
    }

    /// Has every cable been at rest for long enough?
    pub fn is_still(&self, now_ms: u32) -> bool {
        self.window.as_ref().is_some_and(|window| {
            now_ms.wrapping_sub(window.began_ms) >= self.limits.hold_ms && window.samples >= self.limits.min_samples
        })
    }

    /// Counts of the pose in which the arm rests. None when no sample has come yet.
    pub fn pose(&self) -> Option<HeldCounts> {
        let Window { samples, first, sums, .. } = self.window.as_ref()?;
        let count = f32::from(*samples);
        Some(HeldCounts { samples: *samples, first: *first, above: sums.map(|sum| sum as f32 / count) })
    }
}

impl Window {
    fn new(now_ms: u32, counts: &[i32; CABLES]) -> Self {
        Self { began_ms: now_ms, samples: 1, first: *counts, low: *counts, high: *counts, sums: [0; CABLES] }
    }

    fn add(&mut self, counts: &[i32; CABLES]) {
        // A window that is full keeps watching the band but no longer changes its mean.
        let counted = self.samples < u16::MAX;
        if counted {
            self.samples += 1;
        }
        let columns = self.low.iter_mut().zip(&mut self.high).zip(&mut self.sums).zip(self.first.iter().zip(counts));
        for (((low, high), sum), (first, count)) in columns {
            *low = (*low).min(*count);
            *high = (*high).max(*count);
            if counted {
                *sum += i64::from(*count) - i64::from(*first);
            }
        }
    }

    fn is_out_of_band(&self, band_counts: u32) -> bool {
        self.high.iter().zip(&self.low).any(|(high, low)| high.abs_diff(*low) > band_counts)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: StillnessLimits = StillnessLimits { band_counts: 10, hold_ms: 100, min_samples: 5 };

    #[test]
    fn still_after_the_hold_time_and_no_earlier() {
        let mut stillness = Stillness::new(LIMITS);
        let began_ms = u32::MAX - 50;
        for step in 0..30 {
            let now_ms = began_ms.wrapping_add(step * 10);
            stillness.sample(now_ms, &[7; 6]);
            assert_eq!(stillness.is_still(now_ms), step >= 10, "{step}");
        }
    }

    #[test]
    fn a_few_samples_prove_nothing_however_long_they_take() {
        let mut stillness = Stillness::new(LIMITS);
        for step in 0..4 {
            stillness.sample(step * 1_000, &[0; 6]);
        }
        assert!(!stillness.is_still(3_000));
    }

    #[test]
    fn a_slow_drift_is_movement() {
        let mut stillness = Stillness::new(LIMITS);
        // 2 counts every 10 ms: leaves the band of 10 within the hold time
        for step in 0..500 {
            stillness.sample(step * 10, &[0, 0, 2 * step as i32, 0, 0, 0]);
            assert!(!stillness.is_still(step * 10));
        }
    }

    #[test]
    fn the_pose_is_the_mean_of_the_window() {
        let mut stillness = Stillness::new(LIMITS);
        for (step, dither) in [0, 1, 1, 0, 3].into_iter().enumerate() {
            stillness.sample(step as u32 * 10, &[i32::MAX - 3 + dither, -dither, 0, 0, 0, 0]);
        }
        let HeldCounts { samples, first, above } = stillness.pose().unwrap();
        assert_eq!(samples, 5);
        assert_eq!(first, [i32::MAX - 3, 0, 0, 0, 0, 0]);
        assert_eq!(above, [1.0, -1.0, 0.0, 0.0, 0.0, 0.0]);
    }
}
