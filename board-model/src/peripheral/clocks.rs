//! The clock tree as frequencies, and what the chip bears of them (RM0440, "Dynamic voltage scaling management", "Read
//! access latency", "System clock selection"; STM32G474 datasheet, general operating conditions).

use crate::breach::{Breaches, Rule};
use crate::time::PS_A_US;

/// Most of the core without the boost mode, Hz.
const MOST_WITHOUT_BOOST: u32 = 150_000_000;
/// Most with it, Hz.
const MOST: u32 = 170_000_000;
/// Above this frequency the AHB clock must be halved when the system clock is switched, Hz.
const STEP_FROM: u32 = 80_000_000;
/// One wait state more for each so many Hz of the AHB clock.
const HZ_A_WAIT_STATE: u32 = 30_000_000;
const HZ_A_WAIT_STATE_BOOSTED: u32 = 34_000_000;

/// Frequencies, Hz.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Clocks {
    /// The system clock.
    pub system: u32,
    /// The AHB clock: the core's.
    pub ahb: u32,
    /// The clock of the first peripheral bus.
    pub apb1: u32,
    /// The clock of the second.
    pub apb2: u32,
    /// What the timers of the first count with.
    pub apb1_timers: u32,
    /// What the timers of the second count with.
    pub apb2_timers: u32,
    /// The FDCAN controllers' own clock.
    pub fdcan: u32,
}

/// Everything that the rules look at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Supply {
    /// The clocks.
    pub clocks: Clocks,
    /// The core's voltage is that of the range 1 boost mode.
    pub boost: bool,
    /// Wait states of the flash.
    pub wait_states: u32,
}

impl Supply {
    /// Holds a change against the rules. `switched_ps` is when the system clock last passed [`STEP_FROM`].
    pub fn check(&self, before: &Self, now_ps: u64, switched_ps: &mut Option<u64>, breaches: &mut Breaches) {
        let mhz = |hz: u32| hz / 1_000_000;
        let clocks = &self.clocks;
        if clocks.system > MOST_WITHOUT_BOOST && !self.boost {
            breaches.add(Rule::NoBoost, format!("{} MHz while PWR_CR5.R1MODE is set", mhz(clocks.system)));
        }
        if clocks.system > MOST || clocks.fdcan > MOST {
            breaches.add(Rule::TooFast, format!("{} MHz, FDCAN {} MHz", mhz(clocks.system), mhz(clocks.fdcan)));
        }
        let hz_a_state = if self.boost { HZ_A_WAIT_STATE_BOOSTED } else { HZ_A_WAIT_STATE };
        let needed = clocks.ahb.div_ceil(hz_a_state).max(1) - 1;
        if self.wait_states < needed {
            let (has, mhz) = (self.wait_states, mhz(clocks.ahb));
            breaches.add(Rule::WaitStates, format!("{has} wait states at {mhz} MHz, which needs {needed}"));
        }
        if before.clocks.system <= STEP_FROM && clocks.system > STEP_FROM {
            *switched_ps = Some(now_ps);
            if clocks.ahb == clocks.system {
                breaches.add(Rule::AhbStep, format!("to {} MHz in one step", mhz(clocks.ahb)));
            }
        } else if before.clocks.ahb < before.clocks.system && clocks.ahb == clocks.system && clocks.ahb > STEP_FROM {
            let passed_ps = switched_ps.map_or(u64::MAX, |at| now_ps - at);
            if passed_ps < PS_A_US {
                let ns = passed_ps / 1_000;
                breaches.add(Rule::AhbStep, format!("the AHB clock is whole {ns} ns behind the switch"));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_enough(mhz: u32, boost: bool, wait_states: u32) -> bool {
        let hz = mhz * 1_000_000;
        let clocks = Clocks { system: hz, ahb: hz, apb1: hz, apb2: hz, apb1_timers: hz, apb2_timers: hz, fdcan: hz };
        let supply = Supply { clocks, boost, wait_states };
        let mut breaches = Breaches::default();
        supply.check(&supply, 0, &mut None, &mut breaches);
        !breaches.all().iter().any(|breach| breach.rule == Rule::WaitStates)
    }

    /// RM0440, "Number of wait states according to CPU clock (HCLK) frequency": the highest frequency for each number.
    #[test]
    fn the_wait_states_are_those_of_the_manual() {
        for (boost, highest_mhz) in [(true, [34, 68, 102, 136, 170]), (false, [30, 60, 90, 120, 150])] {
            for (wait_states, mhz) in (0..).zip(highest_mhz) {
                assert!(is_enough(mhz, boost, wait_states), "{mhz} MHz, {wait_states}, boost {boost}");
                assert!(!is_enough(mhz + 1, boost, wait_states), "{mhz} MHz, {wait_states}, boost {boost}");
            }
        }
    }
}
