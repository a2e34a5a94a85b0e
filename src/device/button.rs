//! The button: from a bouncing contact to short, long and very long presses.

/// The contact must keep its level for this long, ms. Bounces of a push button last up to 10 ms.
const DEBOUNCE_MS: u32 = 30;
/// From this on a press is long, ms: nobody leans on a button for that long by accident and lets go.
const LONG_MS: u32 = 1_200;
/// From this on it is very long, ms.
const VERY_LONG_MS: u32 = 4_000;
/// From this on the button is stuck, ms.
const STUCK_MS: u32 = 12_000;

/// A press that has been recognised.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Press {
    /// Released within 1.2 s.
    Short,
    /// Released between 1.2 and 4 s.
    Long,
    /// Released between 4 and 12 s. Not sooner: a contact that is stuck does nothing at all.
    VeryLong,
}

/// How long the button has been held.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Held {
    /// It is up.
    Not,
    /// Letting go now makes a short press.
    Short,
    /// Letting go now makes a long press.
    Long,
    /// Letting go now makes a very long press.
    VeryLong,
    /// Longer than any person holds it.
    Stuck,
}

/// The debounced button.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Button {
    /// The contact's level, and since when.
    raw_down: bool,
    raw_since_ms: u32,
    /// The debounced press.
    held: Held,
    down_since_ms: u32,
    /// The contact has been open since power-up. One that was closed from the beginning is stuck until it opens.
    was_up: bool,
}

impl Button {
    /// A button that is up.
    pub const fn new() -> Self {
        Self { raw_down: false, raw_since_ms: 0, held: Held::Not, down_since_ms: 0, was_up: false }
    }

    /// The contact's level, at every change or more often.
    pub fn level(&mut self, now_ms: u32, down: bool) {
        if down != self.raw_down {
            self.raw_down = down;
            self.raw_since_ms = now_ms;
        }
    }

    /// Time passes. Returns the press that it completes.
    pub fn tick(&mut self, now_ms: u32) -> Option<Press> {
        if now_ms.wrapping_sub(self.raw_since_ms) < DEBOUNCE_MS {
            return None;
        }
        let before = self.held;
        self.held = match (self.raw_down, before) {
            (false, _) => {
                self.was_up = true;
                Held::Not
            }
            (true, _) if !self.was_up => Held::Stuck,
            (true, Held::Not) => {
                self.down_since_ms = self.raw_since_ms;
                Held::Short
            }
            // never shorter again before it is released, however the clock runs
            (true, _) => self.by_time(now_ms).at_least(before),
        };
        match (before, self.held) {
            (Held::Short, Held::Not) => Some(Press::Short),
            (Held::Long, Held::Not) => Some(Press::Long),
            (Held::VeryLong, Held::Not) => Some(Press::VeryLong),
            _ => None,
        }
    }

    /// How long the button has been held.
    pub const fn held(&self) -> Held {
        self.held
    }

    fn by_time(&self, now_ms: u32) -> Held {
        match now_ms.wrapping_sub(self.down_since_ms) {
            0..LONG_MS => Held::Short,
            LONG_MS..VERY_LONG_MS => Held::Long,
            VERY_LONG_MS..STUCK_MS => Held::VeryLong,
            STUCK_MS.. => Held::Stuck,
        }
    }
}

impl Default for Button {
    fn default() -> Self {
        Self::new()
    }
}

impl Held {
    fn at_least(self, other: Self) -> Self {
        if (self as u8) < other as u8 { other } else { self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Presses from `from_ms` on for `length_ms`, ticks every 10 ms until a second after, collects what is recognised.
    fn press(from_ms: u32, length_ms: u32) -> Vec<Press> {
        let mut button = Button::new();
        button.tick(from_ms.wrapping_sub(10));
        let mut presses = Vec::new();
        for step in 0..(length_ms + 1_000) / 10 {
            let after_ms = step * 10;
            let now_ms = from_ms.wrapping_add(after_ms);
            button.level(now_ms, after_ms < length_ms);
            presses.extend(button.tick(now_ms));
        }
        presses
    }

    extern crate std;
    use std::vec::Vec;

    #[test]
    fn a_press_is_named_by_its_length() {
        for (length_ms, expected) in [
            (20, None),
            (100, Some(Press::Short)),
            (1_100, Some(Press::Short)),
            (1_300, Some(Press::Long)),
            (3_900, Some(Press::Long)),
            (4_100, Some(Press::VeryLong)),
            (11_900, Some(Press::VeryLong)),
            (12_100, None),
            (60_000, None),
        ] {
            assert_eq!(press(5_000, length_ms), expected.into_iter().collect::<Vec<_>>(), "{length_ms} ms");
        }
    }

    #[test]
    fn the_clock_may_wrap_while_it_is_held() {
        assert_eq!(press(u32::MAX - 1_000, 2_000), [Press::Long]);
    }

    #[test]
    fn bounces_are_not_presses() {
        let mut button = Button::new();
        button.tick(900);
        let mut presses = 0;
        // 5 ms of bounce at each end of a 200 ms press
        for now_ms in 1_000..1_500u32 {
            let bounces = matches!(now_ms, 1_000..1_005 | 1_200..1_205);
            let down = if bounces { now_ms % 2 == 0 } else { (1_005..1_200).contains(&now_ms) };
            button.level(now_ms, down);
            presses += u32::from(button.tick(now_ms).is_some());
        }
        assert_eq!(presses, 1);
    }

    #[test]
    fn a_stuck_contact_does_nothing_and_recovers() {
        let mut button = Button::new();
        button.tick(50);
        button.level(100, true);
        for now_ms in (100..13_000).step_by(10) {
            assert_eq!(button.tick(now_ms), None);
        }
        assert_eq!(button.held(), Held::Stuck);
        button.level(13_000, false);
        assert_eq!(button.tick(13_050), None);
        assert_eq!(button.held(), Held::Not);
    }

    #[test]
    fn a_contact_that_is_closed_at_power_up_is_stuck() {
        let mut button = Button::new();
        button.level(0, true);
        assert_eq!(button.tick(40), None);
        assert_eq!(button.held(), Held::Stuck);
        button.level(2_000, false);
        assert_eq!(button.tick(2_050), None);
        button.level(3_000, true);
        assert_eq!((button.tick(3_050), button.tick(4_900)), (None, None));
        button.level(5_000, false);
        assert_eq!(button.tick(5_050), Some(Press::Long));
    }
}
