//! What an instruction costs more or less for the one before it: ARM DDI 0439, "Cortex-M4 Technical Reference Manual", sections
//! 3.3.3 (load and store pairings) and table 7-1 (a result that is used at once).
//!
//! Within a block only: a branch fills the pipeline anew.

use super::timing::Instruction;

/// Data-processing instructions of the floating-point unit, whose result is ready one cycle late.
const ARITHMETIC: [&str; 14] = [
    "vadd", "vsub", "vmul", "vnmul", "vdiv", "vsqrt", "vcvt", "vmla", "vmls", "vnmla", "vnmls", "vfma", "vfms", "vfnm",
];
/// Those that take their addend, which is also their result, a cycle later than the factors.
const ACCUMULATING: [&str; 7] = ["vmla", "vmls", "vnmla", "vnmls", "vfma", "vfms", "vfnm"];

/// Adds and takes away the cycles of each instruction that it owes to the one before it.
pub fn adjust(block: &mut [Instruction]) {
    for index in 0..block.len() {
        let (before, rest) = block.split_at_mut(index);
        let Some(one) = rest.first_mut() else { return };
        if is_store_at_constant(one) {
            one.cycles = 1;
        }
        let Some(before) = before.last() else { continue };
        if uses_result_at_once(before, one) || address_waits(before, one) {
            one.cycles += 1;
        } else if is_single(before, "ldr") && is_transfer(one) && one.cycles > 1 && !is_in_address(before, one) {
            // The address of the second goes out while the first's data come in.
            one.cycles -= 1;
        }
    }
}

/// The result of floating-point arithmetic is an operand of the next instruction.
fn uses_result_at_once(before: &Instruction, one: &Instruction) -> bool {
    if !starts_with(before, &ARITHMETIC) || !one.mnemonic.starts_with('v') {
        return false;
    }
    let Some(result) = registers(&before.operands).next() else { return false };
    let is_load = one.mnemonic.starts_with("vldr") || one.mnemonic.starts_with("vldm");
    // What is only written, and an addend, come first.
    let reads_first = one.mnemonic.starts_with("vstr") || one.mnemonic.starts_with("vcmp");
    let skipped = usize::from(!reads_first || starts_with(one, &ACCUMULATING));
    !is_load && registers(&one.operands).skip(skipped).any(|register| register == result)
}

/// The address of a load or store was computed by the instruction before it.
fn address_waits(before: &Instruction, one: &Instruction) -> bool {
    let transfers = ["ldr", "str", "vldr", "vstr", "ldm", "stm", "vldm", "vstm", "push", "pop"];
    let computes = !starts_with(before, &transfers) && !before.mnemonic.starts_with(['v', 'b', 'c', 'i', 't']);
    computes && is_any_transfer(one) && is_in_address(before, one)
}

/// The result of one instruction is part of the address of the next.
fn is_in_address(before: &Instruction, one: &Instruction) -> bool {
    registers(&before.operands).next().is_some_and(|result| address(one).any(|register| register == result))
}

fn is_any_transfer(one: &Instruction) -> bool {
    is_transfer(one) || one.mnemonic.starts_with("vldr") || one.mnemonic.starts_with("vstr")
}

/// A load or store of one word, half-word or byte.
fn is_transfer(one: &Instruction) -> bool {
    is_single(one, "ldr") || is_single(one, "str")
}

fn is_single(one: &Instruction, name: &str) -> bool {
    one.mnemonic.starts_with(name) && !one.mnemonic.starts_with("ldrd") && !one.mnemonic.starts_with("strd")
}

/// A store whose address is a register and a constant leaves its data to the next cycle's bus.
fn is_store_at_constant(one: &Instruction) -> bool {
    is_single(one, "str") && one.operands.contains('[') && address(one).count() == 1
}

fn address(one: &Instruction) -> impl Iterator<Item = &str> {
    registers(one.operands.split_once('[').map_or("", |(_, address)| address))
}

