//! Checks the encoders: a silent, frozen or jumping one is named by its cable.

use super::reason::Reason;
use crate::rig::{CABLES, Drum};

/// How far the count of an encoder at rest may dither, counts: it may stand on an edge.
pub const DITHER_COUNTS: u32 = 1;

/// When an encoder is no longer believed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct EncoderLimits {
    /// No sample for this long: silent, ms.
    pub silence_ms: u32,
    /// How late a sample may reach the device, ms; at most one mean period of the samples counts.
    pub jitter_ms: u32,
    /// A cable that has rested (within [`DITHER_COUNTS`]) while three others moved this far is frozen, counts.
    pub frozen_counts: u32,
    /// So many samples in a row at a new place after a jump, and the count is lost; fewer were a glitch.
    pub lost_after_samples: u8,
    /// Encoders in use, from the first on; the others may rest for ever.
    pub cables: u8,
}

/// What is wrong now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct EncoderFault {
    /// [`Reason::EncoderSilent`], [`Reason::EncoderFrozen`] or [`Reason::EncoderJumped`].
    pub reason: Reason,
    /// Cable 1 to 6, 0 when all are meant.
    pub cable: u8,
}

/// The watch over the six encoders.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Encoders {
    limits: EncoderLimits,
    /// Time of the last sample, believed or not; of the first tick while there has been none.
    heard_ms: Option<u32>,
    last: Option<Sample>,
    /// Mean time between two samples, in sixteenths of a millisecond.
    period_ms_16: u32,
    /// Samples that are not believed, and since when they stand elsewhere.
    suspect: Option<Suspect>,
    lost: Option<u8>,
    frozen: Option<u8>,
    /// Lowest and highest counts since the last time that every encoder had moved.
    low: [i32; CABLES],
    high: [i32; CABLES],
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Sample {
    at_ms: u32,
    counts: [i32; CABLES],
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Suspect {
    last: Sample,
    samples: u8,
    cable: u8,
}

impl Encoders {
    /// A watch that has seen nothing yet.
    pub const fn new(limits: EncoderLimits) -> Self {
        Self {
            limits,
            heard_ms: None,
            last: None,
            period_ms_16: 0,
            suspect: None,
            lost: None,
            frozen: None,
            low: [0; CABLES],
            high: [0; CABLES],
        }
    }

    /// Time passes: from the first tick on, samples are expected.
    pub fn tick(&mut self, now_ms: u32) {
        self.heard_ms.get_or_insert(now_ms);
    }

    /// Takes in one sample. True when it is believed.
    pub fn sample(&mut self, now_ms: u32, counts: &[i32; CABLES], drum: &Drum<f32>) -> bool {
        let sample = Sample { at_ms: now_ms, counts: *counts };
        self.note_period(now_ms);
        self.heard_ms = Some(now_ms);
        let Some(last) = self.last else {
            self.believe(sample);
            (self.low, self.high) = (*counts, *counts);
            return true;
        };
        let jump = drum.check_jump(&last.counts, counts, self.elapsed(last.at_ms, now_ms));
        // Still where the jump went: one more witness. The time since the last believed sample grows meanwhile, until
        // the drum could have turned that far; so the nearer of the two places counts.
        let witnessed = self.suspect.filter(|suspect| {
            drum.check_jump(&suspect.last.counts, counts, self.elapsed(suspect.last.at_ms, now_ms)).is_ok()
                && distance(&suspect.last.counts, counts) <= distance(&last.counts, counts)
        });
        let (samples, cable) = match (witnessed, jump) {
            (Some(suspect), _) => (suspect.samples.saturating_add(1), suspect.cable),
            (None, Err(jump)) => (1, jump.cable),
            (None, Ok(())) => {
                self.believe(sample);
                self.watch_frozen(counts);
                return true;
            }
        };
        self.suspect = Some(Suspect { last: sample, samples, cable });
        if samples >= self.limits.lost_after_samples {
            self.lost = Some(cable);
            self.believe(sample);
            (self.low, self.high) = (*counts, *counts);
        }
        false
    }

    /// What is wrong at this moment; the gravest first.
    pub fn fault(&self, now_ms: u32) -> Option<EncoderFault> {
        let silent = self.heard_ms.is_some_and(|heard_ms| now_ms.wrapping_sub(heard_ms) > self.limits.silence_ms);
        let fault = |reason, cable| Some(EncoderFault { reason, cable });
        if silent {
            fault(Reason::EncoderSilent, 0)
        } else if let Some(cable) = self.lost.or(self.suspect.map(|suspect| suspect.cable)) {
            fault(Reason::EncoderJumped, cable)
        } else if let Some(cable) = self.frozen {
            fault(Reason::EncoderFrozen, cable)
        } else {
            None
        }
    }

    /// The cable whose count is lost: it jumped and stayed where it jumped to.
    pub const fn lost(&self) -> Option<u8> {
        self.lost
    }

    /// A new run begins from where the encoders stand now.
    pub fn forgive(&mut self) {
        self.lost = None;
    }

    /// The time in which a cable may have moved, ms. A long pause between two samples does not make a long jump
    /// believable; samples that arrive together were not taken together, but a mean period apart. A clock of milliseconds knows
    /// no shorter time than one.
    fn elapsed(&self, from_ms: u32, to_ms: u32) -> u32 {
        let period_ms = (self.period_ms_16 / 16).max(1);
        let between_ms = to_ms.wrapping_sub(from_ms).min(self.limits.silence_ms).max(period_ms);
        between_ms.saturating_add(self.limits.jitter_ms.min(period_ms))
    }

    fn note_period(&mut self, now_ms: u32) {
        let since_ms = self.heard_ms.map_or(0, |heard_ms| now_ms.wrapping_sub(heard_ms).min(self.limits.silence_ms));
        // a running mean over sixteen samples
        self.period_ms_16 = self.period_ms_16 - self.period_ms_16 / 16 + since_ms;
    }

    fn believe(&mut self, sample: Sample) {
        self.last = Some(sample);
        self.suspect = None;
    }

    fn watch_frozen(&mut self, counts: &[i32; CABLES]) {
        for ((low, high), count) in self.low.iter_mut().zip(&mut self.high).zip(counts) {
            *low = (*low).min(*count);
            *high = (*high).max(*count);
        }
        let cables = usize::from(self.limits.cables);
        let spread = || self.high.iter().zip(&self.low).take(cables).map(|(high, low)| high.abs_diff(*low));
        match spread().position(|spread| spread <= DITHER_COUNTS) {
            None => {
                self.frozen = None;
                (self.low, self.high) = (*counts, *counts);
            }
            Some(index) => {
                if spread().filter(|spread| *spread >= self.limits.frozen_counts).count() >= 3 {
                    self.frozen = Some(index as u8 + 1);
                }
            }
        }
    }
}

/// How far apart two samples are: the largest difference of a count.
fn distance(one: &[i32; CABLES], other: &[i32; CABLES]) -> u32 {
    one.iter().zip(other).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::Rig;

    const LIMITS: EncoderLimits =
        EncoderLimits { silence_ms: 500, jitter_ms: 0, frozen_counts: 100, lost_after_samples: 3, cables: 6 };

    /// 1500 mm/s and 0.023 mm a count: 652 counts in 10 ms.
    const JUMP: i32 = 700;

    fn drum() -> Drum<f32> {
        *Rig::shoulder(150.0).unwrap().drum()
    }

    /// A watch that has seen a resting arm until `until_ms`, one sample every 10 ms.
    fn rested(until_ms: u32) -> Encoders {
        let mut encoders = Encoders::new(LIMITS);
        for now_ms in (0..=until_ms).step_by(10) {
            assert!(encoders.sample(now_ms, &[0; 6], &drum()));
        }
        encoders
    }

    fn reason(encoders: &Encoders, now_ms: u32) -> Option<(Reason, u8)> {
        encoders.fault(now_ms).map(|fault| (fault.reason, fault.cable))
    }

    #[test]
    fn silence_is_reported_after_its_time_and_not_before_the_first_tick() {
        let mut encoders = Encoders::new(LIMITS);
        assert_eq!(reason(&encoders, 1_000_000), None);
        encoders.tick(u32::MAX - 100);
        assert_eq!(reason(&encoders, 399), None);
        assert_eq!(reason(&encoders, 400), Some((Reason::EncoderSilent, 0)));
        encoders.sample(401, &[0; 6], &drum());
        assert_eq!(reason(&encoders, 402), None);
    }

    #[test]
    fn a_jump_that_comes_back_is_a_glitch() {
        let mut encoders = rested(100);
        assert!(!encoders.sample(110, &[0, 0, 0, 0, JUMP, 0], &drum()));
        assert_eq!(reason(&encoders, 110), Some((Reason::EncoderJumped, 5)));
        assert!(encoders.sample(120, &[0; 6], &drum()));
        assert_eq!((reason(&encoders, 120), encoders.lost()), (None, None));
    }

    #[test]
    fn a_jump_that_stays_is_a_lost_count() {
        let mut encoders = rested(100);
        for now_ms in [110, 120, 130] {
            assert_eq!(encoders.lost(), None);
            assert!(!encoders.sample(now_ms, &[0, -9 * JUMP, 0, 0, 0, 0], &drum()));
        }
        assert_eq!(encoders.lost(), Some(2));
        // from there it counts on, but the loss is not forgotten before a new run
        assert!(encoders.sample(140, &[0, -9 * JUMP, 0, 0, 0, 0], &drum()));
        assert_eq!(reason(&encoders, 140), Some((Reason::EncoderJumped, 2)));
        encoders.forgive();
        assert_eq!(reason(&encoders, 140), None);
    }

    /// A leap that stays is a lost count however long it is watched, and at every sampling rate a leap beyond what the
    /// drum turns in two periods is seen.
    #[test]
    fn a_leap_that_stays_is_never_believed() {
        for (period_ms, leap) in [(10u32, 2_000), (10, 1_400), (1, 200)] {
            let limits = EncoderLimits { jitter_ms: 20, lost_after_samples: 5, ..LIMITS };
            let mut encoders = Encoders::new(limits);
            let mut now_ms = 0;
            for _ in 0..200 {
                now_ms += period_ms;
                assert!(encoders.sample(now_ms, &[0; 6], &drum()));
            }
            for sample in 1..=5 {
                now_ms += period_ms;
                assert!(!encoders.sample(now_ms, &[0, 0, leap, 0, 0, 0], &drum()), "{leap} in {period_ms} ms");
                assert_eq!(encoders.lost(), (sample == 5).then_some(3), "{leap} in {period_ms} ms");
            }
        }
    }

    #[test]
    fn a_pause_does_not_make_a_jump_believable() {
        let mut encoders = rested(100);
        // 60 s would be enough for 90 m of cable; half a second for 33 000 counts
        assert!(!encoders.sample(60_000, &[40_000, 0, 0, 0, 0, 0], &drum()));
    }

    /// An arm at 1 m/s is no fault at any rate of sampling, 20 samples a millisecond included.
    #[test]
    fn samples_within_one_millisecond_are_no_jump() {
        for samples_a_ms in [1, 4, 20] {
            let mut encoders = rested(0);
            for step in 1..=100 * samples_a_ms {
                let counts = [43 * step / samples_a_ms; CABLES];
                assert!(encoders.sample((step / samples_a_ms) as u32, &counts, &drum()), "{samples_a_ms}: {step}");
            }
        }
    }

    #[test]
    fn the_encoder_that_rests_while_others_move_is_frozen() {
        let mut encoders = rested(0);
        for step in 1..=30 {
            let moved = step * 5;
            // the dither of one count at an edge is no movement
            encoders.sample(step as u32 * 10, &[moved, -moved, moved, step % 2, moved, moved], &drum());
            let frozen = (moved >= 100).then_some((Reason::EncoderFrozen, 4));
            assert_eq!(reason(&encoders, step as u32 * 10), frozen, "{step}");
        }
        encoders.sample(310, &[150, -150, 150, 20, 150, 150], &drum());
        assert_eq!(reason(&encoders, 310), None);
    }

    #[test]
    fn encoders_that_are_not_in_use_may_rest_and_hide_nothing() {
        let mut encoders = Encoders::new(EncoderLimits { cables: 4, ..LIMITS });
        let move_by = |encoders: &mut Encoders, from: i32, step: i32, counts: [i32; 4]| {
            let [a, b, c, d] = counts;
            encoders.sample((from + step) as u32 * 10, &[a, b, c, d, 0, 0], &drum());
        };
        for step in 0..60 {
            move_by(&mut encoders, 0, step, [step * 5, step * -5, step * 5, step * 5]);
            assert_eq!(reason(&encoders, step as u32 * 10), None, "{step}");
        }
        // It moved before, and freezes now.
        for step in 0..60 {
            move_by(&mut encoders, 60, step, [295 - step * 5, 295, 295 - step * 5, 295 - step * 5]);
        }
        assert_eq!(reason(&encoders, 1_190), Some((Reason::EncoderFrozen, 2)));
    }
}
