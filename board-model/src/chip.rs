//! The chip without its processor: its parts, and the passing of time.

use crate::breach::Breaches;
use crate::core::mpu::Mpu;
use crate::core::nvic::{Nvic, exception};
use crate::core::scb::Scb;
use crate::core::systick::SysTick;
use crate::peripheral::Env;
use crate::peripheral::bus::Pins;
use crate::peripheral::clocks::Supply;
use crate::peripheral::fdcan::Fdcan;
use crate::peripheral::flash::{BANK_2, BANK_LEN, Cells, Flash};
use crate::peripheral::gpio::{Gpio, Mode};
use crate::peripheral::iwdg::Iwdg;
use crate::peripheral::plain::Plain;
use crate::peripheral::rcc::{Cause, HSI_HZ, Rcc};
use crate::peripheral::timer::Timer;
use crate::register_file::RegisterFile;
use crate::time::Time;
use std::collections::BTreeSet;

/// The chip.
#[derive(Debug, Clone)]
pub struct Chip {
    /// Time.
    pub time: Time,
    /// Broken rules.
    pub breaches: Breaches,
    /// Registers that were touched, by peripheral and name.
    pub touched: BTreeSet<String>,
    /// The interrupt controller.
    pub nvic: Nvic,
    /// System control and the cycle counter.
    pub scb: Scb,
    /// The core's timer.
    pub systick: SysTick,
    /// Memory protection.
    pub mpu: Mpu,
    /// Reset and clock control.
    pub rcc: Rcc,
    /// Power control.
    pub pwr: Plain,
    /// The flash.
    pub flash: Flash,
    /// The CAN controller.
    pub can: Fdcan,
    /// The timers of cables 1 to 6.
    pub timers: [Timer; 6],
    /// Ports A, B, C.
    pub ports: [Gpio; 3],
    /// The watchdog.
    pub iwdg: Iwdg,
    pub(crate) syscfg: Plain,
    pub(crate) dbgmcu: Plain,
    /// A reset is due.
    pub reset: Option<Cause>,
    /// The forbidden regions have changed.
    pub mpu_changed: bool,
    /// Changes what the firmware stores, for tests that put a defect back.
    pub alter: Option<fn(u32, u32) -> u32>,
    supply: Supply,
    switched_ps: Option<u64>,
}

impl Chip {
    /// A chip that comes on. `seed` chooses what its memories hold.
    pub fn new(cells: Cells, seed: u64) -> Self {
        let timer = |name, pins, on_apb2| Timer::new(name, pins, on_apb2);
        let (rcc, pwr, flash) = (Rcc::new(), Plain::new("PWR"), Flash::new(cells));
        let supply = supply(&rcc, &pwr, &flash);
        let mut chip = Self {
            time: Time::new(HSI_HZ),
            breaches: Breaches::default(),
            touched: BTreeSet::new(),
            nvic: Nvic::default(),
            scb: Scb::default(),
            systick: SysTick::default(),
            mpu: Mpu::default(),
            rcc,
            pwr,
            flash,
            can: Fdcan::new(seed),
            timers: [
                timer("TIM1", [(2, 0, 2), (2, 1, 2)], true),
                timer("TIM2", [(0, 0, 1), (0, 1, 1)], false),
                timer("TIM3", [(0, 6, 2), (0, 7, 2)], false),
                timer("TIM4", [(1, 6, 2), (1, 7, 2)], false),
                timer("TIM5", [(1, 2, 2), (2, 12, 1)], false),
                timer("TIM8", [(2, 6, 4), (2, 7, 4)], true),
            ],
            ports: [Gpio::new("GPIOA"), Gpio::new("GPIOB"), Gpio::new("GPIOC")],
            iwdg: Iwdg::new(),
            syscfg: Plain::new("SYSCFG"),
            dbgmcu: Plain::new("DBGMCU"),
            reset: None,
            mpu_changed: false,
            alter: None,
            supply,
            switched_ps: None,
        };
        chip.rcc.reset(Cause::Power);
        chip
    }

    /// A reset of everything but the memories.
    pub fn restart(&mut self, cause: Cause) {
        self.rcc.reset(cause);
        self.flash.reset();
        self.can.reset();
        self.iwdg = Iwdg::new();
        (self.nvic, self.scb, self.systick) = (Nvic::default(), Scb::default(), SysTick::default());
        (self.mpu, self.mpu_changed, self.switched_ps, self.reset) = (Mpu::default(), true, None, None);
        for file in self.files() {
            file.reset();
        }
        self.supply = supply(&self.rcc, &self.pwr, &self.flash);
        self.time.set_hz(self.supply.clocks.ahb);
    }

