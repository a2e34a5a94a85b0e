//! The status LED: one blink pattern a state. Patterns differ in rhythm, not in colour, so that everybody can read them.

/// What the status LED shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BlinkPattern {
    /// Idle without a centre: one flash in four seconds.
    Ready,
    /// Idle with a centre in use: two flashes in four seconds.
    InUse,
    /// Idle with a centre from the record that nothing has confirmed yet: one long flash in four seconds.
    Unconfirmed,
    /// Collecting: on and off, half a second each.
    Collecting,
    /// The solver works: on and off, a quarter of a second each.
    Working,
    /// The second set: one long, one short.
    Verifying,
    /// Waits for the decision, which two short presses begin: on, with two blinks in four seconds.
    Review2,
    /// The same with three.
    Review3,
    /// The same with four.
    Review4,
    /// The run failed: three flashes in two seconds.
    Failed,
    /// An encoder, a cable or the button is at fault: five flashes in four seconds.
    Fault,
    /// Idle, but the centre is not to be used, for something has slipped: two long and two short flashes in four seconds.
    Slipped,
    /// For a moment: the pose was taken. On, with two blinks a second.
    Captured,
    /// For a moment: what was asked for was refused. Two short flashes a second.
    Refused,
    /// The button is held long enough for a long press: on.
    LongPress,
    /// The very long press has been recognised: flickers.
    VeryLongPress,
}

impl BlinkPattern {
    /// All patterns.
    pub const ALL: [Self; 16] = [
        Self::Ready,
        Self::InUse,
        Self::Unconfirmed,
        Self::Collecting,
        Self::Working,
        Self::Verifying,
        Self::Review2,
        Self::Review3,
        Self::Review4,
        Self::Failed,
        Self::Fault,
        Self::Slipped,
        Self::Captured,
        Self::Refused,
        Self::LongPress,
        Self::VeryLongPress,
    ];

    /// Length of one beat of the pattern, ms.
    pub const BEAT_MS: u32 = 125;

    /// The pattern: bit k is the LED in beat k of 32, four seconds in all; then it repeats.
    pub const fn beats(self) -> u32 {
        match self {
            Self::Ready => 0b1,
            Self::InUse => 0b101,
            Self::Unconfirmed => 0xFF,
            Self::Collecting => 0x0F0F_0F0F,
            Self::Working => 0x3333_3333,
            Self::Verifying => 0x0CFF_0CFF,
            // blinks half a second apart, then a long light: they can be counted
            Self::Review2 => 0xFFFF_FFEE,
            Self::Review3 => 0xFFFF_FEEE,
            Self::Review4 => 0xFFFF_EEEE,
            Self::Failed => 0x0015_0015,
            Self::Fault => 0b1_0101_0101,
            Self::Slipped => 0x0005_0F0F,
            Self::Captured => 0x7777_7777,
            Self::Refused => 0x1111_1111,
            Self::LongPress => 0xFFFF_FFFF,
            Self::VeryLongPress => 0x5555_5555,
        }
    }

    /// Is the LED on at this moment? `now_ms` is the board's clock.
    pub const fn is_lit(self, now_ms: u32) -> bool {
        self.beats() >> (now_ms / Self::BEAT_MS % 32) & 1 == 1
    }
}

#[cfg(test)]
mod tests {
    use super::BlinkPattern;

    /// A person sees when the LED changes, not where a period begins.
    #[test]
    fn no_two_patterns_look_alike_from_any_beat_on() {
        for (index, one) in BlinkPattern::ALL.iter().enumerate() {
            for other in &BlinkPattern::ALL[index + 1..] {
                for shift in 0..32 {
                    assert_ne!(one.beats().rotate_left(shift), other.beats(), "{one:?} {other:?}");
                }
            }
        }
    }

    #[test]
    fn the_pattern_follows_the_clock() {
        let lit = |ms: u32| BlinkPattern::InUse.is_lit(ms);
        assert!(lit(0) && lit(124) && !lit(125) && lit(250) && !lit(375) && !lit(3_999) && lit(4_000));
    }
}
