//! Cable lengths: from encoder counts, checked and corrected.

use crate::rig::{CABLES, Correction, Drum, Rig};
use crate::scalar::Real;

/// Six cable lengths L1..L6 of one pose, mm: finite and positive, by construction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CableLengths<T>([T; CABLES]);

/// A fault of a cable length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum LengthFault {
    /// NaN or infinite.
    NotFinite = 1,
    /// Zero or negative.
    NotPositive = 2,
    /// The two cables of an end-point and the base edge between them do not make a triangle.
    BreaksTriangle = 3,
    /// The count moved further than the drive can turn the drum in the time.
    Jump = 4,
}

impl LengthFault {
    /// The reason in words.
    pub const fn text(self) -> &'static str {
        match self {
            Self::NotFinite => "the length is not a finite number",
            Self::NotPositive => "the length is not positive",
            Self::BreaksTriangle => "the two cables of an end-point and their base edge make no triangle",
            Self::Jump => "the encoder moved further than the drum can turn",
        }
    }
}

/// An impossible cable length: which cable, and why.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LengthError {
    /// Cable, 1 to 6. For a broken triangle the first of its two cables.
    pub cable: u8,
    /// The fault.
    pub fault: LengthFault,
}

impl LengthError {
    /// The two cables of the end-point with this index, from 0, make no triangle.
    pub(super) const fn broken_triangle(point: usize) -> Self {
        Self { cable: cable_number(2 * point), fault: LengthFault::BreaksTriangle }
    }
}

impl<T: Real> CableLengths<T> {
    /// Six lengths L1..L6, mm.
    ///
    /// # Errors
    /// The first cable whose length is not finite or not positive.
    pub fn new(lengths_mm: [T; CABLES]) -> Result<Self, LengthError> {
        for (index, length) in lengths_mm.iter().enumerate() {
            let fault = if !length.is_a_number() {
                LengthFault::NotFinite
            } else if *length <= T::zero() {
                LengthFault::NotPositive
            } else {
                continue;
            };
            return Err(LengthError { cable: cable_number(index), fault });
        }
        Ok(Self(lengths_mm))
    }

    /// Lengths from encoder counts: home length plus the arc that the drum has turned,
    /// L = L_home + 2 pi r counts / counts_per_turn; less the offsets and by the scales that commissioning found, as in
    /// [`corrected`](Self::corrected).
    ///
    /// # Errors
    /// The first cable whose length would not be positive.
    pub fn from_counts(rig: &Rig<T>, counts: &[i32; CABLES]) -> Result<Self, LengthError> {
        Self::from_mean_counts(rig, counts, &[T::zero(); CABLES])
    }

    /// Lengths from the mean over samples: `counts` of the first sample, and by how much the mean lies above it, in
    /// counts.
    ///
    /// # Errors
    /// The first cable whose length would not be positive.
    pub fn from_mean_counts(rig: &Rig<T>, counts: &[i32; CABLES], above: &[T; CABLES]) -> Result<Self, LengthError> {
        let drum = rig.drum();
        let mm_per_count = drum.mm_per_count();
        Self::new(core::array::from_fn(|k| {
            // Within ±2^24 counts (over 380 m of cable on the shoulder's drum) f32 holds a count exactly.
            let paid_out_mm = (T::of_integer(counts[k]) + above[k]) * mm_per_count;
            let true_mm = rig.correction().map_or(paid_out_mm, |found| found.applied_to(k, paid_out_mm));
            drum.home_length_mm[k] + true_mm
        }))
    }

    /// True lengths L from readings by the correction that commissioning found for `rig`: reading = home + scale (L -
    /// home) + offset. Unchanged without one.
    ///
    /// # Errors
    /// The first cable whose length would not be positive.
    pub fn corrected(&self, rig: &Rig<T>) -> Result<Self, LengthError> {
        rig.correction().map_or(Ok(*self), |found| self.corrected_by(found, &rig.drum().home_length_mm))
    }

    /// The same by any correction about the home lengths `home_mm`.
    ///
    /// # Errors
    /// The first cable whose length would not be positive.
    #[cfg_attr(feature = "ccm", unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
    pub fn corrected_by(&self, found: &Correction<T>, home_mm: &[T; CABLES]) -> Result<Self, LengthError> {
        Self::new(core::array::from_fn(|k| home_mm[k] + found.applied_to(k, self.0[k] - home_mm[k])))
    }

    /// The lengths less the offset of each encoder, mm.
    ///
    /// # Errors
    /// The first cable whose length would not be positive.
    pub fn less(&self, offsets_mm: &[T; CABLES]) -> Result<Self, LengthError> {
        Self::new(core::array::from_fn(|k| self.0[k] - offsets_mm[k]))
    }

    /// The same lengths with those of two cables (indices from 0) exchanged, as by two swapped connectors.
    pub fn exchanged(mut self, first: usize, second: usize) -> Self {
        if first < CABLES && second < CABLES {
            self.0.swap(first, second);
        }
        self
    }

    /// The six lengths L1..L6, mm.
    pub fn as_mm(&self) -> &[T; CABLES] {
        &self.0
    }
}

/// Index from 0 to a cable's number from 1.
pub(crate) const fn cable_number(index: usize) -> u8 {
    index as u8 + 1
}

impl<T: Real> Drum<T> {
    /// Cable paid out by one count, mm.
    pub fn mm_per_count(&self) -> T {
        T::two_pi() * self.radius_mm / self.counts_per_turn
    }

    /// Can the drum have turned from `before` to `now` within `elapsed_ms`? A lost or doubled encoder edge is
    /// invisible to a quadrature counter; a jump is not.
    ///
    /// # Errors
    /// [`LengthFault::Jump`] and the first cable that moved faster than [`Drum::fastest_mm_per_s`].
    pub fn check_jump(&self, before: &[i32; CABLES], now: &[i32; CABLES], elapsed_ms: u32) -> Result<(), LengthError> {
        let elapsed_s = T::of_integer(elapsed_ms.min(i32::MAX as u32) as i32) * T::of(1e-3);
        // One count is always possible: a sample may fall just beside an edge.
        let farthest_mm = self.fastest_mm_per_s * elapsed_s + self.mm_per_count();
        for (index, (b, n)) in before.iter().zip(now).enumerate() {
            let moved_mm = T::of_integer(b.abs_diff(*n).min(i32::MAX as u32) as i32) * self.mm_per_count();
            if moved_mm > farthest_mm {
                return Err(LengthError { cable: cable_number(index), fault: LengthFault::Jump });
            }
        }
        Ok(())
    }
}