    /// The peripherals that are nothing but registers.
    pub(crate) fn files(&mut self) -> impl Iterator<Item = &mut RegisterFile> {
        let plain = [&mut self.pwr.file, &mut self.syscfg.file, &mut self.dbgmcu.file].into_iter();
        let timers = self.timers.iter_mut().map(|timer| &mut timer.file);
        plain.chain(timers).chain(self.ports.iter_mut().map(|port| &mut port.file))
    }

    /// The first cycle in which something happens by itself.
    pub fn next_event(&self) -> u64 {
        let now_ps = self.time.now_ps();
        let by_time = [self.iwdg.bites_ps(), self.can.next_ps(now_ps)].into_iter().flatten().min();
        let by_time = by_time.map(|ps| self.time.cycle_at(ps).max(self.time.cycles + 1));
        by_time.into_iter().chain(self.systick.next()).min().unwrap_or(u64::MAX)
    }

    /// What has become due happens.
    pub fn advance(&mut self) {
        if self.systick.advance(self.time.cycles) {
            self.nvic.pend(exception::SYS_TICK);
        }
        let now_ps = self.time.now_ps();
        self.flash.advance(now_ps);
        if self.iwdg.bites_ps().is_some_and(|at| now_ps >= at) {
            self.reset = Some(Cause::Watchdog);
        }
        if self.can.next_ps(now_ps).is_some_and(|at| now_ps >= at) {
            let pins = self.can_pins();
            let (can, mut env) = (
                &mut self.can,
                Env { now_ps, clocks: self.supply.clocks, breaches: &mut self.breaches, nvic: &mut self.nvic },
            );
            can.advance(pins, &mut env);
        }
    }

    /// The controller's two pins: PA11 and PA12.
    fn can_pins(&self) -> Pins {
        let port = &self.ports[0];
        let connected = [11, 12].iter().all(|pin| port.mode(*pin) == Mode::Alternate(9));
        Pins { connected, receive: port.held(11), transmit: port.held(12) }
    }

    /// An interrupt handler has returned: what still asks for the interrupt gets it again.
    pub fn leave_exception(&mut self) {
        self.nvic.leave();
        let file = &self.can.file;
        let at = |name| file.at(file.offset(name));
        if at("IR") & at("IE") != 0 && file.is("ILE", "EINT0") {
            self.nvic.pend_line(21);
        }
    }

    /// The six encoders turn by so many counts, each level lasting so long.
    ///
    /// # Errors
    /// A timer is not set up to count.
    pub fn turn(&mut self, counts: [i32; 6], level_ps: u64) -> Result<(), String> {
        for (timer, counts) in self.timers.iter_mut().zip(counts) {
            let clocks = self.supply.clocks;
            let hz = if timer.on_apb2 { clocks.apb2_timers } else { clocks.apb1_timers };
            let is_on = self.rcc.clock_of(timer.file.name, self.time.cycles).is_some_and(|(is_on, _)| is_on);
            if counts != 0 && is_on {
                timer.turn(counts, level_ps, hz, &self.ports)?;
            }
        }
        Ok(())
    }

    /// A word of the program could not be corrected when it was fetched.
    pub fn spoil_program_word(&mut self, address: u32) {
        self.flash.note_bad_word(address & 0x3_FFFF, false);
        self.nvic.pend(exception::NMI);
    }

    /// The clocks now.
    pub fn clocks(&self) -> crate::peripheral::clocks::Clocks {
        self.supply.clocks
    }

    /// Clocks, voltage and wait states may have changed.
    pub(crate) fn follow_supply(&mut self) {
        let now = supply(&self.rcc, &self.pwr, &self.flash);
        if now != self.supply {
            let now_ps = self.time.now_ps();
            now.check(&self.supply, now_ps, &mut self.switched_ps, &mut self.breaches);
            if now.clocks.ahb != self.supply.clocks.ahb {
                self.time.set_hz(now.clocks.ahb);
            }
            self.supply = now;
        }
    }

    pub(crate) fn with_env<T>(&mut self, act: impl FnOnce(&mut Self, &mut Env) -> T) -> T {
        let (mut breaches, mut nvic) = (std::mem::take(&mut self.breaches), std::mem::take(&mut self.nvic));
        let mut env =
            Env { now_ps: self.time.now_ps(), clocks: self.supply.clocks, breaches: &mut breaches, nvic: &mut nvic };
        let result = act(self, &mut env);
        (self.breaches, self.nvic) = (breaches, nvic);
        result
    }
}

/// Clocks, voltage and wait states as the registers have them.
fn supply(rcc: &Rcc, pwr: &Plain, flash: &Flash) -> Supply {
    Supply { clocks: rcc.clocks(), boost: !pwr.file.is("CR5", "R1MODE"), wait_states: flash.file.get("ACR", "LATENCY") }
}

/// The second bank lies where the map says.
const _: () = assert!(BANK_2 + BANK_LEN == 0x0808_0000);
