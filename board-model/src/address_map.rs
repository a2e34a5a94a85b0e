//! What answers at which address of the chip, and what touching it breaks.

use crate::breach::Rule;
use crate::chip::Chip;
use crate::peripheral::flash::BANK_2;
use crate::peripheral::message_ram;
use crate::peripheral::rcc::Cause;
use crate::register_file::RegisterFile;
use registers::PERIPHERALS;

/// Length of a peripheral's window.
const WINDOW: u32 = 0x400;
/// FLASH_SR.
const FLASH_SR: u32 = 0x4002_2010;
/// Cycles that a clock must have been on (RM0440, "Peripheral clock enable register").
const CLOCK_DELAY: u64 = 2;

impl Chip {
    /// The firmware reads `size` bytes.
    pub fn read(&mut self, address: u32, size: u32) -> u32 {
        let word = address & !3;
        let value = match word {
            BANK_2..0x0808_0000 => self.with_env(|chip, env| chip.flash.load(word, env)),
            0xE000_E010..0xE000_E020 => self.systick.read(word - 0xE000_E010, self.time.cycles),
            0xE000_E100..0xE000_E500 => self.nvic.read(word - 0xE000_E100),
            0xE000_ED90..0xE000_EDB0 => self.mpu.read(word - 0xE000_ED90),
            0xE000_0000..0xE004_0000 => self.scb.read(word, self.time.cycles, &self.nvic),
            message_ram::FROM..0x4000_A800 => self.message_ram(word).map_or(0, |at| self.can.ram.read(at)),
            FLASH_SR => self.read_flash_status(word),
            _ => self.read_peripheral(word),
        };
        let stalled = self.flash.stall_until_ps;
        if stalled != 0 {
            self.time.cycles = self.time.cycles.max(self.time.cycle_at(stalled));
            self.flash.stall_until_ps = 0;
            self.flash.stalls += u32::from(self.systick.is_on());
        }
        let shifted = value >> (8 * (address & 3));
        if size == 4 { shifted } else { shifted & ((1 << (8 * size)) - 1) }
    }

    /// A loop that waits for the flash is not carried out turn by turn: the time passes at once, up to the next event.
    fn read_flash_status(&mut self, address: u32) -> u32 {
        let now_ps = self.time.now_ps();
        if let Some(until_ps) = self.flash.waits_until_ps(now_ps) {
            let until = self.time.cycle_at(until_ps).min(self.next_event());
            self.time.cycles = self.time.cycles.max(until);
            self.flash.stalls += u32::from(self.systick.is_on());
        }
        self.read_peripheral(address)
    }

    /// The firmware writes `size` bytes.
    pub fn write(&mut self, address: u32, size: u32, value: u32) {
        let cycle = self.time.cycles;
        let value = self.alter.map_or(value, |alter| alter(address, value));
        match address {
            BANK_2..0x0808_0000 => self.with_env(|chip, env| chip.flash.store(address, size, value, env)),
            0xE000_E010..0xE000_E020 => self.systick.write(address - 0xE000_E010, value, cycle),
            0xE000_E100..0xE000_E500 => self.nvic.write(address - 0xE000_E100, size, value),
            0xE000_ED90..0xE000_EDB0 => {
                self.mpu.write(address - 0xE000_ED90, value, &mut self.breaches);
                self.mpu_changed = true;
            }
            0xE000_0000..0xE004_0000 => {
                let Self { scb, nvic, breaches, .. } = self;
                if scb.write(address, (size, value), cycle, nvic, breaches) {
                    self.reset = Some(Cause::Software);
                }
            }
            message_ram::FROM..0x4000_A800 => {
                if let Some(at) = self.message_ram(address) {
                    self.can.ram.write(at, value);
                }
            }
            _ => self.write_peripheral(address, size, value),
        }
    }

    /// A word of the message RAM, if its clock is on and it is there.
    fn message_ram(&mut self, address: u32) -> Option<u32> {
        let at = address - message_ram::FROM;
        if !self.clock_is_on("FDCAN1", "message RAM") {
            return None;
        }
        if at >= message_ram::LEN {
            self.breaches.add(Rule::NoRegister, format!("message RAM of another controller: {address:#x}"));
            return None;
        }
        Some(at)
    }

