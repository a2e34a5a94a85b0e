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
    /// Fewest samples that a verdict can rest on.
    pub fewest_samples: u16,
}

/// What the window says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Verdict {
    /// The arm moves, or has not been at rest for long enough.
    Moving,
    /// This cable (1 to 6) moves although at least four others rest: it is not taut, or its encoder is noisy.
    Loose(u8),
    /// Every cable has been at rest for long enough.
    Still,
}

/// The window over the latest counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stillness {
    limits: StillnessLimits,
    window: Option<Window>,
    loose: Option<u8>,
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
        Self { limits, window: None, loose: None }
    }

    /// Forgets the window: the samples to come do not belong with those before.
    pub fn restart(&mut self) {
        self.window = None;
        self.loose = None;
    }

    /// Takes in one sample.
    pub fn sample(&mut self, now_ms: u32, counts: &[i32; CABLES]) {
        let Some(window) = &mut self.window else {
            self.window = Some(Window::new(now_ms, counts));
            return;
        };
        window.add(counts);
        let Some(widest) = window.out_of_band(self.limits.band_counts) else {
            if now_ms.wrapping_sub(window.began_ms) >= self.limits.hold_ms {
                self.loose = None;
            }
            return;
        };
        self.loose = window.loose(widest, self.limits.band_counts);
        self.window = Some(Window::new(now_ms, counts));
    }

    /// The verdict at this moment.
    pub fn verdict(&self, now_ms: u32) -> Verdict {
        if let Some(cable) = self.loose {
            return Verdict::Loose(cable);
        }
        match &self.window {
            Some(window)
                if now_ms.wrapping_sub(window.began_ms) >= self.limits.hold_ms
                    && window.samples >= self.limits.fewest_samples =>
            {
                Verdict::Still
            }
            _ => Verdict::Moving,
        }
    }

    /// Counts of the pose in which the arm rests: the window's first sample, and the mean of the window relative to
    /// it. None when no sample has come yet.
    pub fn pose(&self) -> Option<([i32; CABLES], [f32; CABLES])> {
        let window = self.window.as_ref()?;
        let samples = f32::from(window.samples.max(1));
        Some((window.first, window.sums.map(|sum| sum as f32 / samples)))
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

    fn spread(&self) -> impl Iterator<Item = u32> {
        self.high.iter().zip(&self.low).map(|(high, low)| high.abs_diff(*low))
    }

    /// Index of the cable that moved most, if it left the band.
    fn out_of_band(&self, band_counts: u32) -> Option<usize> {
        let (index, widest) = self.spread().enumerate().max_by_key(|(_, spread)| *spread)?;
        (widest > band_counts).then_some(index)
    }

    /// A turning arm moves at least four cables; it leaves at rest at most the two that share an attachment point on
    /// its axis. So when at least four rest (within half of the band) while one runs, that one does not follow the arm.
    fn loose(&self, widest: usize, band_counts: u32) -> Option<u8> {
        // A window of one or two samples has not seen whether the others rest.
        let seen_enough = self.samples >= 4;
        let at_rest = self.spread().filter(|spread| *spread <= band_counts / 2).count();
        (seen_enough && at_rest >= 4).then_some(widest as u8 + 1)
    }
}
