//! The clock tree: everything at 170 MHz from the board's crystal.
//!
//! The crystal, not the chip's own oscillator: CAN at 500 kbit/s wants a clock within half a percent over temperature.

use embassy_stm32::Config;
use embassy_stm32::rcc::{Hse, HseMode, Pll, PllMul, PllPreDiv, PllRDiv, PllSource, Sysclk, mux};
use embassy_stm32::time::Hertz;
use glenoid::drive_board::clock::CORE_HZ;

/// The crystal X3 of the NUCLEO-G474RE (UM2505, "OSC clock supply").
const CRYSTAL_HZ: u32 = 24_000_000;
/// The factors that [`PREDIVIDER`], [`MULTIPLIER`] and [`DIVIDER`] stand for.
const FACTORS: (u32, u32, u32) = (6, 85, 2);
const PREDIVIDER: PllPreDiv = PllPreDiv::DIV6;
const MULTIPLIER: PllMul = PllMul::MUL85;
const DIVIDER: PllRDiv = PllRDiv::DIV2;

const _: () = assert!(CRYSTAL_HZ / FACTORS.0 * FACTORS.1 / FACTORS.2 == CORE_HZ);

/// What embassy-stm32 is to set up. Without the crystal it waits for ever: the lamp stays dark and the bus silent.
pub fn config() -> Config {
    let mut config = Config::default();
    let rcc = &mut config.rcc;
    rcc.hse = Some(Hse { freq: Hertz(CRYSTAL_HZ), mode: HseMode::Oscillator });
    rcc.hsi48 = None;
    rcc.pll = Some(Pll {
        source: PllSource::HSE,
        prediv: PREDIVIDER,
        mul: MULTIPLIER,
        divp: None,
        divq: None,
        divr: Some(DIVIDER),
    });
    rcc.sys = Sysclk::PLL1_R;
    // above 150 MHz (RM0440, 6.1.5)
    rcc.boost = true;
    rcc.mux.fdcansel = mux::Fdcansel::PCLK1;
    config
}
