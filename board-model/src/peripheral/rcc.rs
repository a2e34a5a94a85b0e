//! Reset and clock control.

use super::Env;
use super::clocks::Clocks;
use crate::breach::Rule;
use crate::register_file::RegisterFile;
use crate::time::{PS_A_MS, PS_A_US};
use std::collections::BTreeMap;

/// The chip's own oscillator, Hz.
pub const HSI_HZ: u32 = 16_000_000;
/// The board's crystal, Hz.
pub const HSE_HZ: u32 = 24_000_000;
/// A crystal takes so long to start (STM32G474 datasheet, HSE characteristics: 2 ms).
const HSE_START_PS: u64 = 2 * PS_A_MS;
/// The PLL takes so long to lock (datasheet, PLL characteristics: 15 to 40 us).
const PLL_LOCK_PS: u64 = 40 * PS_A_US;

/// Where a peripheral's clock is switched on, and where it is reset: register and the field without EN or RST.
const SWITCHES: [(&str, &str, &str, &str); 14] = [
    ("TIM1", "APB2ENR", "APB2RSTR", "TIM1"),
    ("TIM2", "APB1ENR1", "APB1RSTR1", "TIM2"),
    ("TIM3", "APB1ENR1", "APB1RSTR1", "TIM3"),
    ("TIM4", "APB1ENR1", "APB1RSTR1", "TIM4"),
    ("TIM5", "APB1ENR1", "APB1RSTR1", "TIM5"),
    ("TIM8", "APB2ENR", "APB2RSTR", "TIM8"),
    ("FDCAN1", "APB1ENR1", "APB1RSTR1", "FDCAN"),
    ("PWR", "APB1ENR1", "APB1RSTR1", "PWR"),
    ("SYSCFG", "APB2ENR", "APB2RSTR", "SYSCFG"),
    ("FLASH", "AHB1ENR", "AHB1RSTR", "FLASH"),
    ("GPIOA", "AHB2ENR", "AHB2RSTR", "GPIOA"),
    ("GPIOB", "AHB2ENR", "AHB2RSTR", "GPIOB"),
    ("GPIOC", "AHB2ENR", "AHB2RSTR", "GPIOC"),
    ("CRC", "AHB1ENR", "AHB1RSTR", "CRC"),
];

/// Why the chip was reset: the flag of CSR.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    /// The supply came on.
    Power,
    /// The reset pin.
    Pin,
    /// The program asked for it.
    Software,
    /// The independent watchdog.
    Watchdog,
    /// The option bytes were loaded anew.
    OptionBytes,
    /// The window watchdog.
    WindowWatchdog,
    /// A low-power mode was forbidden.
    LowPower,
}

impl Cause {
    fn flag(self) -> &'static str {
        match self {
            Self::Power => "BORRSTF",
            Self::Pin => "PINRSTF",
            Self::Software => "SFTRSTF",
            Self::Watchdog => "IWDGRSTF",
            Self::OptionBytes => "OBLRSTF",
            Self::WindowWatchdog => "WWDGRSTF",
            Self::LowPower => "LPWRRSTF",
        }
    }
}

/// The peripheral.
#[derive(Debug, Clone)]
pub struct Rcc {
    /// Its registers.
    pub file: RegisterFile,
    /// The board has a crystal that starts.
    pub crystal: bool,
    /// When an oscillator or the PLL will be ready.
    ready_ps: BTreeMap<&'static str, u64>,
    /// When each clock was switched on, in cycles.
    enabled_at: BTreeMap<&'static str, u64>,
}

impl Rcc {
    /// As a reset leaves it.
    pub fn new() -> Self {
        let file = RegisterFile::new("RCC");
        Self { file, crystal: true, ready_ps: BTreeMap::new(), enabled_at: BTreeMap::new() }
    }

    /// A reset of the chip: the flags of earlier ones stay until they are cleared, but for one of the supply.
    pub fn reset(&mut self, cause: Cause) {
        let flags = if cause == Cause::Power { 0 } else { self.file.at(self.file.offset("CSR")) & 0xFE00_0000 };
        self.file.reset();
        let csr = self.file.offset("CSR");
        self.file.put_at(csr, flags);
        self.file.put("CSR", cause.flag(), 1);
        // every reset pulls the pin
        self.file.put("CSR", "PINRSTF", 1);
        self.ready_ps.clear();
        self.enabled_at.clear();
    }

    /// Reads a register.
    pub fn read(&mut self, offset: u32, env: &Env) -> u32 {
        for (from, ready) in [("HSION", "HSIRDY"), ("HSEON", "HSERDY"), ("PLLON", "PLLRDY")] {
            let is_ready = self.file.is("CR", from) && self.ready_ps.get(ready).is_none_or(|at| env.now_ps >= *at);
            self.file.put("CR", ready, is_ready.into());
        }
        self.file.put("CFGR", "SWS", self.file.get("CFGR", "SW"));
        let lsi = self.file.get("CSR", "LSION");
        self.file.put("CSR", "LSIRDY", lsi);
        self.file.at(offset)
    }

