//! The driver's description: `stm32-metapac`'s own tables.

use crate::{Bits, Block};
use stm32_metapac::metadata::ir::{Array, BitOffset, BlockItemInner, Field, IR};
use stm32_metapac::metadata::{METADATA, PeripheralRegisters};

/// The registers of the peripheral of this name; None if the description has no such peripheral.
pub fn block(name: &str) -> Option<Block> {
    let peripheral = METADATA.peripherals.iter().find(|peripheral| peripheral.name == name)?;
    let registers: &PeripheralRegisters = peripheral.registers.as_ref()?;
    let mut block = Block::new();
    add(&mut block, registers.ir, registers.block, 0);
    Some(block)
}

/// The address of the peripheral of this name.
pub fn address(name: &str) -> Option<u32> {
    METADATA.peripherals.iter().find(|peripheral| peripheral.name == name).map(|found| found.address as u32)
}

/// Adds the registers of the block `name`, which begins at `from`.
fn add(block: &mut Block, ir: &IR, name: &str, from: u32) {
    let Some(described) = ir.blocks.iter().find(|block| is_same(block.name, name)) else { return };
    if let Some(base) = described.extends {
        add(block, ir, base, from);
    }
    for item in described.items {
        for (index, offset) in places(item.array.as_ref()).into_iter().enumerate() {
            let at = from + item.byte_offset + offset;
            match &item.inner {
                BlockItemInner::Block(inner) => add(block, ir, inner.block, at),
                BlockItemInner::Register(register) => {
                    let entry = block.entry(at).or_default();
                    if entry.name.is_empty() {
                        entry.name = match item.array {
                            Some(_) => format!("{}{index}", item.name.to_uppercase()),
                            None => item.name.to_uppercase(),
                        };
                    }
                    match register.fieldset {
                        Some(set) => add_fields(entry, ir, set),
                        None => add_field(entry, Bits { from: 0, width: register.bit_size }, item.name),
                    }
                }
            }
        }
    }
}

fn add_fields(register: &mut crate::Register, ir: &IR, set: &str) {
    let Some(described) = ir.fieldsets.iter().find(|fields| is_same(fields.name, set)) else { return };
    if let Some(base) = described.extends {
        add_fields(register, ir, base);
    }
    for field in described.fields {
        for (index, offset) in places(field.array.as_ref()).into_iter().enumerate() {
            let name = if field.array.is_some() { format!("{}{index}", field.name) } else { field.name.to_owned() };
            for bits in bits_of(field, offset) {
                add_field(register, bits, &name);
            }
        }
    }
}

/// A field's bits; one that is scattered over a register has several runs of them.
fn bits_of(field: &Field, offset: u32) -> Vec<Bits> {
    match &field.bit_offset {
        BitOffset::Regular(at) => vec![Bits { from: at.offset + offset, width: field.bit_size }],
        BitOffset::Cursed(at) => at
            .ranges
            .iter()
            .map(|range| Bits { from: range.start() + offset, width: range.end() - range.start() + 1 })
            .collect(),
    }
}

fn add_field(register: &mut crate::Register, bits: Bits, name: &str) {
    register.fields.entry(bits).or_default().insert(name.to_uppercase());
}

/// Distances of the elements of an array from its first one; 0 for what is none.
fn places(array: Option<&Array>) -> Vec<u32> {
    match array {
        None => vec![0],
        Some(Array::Regular(array)) => (0..array.len).map(|index| index * array.stride).collect(),
        Some(Array::Cursed(array)) => array.offsets.to_vec(),
    }
}

/// The tables spell one name in two ways: `TIM_ADV` and `TimAdv`.
fn is_same(one: &str, other: &str) -> bool {
    let letters = |name: &str| name.replace('_', "").to_uppercase();
    letters(one) == letters(other)
}