    fn read_peripheral(&mut self, address: u32) -> u32 {
        let Some((name, offset)) = self.find(address) else { return 0 };
        if !self.clock_is_on(name, "read") {
            return 0;
        }
        self.with_env(|chip, env| match name {
            "RCC" => chip.rcc.read(offset, env),
            "PWR" => chip.pwr.read(offset),
            "SYSCFG" => chip.syscfg.read(offset),
            "DBGMCU" => chip.dbgmcu.read(offset),
            "FLASH" => chip.flash.read(offset, env),
            "FDCAN1" => chip.can.read(offset),
            "IWDG" => chip.iwdg.read(offset, env),
            "GPIOA" => chip.ports[0].read(offset),
            "GPIOB" => chip.ports[1].read(offset),
            "GPIOC" => chip.ports[2].read(offset),
            _ => chip.timers.iter().find(|timer| timer.file.name == name).map_or(0, |timer| timer.read(offset)),
        })
    }

    fn write_peripheral(&mut self, address: u32, size: u32, value: u32) {
        let Some((name, offset)) = self.find(address & !3) else { return };
        if !self.clock_is_on(name, "write") {
            return;
        }
        let value = if size == 4 {
            value
        } else {
            let (shift, bits) = (8 * (address & 3), (1 << (8 * size)) - 1);
            self.read_peripheral(address & !3) & !(bits << shift) | (value & bits) << shift
        };
        let cycle = self.time.cycles;
        let resets = self.with_env(|chip, env| {
            match name {
                "RCC" => return chip.rcc.write(offset, value, cycle, env),
                "PWR" => chip.pwr.write(offset, value, env),
                "SYSCFG" => chip.syscfg.write(offset, value, env),
                "DBGMCU" => chip.dbgmcu.write(offset, value, env),
                "FLASH" => chip.flash.write(offset, value, env),
                "FDCAN1" => chip.can.write(offset, value, env),
                "IWDG" => chip.iwdg.write(offset, value, env),
                "GPIOA" => chip.ports[0].write(offset, value, env),
                "GPIOB" => chip.ports[1].write(offset, value, env),
                "GPIOC" => chip.ports[2].write(offset, value, env),
                _ => {
                    if let Some(timer) = chip.timers.iter_mut().find(|timer| timer.file.name == name) {
                        timer.write(offset, value, env);
                    }
                }
            }
            Vec::new()
        });
        for name in resets {
            match name {
                "FDCAN1" => self.can.reset(),
                "FLASH" => {}
                _ => self.files().filter(|file| file.name == name).for_each(RegisterFile::reset),
            }
        }
        self.follow_supply();
    }

    /// The peripheral and the register at an address; touching what is none is a breach.
    fn find(&mut self, address: u32) -> Option<(&'static str, u32)> {
        let peripheral = PERIPHERALS.iter().find(|found| (found.from..found.from + WINDOW).contains(&address));
        let register = peripheral.and_then(|found| {
            let offset = address - found.from;
            let name = self.file_of(found.name)?.name_at(offset)?;
            Some((found.name, offset, name))
        });
        match register {
            Some((peripheral, offset, name)) => {
                self.touched.insert(format!("{peripheral}.{name}"));
                Some((peripheral, offset))
            }
            None => {
                self.breaches.add(Rule::NoRegister, format!("{address:#010x}"));
                None
            }
        }
    }

    fn file_of(&self, name: &str) -> Option<&RegisterFile> {
        let files = [
            &self.rcc.file,
            &self.pwr.file,
            &self.flash.file,
            &self.can.file,
            &self.iwdg.file,
            &self.syscfg.file,
            &self.dbgmcu.file,
        ];
        let timers = self.timers.iter().map(|timer| &timer.file);
        let all = files.into_iter().chain(timers).chain(self.ports.iter().map(|port| &port.file));
        all.into_iter().find(|file| file.name == name)
    }

    fn clock_is_on(&mut self, name: &'static str, what: &str) -> bool {
        match self.rcc.clock_of(name, self.time.cycles) {
            Some((false, _)) => {
                self.breaches.add(Rule::ClockOff, format!("{name}: {what}"));
                false
            }
            Some((true, cycles)) if cycles < CLOCK_DELAY => {
                self.breaches.add(Rule::ClockTooNew, format!("{name}: {what} {cycles} cycles behind its clock"));
                true
            }
            _ => true,
        }
    }
}
