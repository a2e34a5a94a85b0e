//! A cable that moves by itself while the arm rests: slack that runs on its drum, or a noisy encoder.
//!
//! An arm that turns moves at least two cables noticeably. Over poses to 60 degrees of tilt and base radii of
//! 120-350 mm, the cable that moves second most moves by at least a tenth of what the first one moves (smallest ratio
//! over 7.5 million random turns about the centre: 0.097). So a cable that moves by eleven times the band while the
//! five others stay within it does not follow the arm.

use crate::rig::CABLES;

/// How far a cable must move alone, in bands.
const ALONE: u32 = 11;

/// The watch for one cable that moves alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LooseWatch {
    band_counts: u32,
    /// Lowest and highest counts since the watch began anew.
    range: Option<([i32; CABLES], [i32; CABLES])>,
    loose: Option<u8>,
}

impl LooseWatch {
    /// A watch that has seen nothing yet; `band_counts` is how far a cable at rest may move, counts.
    pub const fn new(band_counts: u32) -> Self {
        Self { band_counts, range: None, loose: None }
    }

    /// Everything rests: what moved before is forgotten.
    pub fn restart(&mut self) {
        self.range = None;
        self.loose = None;
    }

    /// The cable that moves alone, 1 to 6.
    pub const fn cable(&self) -> Option<u8> {
        self.loose
    }

    /// Takes in one sample.
    pub fn sample(&mut self, counts: &[i32; CABLES]) {
        let (low, high) = self.range.get_or_insert((*counts, *counts));
        let mut moving = 0;
        let mut alone = None;
        for (index, ((low, high), count)) in low.iter_mut().zip(high).zip(counts).enumerate() {
            *low = (*low).min(*count);
            *high = (*high).max(*count);
            let spread = high.abs_diff(*low);
            moving += u32::from(spread > self.band_counts);
            if spread > self.band_counts.saturating_mul(ALONE) {
                alone = Some(index as u8 + 1);
            }
        }
        if moving > 1 {
            // the arm moves
            self.range = Some((*counts, *counts));
            self.loose = None;
        } else if alone.is_some() {
            self.loose = alone;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_cable_that_moves_alone_is_loose() {
        let mut watch = LooseWatch::new(10);
        for step in 0..200 {
            watch.sample(&[0, 5, step, -5, 0, 9]);
            assert_eq!(watch.cable(), (step > 110).then_some(3), "{step}");
        }
        watch.restart();
        for step in 0..2_000 {
            // the second cable follows with a tenth of the speed
            watch.sample(&[0, 0, step, step / 10, 0, 0]);
            assert_eq!(watch.cable(), None, "{step}");
        }
    }
}
