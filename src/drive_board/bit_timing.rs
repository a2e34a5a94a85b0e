//! The CAN bit, in time quanta.

use core::num::{NonZeroU8, NonZeroU16};

/// Largest prescaler, NBRP + 1 (RM0440, 44.4.7: FDCAN_NBTP).
const MAX_PRESCALER: u32 = 512;
/// Most quanta of the first segment, NTSEG1 + 1.
const MAX_SEGMENT_1: u32 = 256;
/// Most quanta of the second segment, NTSEG2 + 1.
const MAX_SEGMENT_2: u32 = 128;
/// A bit has at least this many quanta: ISO 11898-1 asks no controller for less than 8, and what is coarser
/// places the sample point badly.
const MIN_QUANTA: u32 = 8;
/// More quanta than this buy nothing: every node resynchronises to within one of its own.
const MAX_QUANTA: u32 = 25;

/// How a bit is divided: one quantum to synchronise, `segment_1` up to the sample point, `segment_2` behind it. Each is
/// the number of quanta itself, not the register's "one less".
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BitTiming {
    /// Clock periods of one quantum.
    pub prescaler: NonZeroU16,
    /// Quanta between the synchronisation and the sample point.
    pub segment_1: NonZeroU8,
    /// Quanta between the sample point and the end of the bit.
    pub segment_2: NonZeroU8,
    /// Most quanta that one resynchronisation moves the sample point.
    pub jump: NonZeroU8,
}

/// Why there is no such timing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum TimingError {
    /// No whole number of quanta makes a bit of this length.
    NotDivisible = 1,
    /// The sample point is no share of the bit.
    SamplePoint = 2,
}

impl BitTiming {
    /// The timing for a bit rate, exact, with the sample point nearest to `sample_permille` of the bit; of two equally
    /// near the one with more quanta.
    ///
    /// # Errors
    /// [`TimingError`].
    pub const fn new(clock_hz: u32, bit_hz: u32, sample_permille: u32) -> Result<Self, TimingError> {
        if sample_permille == 0 || sample_permille >= 1_000 {
            return Err(TimingError::SamplePoint);
        }
        let mut best: Option<(u32, Self)> = None;
        let mut quanta = MAX_QUANTA;
        while quanta >= MIN_QUANTA {
            if let Some(timing) = Self::of_quanta(clock_hz, bit_hz, quanta, sample_permille) {
                let distance = timing.sample_permille().abs_diff(sample_permille);
                let is_nearer = match best {
                    Some((least, _)) => distance < least,
                    None => true,
                };
                if is_nearer {
                    best = Some((distance, timing));
                }
            }
            quanta -= 1;
        }
        match best {
            Some((_, timing)) => Ok(timing),
            None => Err(TimingError::NotDivisible),
        }
    }

    /// The timing with so many quanta a bit, if it is exact.
    const fn of_quanta(clock_hz: u32, bit_hz: u32, quanta: u32, sample_permille: u32) -> Option<Self> {
        let Some(quanta_hz) = bit_hz.checked_mul(quanta) else { return None };
        if quanta_hz == 0 || !clock_hz.is_multiple_of(quanta_hz) {
            return None;
        }
        let prescaler = clock_hz / quanta_hz;
        // rounded; the synchronisation's quantum lies before the first segment
        let before_sample = (quanta * sample_permille + 500) / 1_000;
        let segment_1 = before_sample.saturating_sub(1);
        let segment_2 = quanta.saturating_sub(before_sample);
        if prescaler > MAX_PRESCALER || segment_1 > MAX_SEGMENT_1 || segment_2 > MAX_SEGMENT_2 {
            return None;
        }
        // as far as a bit can be moved without its sample point leaving it
        let jump = if segment_1 < segment_2 { segment_1 } else { segment_2 };
        match (
            NonZeroU16::new(prescaler as u16),
            NonZeroU8::new(segment_1 as u8),
            NonZeroU8::new(segment_2 as u8),
            NonZeroU8::new(jump as u8),
        ) {
            (Some(prescaler), Some(segment_1), Some(segment_2), Some(jump)) => {
                Some(Self { prescaler, segment_1, segment_2, jump })
            }
            _ => None,
        }
    }

    /// Quanta of one bit.
    pub const fn quanta(self) -> u32 {
        1 + self.segment_1.get() as u32 + self.segment_2.get() as u32
    }

    /// Where the bit is sampled, thousandths of it.
    pub const fn sample_permille(self) -> u32 {
        (1 + self.segment_1.get() as u32) * 1_000 / self.quanta()
    }
}
