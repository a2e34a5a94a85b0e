//! A port of sixteen pins.

use super::Env;
use crate::breach::Rule;
use crate::register_file::RegisterFile;

/// What a wire does to a pin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wire {
    /// Nothing: the pin's own pull decides.
    Open,
    /// It is held low.
    Low,
    /// It is held high.
    High,
}

/// What a pin does, as its mode register says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// It reads.
    Input,
    /// It drives.
    Output,
    /// A peripheral has it, by this function.
    Alternate(u32),
    /// It is disconnected.
    Analog,
}

/// The port.
#[derive(Debug, Clone)]
pub struct Gpio {
    /// Its registers.
    pub file: RegisterFile,
    wires: [Wire; 16],
    /// Pins whose wiring is at fault: whatever is connected to them, this is what they get.
    pub faults: [Option<Wire>; 16],
}

impl Gpio {
    /// As a reset leaves it, with nothing connected.
    pub fn new(name: &'static str) -> Self {
        Self { file: RegisterFile::new(name), wires: [Wire::Open; 16], faults: [None; 16] }
    }

    /// Connects a pin.
    pub fn connect(&mut self, pin: usize, wire: Wire) {
        self.wires[pin] = wire;
    }

    /// What a pin does.
    pub fn mode(&self, pin: u32) -> Mode {
        let of =
            |register: &str, bit: u32, width: u32| self.file.at(self.file.offset(register)) >> bit & ((1 << width) - 1);
        match of("MODER", 2 * pin, 2) {
            0 => Mode::Input,
            1 => Mode::Output,
            2 if pin < 8 => Mode::Alternate(of("AFRL", 4 * pin, 4)),
            2 => Mode::Alternate(of("AFRH", 4 * (pin - 8), 4)),
            _ => Mode::Analog,
        }
    }

    /// The pin's pull-up is on.
    pub fn is_pulled_up(&self, pin: u32) -> bool {
        self.file.at(self.file.offset("PUPDR")) >> (2 * pin) & 3 == 1
    }

    /// The level of a pin whose wiring is at fault; None while what is connected to it decides.
    pub fn held(&self, pin: u32) -> Option<bool> {
        self.faults[pin as usize].map(|_| self.level(pin, None))
    }

    /// The level that a pin has: a wire that is stuck is stronger than an output.
    pub fn level(&self, pin: u32, breaches: Option<&mut crate::breach::Breaches>) -> bool {
        let drives = self.file.at(self.file.offset("ODR")) >> pin & 1 == 1;
        let pulled = self.file.at(self.file.offset("PUPDR")) >> (2 * pin) & 3;
        let fault = self.faults[pin as usize];
        match (self.mode(pin), fault.unwrap_or(self.wires[pin as usize]), pulled) {
            (Mode::Output, wire, _) if fault.is_none() || wire == Wire::Open => drives,
            (_, Wire::High, _) | (_, Wire::Open, 1) => true,
            (_, Wire::Low, _) | (_, Wire::Open, 2) => false,
            (mode, Wire::Open, _) => {
                if let (Mode::Input, Some(breaches)) = (mode, breaches) {
                    breaches.add(Rule::NotSetUp, format!("{}: pin {pin} is read and floats", self.file.name));
                }
                false
            }
        }
    }

    /// Reads a register.
    pub fn read(&mut self, offset: u32) -> u32 {
        if self.file.name_at(offset) == Some("IDR") {
            return (0..16).filter(|pin| self.level(*pin, None)).fold(0, |levels, pin| levels | 1 << pin);
        }
        self.file.at(offset)
    }

    /// Writes a register.
    pub fn write(&mut self, offset: u32, value: u32, env: &mut Env) {
        let odr = self.file.offset("ODR");
        let levels = self.file.at(odr);
        match self.file.name_at(offset) {
            // what is set and reset at once is set
            Some("BSRR") => self.file.put_at(odr, levels & !(value >> 16) | value & 0xFFFF),
            Some("BRR") => self.file.put_at(odr, levels & !value),
            Some("IDR") => env.breaches.add(Rule::ReadOnly, format!("{}.IDR", self.file.name)),
            _ => self.file.write(offset, value, env.breaches),
        }
    }
}
