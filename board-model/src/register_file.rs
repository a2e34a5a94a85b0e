//! The registers of one peripheral: reset values and defined bits as ST describes them, fields by name.

use crate::breach::{Breaches, Rule};
use registers::{Bits, Block, PERIPHERALS, mask, vendor};
use std::collections::BTreeMap;
use std::sync::OnceLock;

/// What ST says of every peripheral that the image touches.
static DESCRIPTIONS: OnceLock<BTreeMap<&'static str, Block>> = OnceLock::new();

fn description(peripheral: &str) -> &'static Block {
    let all = DESCRIPTIONS.get_or_init(|| {
        let folder = vendor::folder().unwrap_or_else(|error| panic!("the vendor's description: {error}"));
        let read = |block| vendor::block(&folder, block).unwrap_or_else(|error| panic!("{block}: {error}"));
        PERIPHERALS.iter().map(|peripheral| (peripheral.name, read(peripheral.block))).collect()
    });
    all.get(peripheral).unwrap_or_else(|| panic!("no description of {peripheral}"))
}

/// Registers and what they hold.
#[derive(Debug, Clone)]
pub struct RegisterFile {
    /// The peripheral's name.
    pub name: &'static str,
    described: &'static Block,
    values: BTreeMap<u32, u32>,
}

impl RegisterFile {
    /// The registers as a reset leaves them.
    pub fn new(name: &'static str) -> Self {
        let mut file = Self { name, described: description(name), values: BTreeMap::new() };
        file.reset();
        file
    }

    /// Puts the reset values back.
    pub fn reset(&mut self) {
        self.values = self.described.iter().map(|(at, register)| (*at, register.reset.unwrap_or(0))).collect();
    }

    /// The register at this distance: its name; none if there is none.
    pub fn name_at(&self, offset: u32) -> Option<&'static str> {
        self.described.get(&offset).map(|register| register.name.as_str())
    }

    /// What the register at this distance holds.
    pub fn at(&self, offset: u32) -> u32 {
        self.values.get(&offset).copied().unwrap_or(0)
    }

    /// Changes the register at this distance, whatever the rules.
    pub fn put_at(&mut self, offset: u32, value: u32) {
        self.values.insert(offset, value);
    }

    /// Changes the register at this distance as the firmware asks for: bits that no field has stay, and asking for
    /// another value of them is a breach.
    pub fn write(&mut self, offset: u32, value: u32, breaches: &mut Breaches) {
        let Some(register) = self.described.get(&offset) else { return };
        let (before, defined) = (self.at(offset), register.defined());
        let reserved = (before ^ value) & !defined;
        if reserved != 0 {
            breaches.add(Rule::ReservedBit, format!("{}.{}: bits {reserved:#x}", self.name, register.name));
        }
        self.values.insert(offset, value & defined | before & !defined);
    }

    /// The distance of a register.
    pub fn offset(&self, register: &str) -> u32 {
        let found = self.described.iter().find(|(_, described)| described.name == register);
        *found.unwrap_or_else(|| panic!("{} has no register {register}", self.name)).0
    }

    /// Where a field lies.
    pub fn bits(&self, register: &str, field: &str) -> (u32, Bits) {
        let offset = self.offset(register);
        let found = self.described[&offset].fields.iter().find(|(_, names)| names.contains(field));
        (offset, *found.unwrap_or_else(|| panic!("{}.{register} has no field {field}", self.name)).0)
    }

    /// What a field holds.
    pub fn get(&self, register: &str, field: &str) -> u32 {
        let (offset, bits) = self.bits(register, field);
        (self.at(offset) & mask(bits)) >> bits.from
    }

    /// A field is not 0.
    pub fn is(&self, register: &str, field: &str) -> bool {
        self.get(register, field) != 0
    }

    /// Changes a field, whatever the rules.
    pub fn put(&mut self, register: &str, field: &str, value: u32) {
        let (offset, bits) = self.bits(register, field);
        let kept = self.at(offset) & !mask(bits);
        self.values.insert(offset, kept | value << bits.from & mask(bits));
    }

    /// What a field would hold if its register held `value`.
    pub fn field_of(&self, value: u32, register: &str, field: &str) -> u32 {
        let (_, bits) = self.bits(register, field);
        (value & mask(bits)) >> bits.from
    }
}
