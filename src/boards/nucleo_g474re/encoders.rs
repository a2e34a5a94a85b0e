//! Six timers that count the encoders' edges by themselves.

use embassy_stm32::Peri;
use embassy_stm32::gpio::Pull;
use embassy_stm32::pac;
use embassy_stm32::pac::timer::vals::FilterValue;
use embassy_stm32::peripherals::{
    PA0, PA1, PA6, PA7, PB2, PB6, PB7, PC0, PC1, PC6, PC7, PC12, TIM1, TIM2, TIM3, TIM4, TIM5, TIM8,
};
use embassy_stm32::timer::qei::{Config, Qei};
use glenoid::drive_board::counts::{FILTER_PERIODS, extended};
use glenoid::rig::CABLES;

/// [`FILTER_PERIODS`] by its name in the timer.
const FILTER: FilterValue = FilterValue::FDTS_DIV32_N8;
const _: () = assert!(FILTER_PERIODS == 8 * 32);

type Static<T> = Peri<'static, T>;

/// A timer with its two inputs: channels A and B of an encoder.
type Wired<T, A, B> = (Static<T>, Static<A>, Static<B>);

/// The peripherals that the encoders take.
pub struct Wiring {
    pub cable_1: Wired<TIM1, PC0, PC1>,
    pub cable_2: Wired<TIM2, PA0, PA1>,
    pub cable_3: Wired<TIM3, PA6, PA7>,
    pub cable_4: Wired<TIM4, PB6, PB7>,
    pub cable_5: Wired<TIM5, PB2, PC12>,
    pub cable_6: Wired<TIM8, PC6, PC7>,
}

type Counting<T> = Qei<'static, T>;

/// The running timers. Dropping them would disconnect their pins.
pub struct Encoders {
    _cable_1: Counting<TIM1>,
    _cable_2: Counting<TIM2>,
    _cable_3: Counting<TIM3>,
    _cable_4: Counting<TIM4>,
    _cable_5: Counting<TIM5>,
    _cable_6: Counting<TIM8>,
}

impl Encoders {
    /// Starts the timers at zero.
    pub fn start(wiring: Wiring) -> Self {
        let Wiring { cable_1, cable_2, cable_3, cable_4, cable_5, cable_6 } = wiring;
        // a cut wire reads as a constant level, not as whatever it picks up
        let config = || {
            let mut config = Config::default();
            (config.ch1_pull, config.ch2_pull) = (Pull::Up, Pull::Up);
            config
        };
        let encoders = Self {
            _cable_1: Qei::new(cable_1.0, cable_1.1, cable_1.2, config()),
            _cable_2: Qei::new(cable_2.0, cable_2.1, cable_2.2, config()),
            _cable_3: Qei::new(cable_3.0, cable_3.1, cable_3.2, config()),
            _cable_4: Qei::new(cable_4.0, cable_4.1, cable_4.2, config()),
            _cable_5: Qei::new(cable_5.0, cable_5.1, cable_5.2, config()),
            _cable_6: Qei::new(cable_6.0, cable_6.1, cable_6.2, config()),
        };
        // what the driver does not do: the filters, and all 32 bits of the two long timers
        for channel in 0..2 {
            pac::TIM1.ccmr_input(0).modify(|w| w.set_icf(channel, FILTER));
            pac::TIM2.ccmr_input(0).modify(|w| w.set_icf(channel, FILTER));
            pac::TIM3.ccmr_input(0).modify(|w| w.set_icf(channel, FILTER));
            pac::TIM4.ccmr_input(0).modify(|w| w.set_icf(channel, FILTER));
            pac::TIM5.ccmr_input(0).modify(|w| w.set_icf(channel, FILTER));
            pac::TIM8.ccmr_input(0).modify(|w| w.set_icf(channel, FILTER));
        }
        pac::TIM2.arr().write_value(u32::MAX);
        pac::TIM5.arr().write_value(u32::MAX);
        // the edges that pulling the inputs up made
        pac::TIM1.cnt().write(|w| w.set_cnt(0));
        pac::TIM2.cnt().write_value(0);
        pac::TIM3.cnt().write(|w| w.set_cnt(0));
        pac::TIM4.cnt().write(|w| w.set_cnt(0));
        pac::TIM5.cnt().write_value(0);
        pac::TIM8.cnt().write(|w| w.set_cnt(0));
        encoders
    }
}

/// The counts now, given those of the sample before.
pub fn read(before: [i32; CABLES]) -> [i32; CABLES] {
    let [b1, _, b3, b4, _, b6] = before;
    [
        extended(b1, pac::TIM1.cnt().read().cnt()),
        // two's complement as it stands
        pac::TIM2.cnt().read() as i32,
        extended(b3, pac::TIM3.cnt().read().cnt()),
        extended(b4, pac::TIM4.cnt().read().cnt()),
        pac::TIM5.cnt().read() as i32,
        extended(b6, pac::TIM8.cnt().read().cnt()),
    ]
}
