//! The clock tree: everything at 170 MHz from the board's crystal.
//!
//! The crystal, not the chip's own oscillator: CAN at 500 kbit/s wants a clock within half a percent over temperature.
//!
//! embassy-stm32 starts the crystal and the PLL; the step to the PLL is made here. The driver takes the AHB prescaler back
//! in the same write that selects the PLL, and its register description has R1MODE at another bit.
//!
//! So the driver takes the core's clock for the 16 MHz that it left behind. Nothing of it that this board uses asks: the
//! CAN bit is given in quanta of [`CORE_HZ`], the watchdog runs on an oscillator of its own, the timers count edges.

use cortex_m::asm;
use embassy_stm32::pac::flash::vals::Latency;
use embassy_stm32::rcc::{AHBPrescaler, Hse, HseMode, Pll, PllMul, PllPreDiv, PllRDiv, PllSource, Sysclk, mux};
use embassy_stm32::time::Hertz;
use embassy_stm32::{Config, Peripherals, pac};
use glenoid::drive_board::clock::{BOOST_SETTLING_PERIODS, CORE_HZ, R1MODE};

/// The crystal X3 of the NUCLEO-G474RE (UM2505, "OSC clock supply").
const CRYSTAL_HZ: u32 = 24_000_000;
/// The factors that [`PREDIVIDER`], [`MULTIPLIER`] and [`DIVIDER`] stand for.
const FACTORS: (u32, u32, u32) = (6, 85, 2);
const PREDIVIDER: PllPreDiv = PllPreDiv::DIV6;
const MULTIPLIER: PllMul = PllMul::MUL85;
const DIVIDER: PllRDiv = PllRDiv::DIV2;

const _: () = assert!(CRYSTAL_HZ / FACTORS.0 * FACTORS.1 / FACTORS.2 == CORE_HZ);

/// Sets the clocks up, and gives the peripherals. Call it once. Without the crystal it waits for ever: the lamp stays
/// dark and the bus silent.
pub fn start() -> Peripherals {
    let chip = embassy_stm32::init(config());
    switch_to_pll();
    chip
}

/// What embassy-stm32 is to set up: the core stays on the chip's own oscillator, the PLL runs beside it.
fn config() -> Config {
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
    rcc.sys = Sysclk::HSI;
    rcc.mux.fdcansel = mux::Fdcansel::PCLK1;
    config
}

/// From 16 MHz to 170 MHz in the order of RM0440 ("Dynamic voltage scaling management"): half the AHB clock, more core voltage,
/// wait states, the switch, a pause, the whole AHB clock.
///
/// The driver's start has reset the power controller, so the voltage is raised after it.
fn switch_to_pll() {
    pac::RCC.cfgr().modify(|w| w.set_hpre(AHBPrescaler::DIV2));
    pac::PWR.cr5().modify(|w| w.0 &= !R1MODE);
    // for 136 to 170 MHz in range 1 boost mode (RM0440, "Read access latency")
    pac::FLASH.acr().modify(|w| w.set_latency(Latency::WS4));
    while pac::FLASH.acr().read().latency() != Latency::WS4 {}
    pac::RCC.cfgr().modify(|w| w.set_sw(Sysclk::PLL1_R));
    while pac::RCC.cfgr().read().sws() != Sysclk::PLL1_R {}
    asm::delay(BOOST_SETTLING_PERIODS);
    pac::RCC.cfgr().modify(|w| w.set_hpre(AHBPrescaler::DIV1));
}
