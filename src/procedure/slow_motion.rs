//! Poses while the arm moves: slow motion gives a pose in each short window of samples. Judged from the encoder counts
//! alone.
//!
//! All six counts of a sample are of one instant, and the mean of a window is the pose at its middle, but for what the
//! cables' speeds change within it: with the acceleration L̈ over the window's time T the mean is too large by L̈ T² / 24. Both
//! that and the speed are measured, from the means of the window's three thirds. A window in which that error could exceed
//! one and a half times the noise that the rig states of one length gives no pose. That the standard deviation of the result covers
//! what is left, `cargo study free-motion` shows.

use super::stillness::HeldCounts;
use crate::rig::CABLES;

/// How long a window lasts, ms.
const WINDOW_MS: u32 = 90;
/// Minimum number of samples in each of its thirds.
const MIN_SAMPLES: u16 = 2;
/// Share of the second difference of the thirds' means by which the whole mean is off: (T² / 24) / (T / 3)².
const SHARE_OF_CURVATURE: f32 = 0.375;

/// What counts as slow.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SlowMotionLimits {
    /// Fastest cable, counts a second.
    pub counts_per_s: f32,
    /// Largest error of a mean by acceleration, counts.
    pub error_counts: f32,
}

/// The samples of one third of a window.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Third {
    samples: u16,
    /// Sums of the counts relative to the window's first sample.
    sums: [i32; CABLES],
}

/// The window under way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Window {
    began_ms: u32,
    first: [i32; CABLES],
    thirds: [Third; 3],
}

/// The watch for slow motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlowMotion {
    limits: SlowMotionLimits,
    window: Option<Window>,
    /// Of the last whole window, until it is taken.
    pose: Option<HeldCounts>,
}

impl SlowMotion {
    /// A watch that has seen nothing yet.
    pub const fn new(limits: SlowMotionLimits) -> Self {
        Self { limits, window: None, pose: None }
    }

    /// Forgets the window: the samples to come do not belong with those before.
    pub fn restart(&mut self) {
        (self.window, self.pose) = (None, None);
    }

    /// Takes in one sample.
    pub fn sample(&mut self, now_ms: u32, counts: &[i32; CABLES]) {
        let elapsed_ms = self.window.map_or(WINDOW_MS, |window| now_ms.wrapping_sub(window.began_ms));
        if elapsed_ms >= WINDOW_MS {
            self.pose = self.window.and_then(|window| window.pose(&self.limits));
            self.window = Some(Window { began_ms: now_ms, first: *counts, thirds: [Third::default(); 3] });
        }
        let Some(window) = &mut self.window else { return };
        let elapsed_ms = now_ms.wrapping_sub(window.began_ms);
        if let Some(third) = window.thirds.get_mut((elapsed_ms * 3 / WINDOW_MS) as usize) {
            third.samples = third.samples.saturating_add(1);
            for ((sum, first), count) in third.sums.iter_mut().zip(&window.first).zip(counts) {
                *sum = sum.saturating_add(count.wrapping_sub(*first));
            }
        }
    }

    /// The pose of the last whole window, once; `None` when there is none, or the arm was too fast.
    pub fn take(&mut self) -> Option<HeldCounts> {
        self.pose.take()
    }
}

impl Window {
    /// The pose of a whole window, if it was slow and steady enough.
    fn pose(&self, limits: &SlowMotionLimits) -> Option<HeldCounts> {
        let means = self.thirds.each_ref().map(Third::means);
        let [Some(early), Some(middle), Some(late)] = means else { return None };
        let mut mean = [0.0; CABLES];
        for (k, mean) in mean.iter_mut().enumerate() {
            let (a, b, c) = (*early.get(k)?, *middle.get(k)?, *late.get(k)?);
            let seconds = WINDOW_MS as f32 * (2.0 / 3000.0);
            let is_slow = (c - a).abs() <= limits.counts_per_s * seconds;
            let is_steady = (a - 2.0 * b + c).abs() * SHARE_OF_CURVATURE <= limits.error_counts;
            if !(is_slow && is_steady) {
                return None;
            }
            *mean = (a + b + c) / 3.0;
        }
        let samples = self.thirds.iter().fold(0, |sum: u16, third| sum.saturating_add(third.samples));
        Some(HeldCounts { samples, first: self.first, above: mean })
    }
}

impl Third {
    fn means(&self) -> Option<[f32; CABLES]> {
        let samples = f32::from(self.samples);
        (self.samples >= MIN_SAMPLES).then(|| self.sums.map(|sum| sum as f32 / samples))
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;

    const LIMITS: SlowMotionLimits = SlowMotionLimits { counts_per_s: 4_000.0, error_counts: 2.5 };

    /// Counts of a cable that moves at a speed and an acceleration, counts/s and counts/s², the others at rest.
    fn poses(period_ms: u32, speed: f64, acceleration: f64) -> std::vec::Vec<(u32, HeldCounts)> {
        let mut slow = SlowMotion::new(LIMITS);
        let mut found = std::vec::Vec::new();
        for step in 0..200 {
            let now_ms = step * period_ms;
            let t = f64::from(now_ms) / 1000.0;
            let moved = libm::round(1e6 + speed * t + acceleration * t * t / 2.0) as i32;
            slow.sample((u32::MAX - 100).wrapping_add(now_ms), &[5, moved, 5, 5, 5, 5]);
            if let Some(pose) = slow.take() {
                found.push((now_ms, pose));
            }
        }
        found
    }

    #[test]
    fn the_pose_is_that_of_the_windows_middle() {
        for (period_ms, speed) in [(10, 3_000.0), (1, -3_000.0), (5, 0.0)] {
            let found = poses(period_ms, speed, 0.0);
            assert!(found.len() >= 2, "{period_ms}");
            for (now_ms, HeldCounts { samples, first, above: mean }) in found {
                // The samples of a window lie from 90 ms to one period before the sample that ends it.
                let middle_s = (f64::from(now_ms) - (90.0 + f64::from(period_ms)) / 2.0) / 1000.0;
                let expected = 1e6 + speed * middle_s;
                let pose = f64::from(first[1]) + f64::from(mean[1]);
                assert!((pose - expected).abs() < 1.0, "{period_ms}: {pose} instead of {expected}");
                assert_eq!((first[0], mean[0], u32::from(samples)), (5, 0.0, 90_u32.div_ceil(period_ms)));
            }
        }
    }

    #[test]
    fn a_fast_arm_gives_no_pose() {
        assert!(!poses(10, 3_900.0, 0.0).is_empty());
        assert!(poses(10, 4_100.0, 0.0).is_empty());
    }

    /// L̈ T² / 24 with T = 90 ms: 2.5 counts at 7 407 counts/s².
    #[test]
    fn an_arm_that_changes_its_speed_gives_no_pose() {
        assert!(poses(1, -3_000.0, 6_500.0).len() > 1);
        assert!(poses(1, 0.0, 8_500.0).is_empty());
    }

    #[test]
    fn two_samples_in_a_third_are_the_least() {
        assert!(poses(40, 0.0, 0.0).is_empty());
        assert!(!poses(15, 0.0, 0.0).is_empty());
    }
}
