//! Why the board last started, and the last words of the firmware that stopped.
//!
//! A board whose firmware can no longer be trusted (panic, fault, full stack, watchdog) does not try to go on: it writes
//! its last words into RAM that a reset leaves alone, resets, and starts as at power-up: no run, the stored centre in
//! use. The next start finds the words, and the device tells them on the bus. That is the safe state of this device:
//! it moves nothing, it only must not name a wrong centre.

mod cause;
mod last_words;

pub use cause::ResetCause;
pub use last_words::{Area, LastWords, TEXT_LEN};

/// What a board knows about its last start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Restart {
    /// Why it started.
    pub cause: ResetCause,
    /// What the firmware said before it stopped, if it could.
    pub last_words: Option<LastWords>,
}

impl Restart {
    /// From what the hardware says (its reset flags), and the area that the last words lie in.
    ///
    /// Last words are only those of this restart if the firmware itself, or the watchdog, brought it about: after a
    /// power-up they are what the RAM happens to hold, whatever their checksum says.
    pub fn new(by_hardware: ResetCause, area: &Area) -> Self {
        let last_words = match by_hardware {
            ResetCause::PowerOn => None,
            _ => LastWords::open(area),
        };
        Self { cause: last_words.as_ref().map_or(by_hardware, |words| words.cause), last_words }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn last_words_tell_more_than_the_hardware() {
        let words = LastWords::new(ResetCause::StackOverflow, 0x0800_1234, 0, format_args!("full"));
        let by = |hardware| Restart::new(hardware, &words.seal());
        assert_eq!(by(ResetCause::Requested).cause, ResetCause::StackOverflow);
        assert_eq!(by(ResetCause::Requested).last_words, Some(words));
        assert_eq!(by(ResetCause::PowerOn), Restart { cause: ResetCause::PowerOn, last_words: None });
    }

    #[test]
    fn without_last_words_the_hardware_is_believed() {
        let restart = Restart::new(ResetCause::Watchdog, &[0; _]);
        assert_eq!(restart, Restart { cause: ResetCause::Watchdog, last_words: None });
    }
}