    /// Writes a register; gives the peripherals that it resets.
    pub fn write(&mut self, offset: u32, value: u32, cycle: u64, env: &mut Env) -> Vec<&'static str> {
        let name = self.file.name_at(offset).unwrap_or_default();
        let before = self.file.at(offset);
        match name {
            "CR" => self.start(value, env),
            "PLLCFGR" if self.file.is("CR", "PLLON") && value != before => {
                // its outputs may be switched, its factors not
                let outputs = 0x0111_0000;
                if (value ^ before) & !outputs != 0 {
                    env.breaches.add(Rule::PllRunning, "RCC.PLLCFGR while the PLL is on");
                }
            }
            "CFGR" => self.check_selected(value, env),
            "CSR" if self.file.field_of(value, "CSR", "RMVF") != 0 => {
                self.file.put_at(offset, before & !0xFE00_0000);
                return Vec::new();
            }
            _ => {}
        }
        // flags that only the hardware sets
        let read_only = match name {
            "CR" => 0x0202_0400,
            "CFGR" => 0xC,
            "CSR" => 0xFE00_0002,
            _ => 0,
        };
        self.file.write(offset, value & !read_only | before & read_only, env.breaches);
        if name.ends_with("ENR") || name.ends_with("ENR1") {
            for (peripheral, register, _, field) in SWITCHES.iter().filter(|switch| switch.1 == name) {
                let bit = |value| self.file.field_of(value, register, &format!("{field}EN"));
                if bit(before) == 0 && bit(value) != 0 {
                    self.enabled_at.insert(peripheral, cycle);
                }
            }
        }
        let resets = SWITCHES.iter().filter(|switch| switch.2 == name);
        resets.filter(|switch| self.file.is(switch.2, &format!("{}RST", switch.3))).map(|switch| switch.0).collect()
    }

    fn start(&mut self, value: u32, env: &mut Env) {
        let mut begin = |on: &str, ready: &'static str, takes_ps: u64| {
            if self.file.field_of(value, "CR", on) != 0 && !self.file.is("CR", on) {
                self.ready_ps.insert(ready, env.now_ps.saturating_add(takes_ps));
            }
        };
        begin("HSEON", "HSERDY", if self.crystal { HSE_START_PS } else { u64::MAX });
        begin("PLLON", "PLLRDY", PLL_LOCK_PS);
        begin("HSION", "HSIRDY", 2 * PS_A_US);
        let stops_pll = self.file.is("CR", "PLLON") && self.file.field_of(value, "CR", "PLLON") == 0;
        if stops_pll && self.file.get("CFGR", "SW") == 3 {
            env.breaches.add(Rule::ClockNotReady, "the PLL is switched off while the core runs from it");
        }
    }

    fn check_selected(&mut self, value: u32, env: &mut Env) {
        let ready = match self.file.field_of(value, "CFGR", "SW") {
            1 => "HSIRDY",
            2 => "HSERDY",
            3 => "PLLRDY",
            other => {
                env.breaches.add(Rule::ClockNotReady, format!("RCC.CFGR.SW = {other}"));
                return;
            }
        };
        let cr = self.file.offset("CR");
        self.read(cr, env);
        if !self.file.is("CR", ready) {
            env.breaches.add(Rule::ClockNotReady, format!("the system clock is selected while {ready} is 0"));
        }
        if ready == "PLLRDY" && !self.file.is("PLLCFGR", "PLLREN") {
            env.breaches.add(Rule::ClockNotReady, "the PLL is selected while its output R is off");
        }
    }

    /// The peripheral's clock is on; None where there is no switch. The second: for so many cycles.
    pub fn clock_of(&self, peripheral: &str, cycle: u64) -> Option<(bool, u64)> {
        let (name, enable, _, field) = SWITCHES.iter().find(|switch| switch.0 == peripheral)?;
        let is_on = self.file.is(enable, &format!("{field}EN"));
        Some((is_on, self.enabled_at.get(name).map_or(u64::MAX, |at| cycle - at)))
    }

    /// The clocks that follow from the registers.
    pub fn clocks(&self) -> Clocks {
        let get = |register, field| self.file.get(register, field);
        let system = match get("CFGR", "SW") {
            2 => HSE_HZ,
            3 => self.pll_r_hz(),
            _ => HSI_HZ,
        };
        // 0xxx: whole; then 2, 4, 8, 16, 64, 128, 256, 512
        let ahb = match get("CFGR", "HPRE") {
            code @ 8..=11 => system >> (code - 7),
            code @ 12.. => system >> (code - 6),
            _ => system,
        };
        let apb = |code: u32| if code < 4 { 1 } else { 2 << (code - 4) };
        let (one, two) = (apb(get("CFGR", "PPRE1")), apb(get("CFGR", "PPRE2")));
        let timers = |divider: u32| if divider == 1 { ahb } else { ahb / divider * 2 };
        let fdcan = match get("CCIPR", "FDCANSEL") {
            0 => HSE_HZ,
            1 => self.vco_hz() / (2 * (get("PLLCFGR", "PLLQ") + 1)),
            _ => ahb / one,
        };
        let (apb1, apb2) = (ahb / one, ahb / two);
        Clocks { system, ahb, apb1, apb2, apb1_timers: timers(one), apb2_timers: timers(two), fdcan }
    }

    fn vco_hz(&self) -> u32 {
        let source = match self.file.get("PLLCFGR", "PLLSRC") {
            2 => HSI_HZ,
            3 => HSE_HZ,
            _ => 0,
        };
        source / (self.file.get("PLLCFGR", "PLLM") + 1) * self.file.get("PLLCFGR", "PLLN")
    }

    fn pll_r_hz(&self) -> u32 {
        // a clock that does not run would stop the core; the rule has been noted
        (self.vco_hz() / (2 * (self.file.get("PLLCFGR", "PLLR") + 1))).max(1_000_000)
    }
}

impl Default for Rcc {
    fn default() -> Self {
        Self::new()
    }
}
