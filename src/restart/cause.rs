//! The causes of a start, by their numbers on the bus.

/// Declares the enum, its list and its texts from one table.
macro_rules! causes {
    ($($name:ident = $code:literal, $text:literal;)+) => {
        /// Why the board started. The numbers go over CAN and are never renumbered; from 16 on the firmware stopped
        /// itself, or was stopped.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        #[repr(u8)]
        pub enum ResetCause {
            #[default]
            $(#[doc = $text] $name = $code,)+
        }

        impl ResetCause {
            /// All causes, in the order of their codes.
            pub const ALL: &'static [Self] = &[$(Self::$name,)+];

            /// The cause with this code, if one has it.
            pub const fn from_code(code: u8) -> Option<Self> {
                match code {
                    $($code => Some(Self::$name),)+
                    _ => None,
                }
            }

            /// The name that the DBC gives the code.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$name => stringify!($name),)+
                }
            }

            /// What happened, in words.
            pub const fn text(self) -> &'static str {
                match self {
                    $(Self::$name => $text,)+
                }
            }
        }
    };
}

causes! {
    Unknown = 0, "the board does not say";
    PowerOn = 1, "the supply came on, or dipped below its limit";
    Pin = 2, "the reset pin";
    Requested = 3, "a reset was asked for, as a debugger does";
    OptionBytes = 4, "the option bytes were loaded anew";

    Watchdog = 16, "the watchdog: the main loop had stopped";
    Panic = 17, "a panic";
    Fault = 18, "a fault of the processor";
    StackOverflow = 19, "the stack was full";
    MemoryError = 20, "a word of memory could not be corrected";
    UnexpectedInterrupt = 21, "an interrupt that nobody serves";
}

impl ResetCause {
    /// The number on the wire.
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// The firmware stopped: something is wrong with it or with the board.
    pub const fn is_fault(self) -> bool {
        self as u8 >= Self::Watchdog as u8
    }
}

#[cfg(test)]
mod tests {
    use super::ResetCause;

    #[test]
    fn codes_never_change() {
        let released = [
            (0, "Unknown"),
            (1, "PowerOn"),
            (2, "Pin"),
            (3, "Requested"),
            (4, "OptionBytes"),
            (16, "Watchdog"),
            (17, "Panic"),
            (18, "Fault"),
            (19, "StackOverflow"),
            (20, "MemoryError"),
            (21, "UnexpectedInterrupt"),
        ];
        assert!(ResetCause::ALL.iter().map(|cause| (cause.code(), cause.name())).eq(released));
        for code in 0..=u8::MAX {
            let known = released.iter().any(|(released, _)| *released == code);
            assert_eq!(ResetCause::from_code(code).is_some(), known);
            assert!(ResetCause::from_code(code).is_none_or(|cause| cause.code() == code));
        }
    }
}