fn starts_with(one: &Instruction, names: &[&str]) -> bool {
    names.iter().any(|name| one.mnemonic.starts_with(name))
}

/// The registers that operands name, in their order.
fn registers(operands: &str) -> impl Iterator<Item = &str> {
    let is_register = |word: &&str| {
        let number = word.trim_start_matches(['r', 's', 'd']);
        matches!(*word, "sp" | "lr" | "ip" | "fp" | "sl" | "sb" | "pc")
            || number.len() + 1 == word.len() && number.parse::<u8>().is_ok()
    };
    operands.split(|c: char| !c.is_ascii_alphanumeric()).filter(is_register)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cycles::timing;

    fn cycles(block: &[(&str, &str)]) -> u64 {
        let read = |(mnemonic, operands): &(&str, &str)| Instruction {
            address: 0,
            bytes: 4,
            mnemonic: (*mnemonic).to_owned(),
            operands: (*operands).to_owned(),
            cycles: timing::cycles(mnemonic, operands),
        };
        let mut block: Vec<Instruction> = block.iter().map(read).collect();
        adjust(&mut block);
        block.iter().map(|one| one.cycles).sum()
    }

    /// Section 3.3.3 of the manual, with its totals.
    #[test]
    fn loads_that_do_not_wait_for_each_other_overlap() {
        assert_eq!(cycles(&[("ldr", "r0, [r1]"), ("ldr", "r1, [r2]")]), 3);
        assert_eq!(cycles(&[("ldr.w", "r0, [r1, r2]"), ("str.w", "r0, [r3, #20]")]), 3);
        assert_eq!(cycles(&[("ldr.w", "r0, [r1, r2]"), ("str.w", "r1, [r3, r2]")]), 3);
        assert_eq!(cycles(&[("ldr.w", "r0, [r1, r5]"), ("ldr", "r1, [r2]"), ("ldr", "r2, [r3, #4]")]), 4);
        assert_eq!(cycles(&[("str", "r0, [r1, #4]"), ("mov", "r0, r2")]), 2);
    }

    #[test]
    fn an_address_that_was_just_computed_or_loaded_is_waited_for() {
        assert_eq!(cycles(&[("add.w", "r1, r1, r2"), ("ldr", "r0, [r1]")]), 4);
        assert_eq!(cycles(&[("add.w", "r3, r1, r2"), ("ldr", "r0, [r1]")]), 3);
        assert_eq!(cycles(&[("ldr", "r1, [r0]"), ("ldr", "r2, [r1]")]), 4);
        assert_eq!(cycles(&[("adds", "r1, #4"), ("vldr", "s0, [r1]")]), 4);
    }

    #[test]
    fn a_result_of_floating_point_that_is_used_at_once_takes_a_cycle_more() {
        assert_eq!(cycles(&[("vmul.f32", "s0, s1, s2"), ("vadd.f32", "s3, s3, s0")]), 3);
        assert_eq!(cycles(&[("vmul.f32", "s0, s1, s2"), ("vadd.f32", "s3, s3, s4")]), 2);
        assert_eq!(cycles(&[("vmul.f32", "s0, s1, s2"), ("vstr", "s0, [r0]")]), 4);
        // Only written.
        assert_eq!(cycles(&[("vmul.f32", "s0, s1, s2"), ("vmul.f32", "s0, s3, s4")]), 2);
        // As an addend it is wanted a cycle later.
        assert_eq!(cycles(&[("vmul.f32", "s0, s1, s2"), ("vmla.f32", "s0, s3, s4")]), 4);
        assert_eq!(cycles(&[("vmul.f32", "s0, s1, s2"), ("vmla.f32", "s3, s0, s4")]), 5);
        // Loads are through in time.
        assert_eq!(cycles(&[("vldr", "s0, [r0]"), ("vadd.f32", "s1, s1, s0")]), 3);
    }
}
