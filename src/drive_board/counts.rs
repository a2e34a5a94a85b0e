//! From what a quadrature timer counts to a count that does not wrap, and the timers' input filter.

use super::clock::{CORE_HZ, SAMPLES_HZ};
use crate::rig::Drum;

/// Most counts that may pass between two samples of a 16-bit timer, so that forwards is distinguished from backwards.
pub const MAX_COUNTS_A_SAMPLE: u32 = 1 << 15;

/// Clock periods for which an input of a timer must keep its level to be believed: eight samples at a thirty-second of
/// the clock (RM0440, 29.6.8: ICxF = 0b1111), 1.5 us. The longest filter that there is.
pub const FILTER_PERIODS: u32 = 8 * 32;

/// The count that a 16-bit timer stands at, next to the one of the sample before: the nearest one with these lower 16
/// bits. Starts from 0 when the timer does.
pub const fn extended(before: i32, timer: u16) -> i32 {
    // the lower half of `before` is what the timer stood at
    let passed = timer.wrapping_sub(before as u16) as i16;
    before.wrapping_add(passed as i32)
}

/// The counts that pass in a second when a cable moves as fast as the drive can.
pub fn fastest_counts_a_second(drum: &Drum<f32>) -> f32 {
    drum.fastest_mm_per_s * drum.counts_per_turn / (core::f32::consts::TAU * drum.radius_mm)
}

/// Does a rig suit the board: at full speed each level of an encoder's channel (two counts long) lasts at least twice as
/// long as the filter asks for, and the counts between two samples tell the direction with a margin of two?
pub fn is_slow_enough(drum: &Drum<f32>) -> bool {
    let counts_a_second = fastest_counts_a_second(drum);
    let level_periods = 2.0 * CORE_HZ as f32 / counts_a_second;
    level_periods >= 2.0 * FILTER_PERIODS as f32
        && counts_a_second / SAMPLES_HZ as f32 <= (MAX_COUNTS_A_SAMPLE / 2) as f32
}
