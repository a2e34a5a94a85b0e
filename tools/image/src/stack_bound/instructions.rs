//! The few instructions that matter to the stack: those that take from the stack pointer, and those that go elsewhere.
//!
//! Source: "ARMv7-M Architecture Reference Manual" (DDI 0403E), A5 (encodings) and A7.7 (each instruction).

/// What an instruction does, as far as it matters here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Instruction {
    /// Takes so many bytes off the stack pointer.
    Takes(u64),
    /// Puts a computed value into the stack pointer.
    ComputesStackPointer,
    /// Goes to this address, and may come back.
    GoesTo(u64),
    /// Goes to an address in a register or in memory, and may come back.
    GoesAnywhere,
    /// Puts the lower half of a constant into a register.
    LowerHalf {
        /// The register.
        register: u8,
        /// Bits 0 to 15.
        value: u16,
    },
    /// Puts the upper half of a constant into a register.
    UpperHalf {
        /// The register.
        register: u8,
        /// Bits 16 to 31.
        value: u16,
    },
    /// Lets in no interrupt from here on: CPSID i, T1.
    MasksInterrupts,
    /// Anything else.
    Other,
}

use Instruction::{ComputesStackPointer, GoesAnywhere, GoesTo, LowerHalf, MasksInterrupts, Other, Takes, UpperHalf};

/// Bytes of the instruction that begins with this half-word (A5.1).
pub const fn len(first: u16) -> u64 {
    if first >> 11 >= 0b11101 { 4 } else { 2 }
}

/// The instruction at an address. `second` is of no meaning to an instruction of one half-word.
pub fn decode(address: u64, first: u16, second: u16) -> Instruction {
    if len(first) == 2 { narrow(address, first) } else { wide(address, first, second) }
}

fn narrow(address: u64, code: u16) -> Instruction {
    let register = code >> 3 & 0xF;
    match code {
        // PUSH T1: low registers and, bit 8, the link register
        _ if code & 0xFE00 == 0xB400 => Takes(4 * u64::from((code & 0x1FF).count_ones())),
        0xB672 => MasksInterrupts,
        // SUB (SP minus immediate) T1
        _ if code & 0xFF80 == 0xB080 => Takes(4 * u64::from(code & 0x7F)),
        // MOV T1 and ADD (register) T2 into register 13
        _ if code & 0xFF87 == 0x4685 || code & 0xFF87 == 0x4485 => ComputesStackPointer,
        // BLX, and BX but to the link register, which returns
        _ if code & 0xFF87 == 0x4780 => GoesAnywhere,
        _ if code & 0xFF87 == 0x4700 && register != 14 => GoesAnywhere,
        // MOV T1 into register 15
        _ if code & 0xFF87 == 0x4687 => GoesAnywhere,
        // B T1, whose conditions 14 and 15 are other instructions; B T2
        _ if code & 0xF000 == 0xD000 && code >> 8 & 0xF < 14 => branch(address, i64::from(code as u8 as i8) * 2),
        _ if code & 0xF800 == 0xE000 => branch(address, signed(u32::from(code & 0x7FF), 11) * 2),
        _ => Other,
    }
}

fn wide(address: u64, first: u16, second: u16) -> Instruction {
    let (one, two) = (u32::from(first), u32::from(second));
    // i:imm3:imm8
    let twelve = (one >> 10 & 1) << 11 | (two >> 12 & 7) << 8 | two & 0xFF;
    let into_stack_pointer = two & 0x8F00 == 0x0D00;
    match (first, second) {
        // PUSH T2 (STMDB SP!)
        (0xE92D, list) => Takes(4 * u64::from(list.count_ones())),
        // STR T4 and STRD T1 before the stack pointer, which moves: PUSH T3 is one of them
        (0xF84D, _) if two & 0x0F00 == 0x0D00 => Takes(u64::from(two & 0xFF)),
        (0xE96D, _) => Takes(4 * u64::from(two & 0xFF)),
        // VPUSH T1 (double) and T2 (single precision): the immediate counts words either way
        _ if one & 0xFFBF == 0xED2D && matches!(two & 0x0F00, 0x0A00 | 0x0B00) => Takes(4 * u64::from(two & 0xFF)),
        // SUB (SP minus immediate) T2 and T3
        _ if one & 0xFBEF == 0xF1AD && into_stack_pointer => Takes(u64::from(expand(twelve))),
        _ if one & 0xFBFF == 0xF2AD && into_stack_pointer => Takes(u64::from(twelve)),
        // ADD (SP plus immediate) T3 and T4 give back
        _ if matches!(one & 0xFBEF, 0xF10D) && into_stack_pointer => Other,
        _ if one & 0xFBFF == 0xF20D && into_stack_pointer => Other,
        // other arithmetic into register 13 (A5.3.1, A5.3.3, A5.3.11), a load of it (A5.3.7), MSR into MSP or PSP
        _ if one & 0xF800 == 0xF000 && into_stack_pointer => ComputesStackPointer,
        _ if one & 0xFE00 == 0xEA00 && two & 0x0F00 == 0x0D00 => ComputesStackPointer,
        _ if one & 0xFF70 == 0xF850 && two & 0xF000 == 0xD000 => ComputesStackPointer,
        _ if one & 0xFFF0 == 0xF380 && matches!(two, 0x8808 | 0x8809) => ComputesStackPointer,
        // MOV (immediate) T3, MOVT
        _ if one & 0xFBF0 == 0xF240 && two & 0x8000 == 0 => {
            LowerHalf { register: register(two), value: half(one, twelve) }
        }
        _ if one & 0xFBF0 == 0xF2C0 && two & 0x8000 == 0 => {
            UpperHalf { register: register(two), value: half(one, twelve) }
        }
        // BL and B T4
        _ if one & 0xF800 == 0xF000 && matches!(two & 0xD000, 0xD000 | 0x9000) => branch(address, far(one, two)),
        // B T3, whose conditions 14 and 15 are other instructions
        _ if one & 0xF800 == 0xF000 && two & 0xD000 == 0x8000 && one >> 6 & 0xF < 14 => {
            branch(address, conditional(one, two))
        }
        // LDR into register 15; from the stack, moving its pointer, it returns (POP T3)
        (0xF85D, 0xFB04) => Other,
        _ if one & 0xFF70 == 0xF850 && two & 0xF000 == 0xF000 => GoesAnywhere,
        // LDM with register 15 in the list, but from the stack, which is POP and returns
        _ if one & 0xFFD0 == 0xE890 && one & 0xF != 13 && two & 0x8000 != 0 => GoesAnywhere,
        _ => Other,
    }
}

fn register(second: u32) -> u8 {
    (second >> 8 & 0xF) as u8
}

/// imm4:i:imm3:imm8 of MOV T3 and MOVT.
fn half(first: u32, twelve: u32) -> u16 {
    ((first & 0xF) << 12 | twelve) as u16
}

/// The program counter is four bytes ahead.
fn branch(address: u64, offset: i64) -> Instruction {
    GoesTo((address + 4).wrapping_add_signed(offset))
}

/// The lowest bits as a number in two's complement.
fn signed(value: u32, bits: u32) -> i64 {
    i64::from((value << (32 - bits)).cast_signed() >> (32 - bits))
}

/// S:I1:I2:imm10:imm11:0 of BL and B T4.
fn far(first: u32, second: u32) -> i64 {
    let sign = first >> 10 & 1;
    let [bit_23, bit_22] = [second >> 13 & 1, second >> 11 & 1].map(|j| !(j ^ sign) & 1);
    signed(sign << 23 | bit_23 << 22 | bit_22 << 21 | (first & 0x3FF) << 11 | second & 0x7FF, 24) * 2
}

/// S:J2:J1:imm6:imm11:0 of B T3.
fn conditional(first: u32, second: u32) -> i64 {
    let (sign, j1, j2) = (first >> 10 & 1, second >> 13 & 1, second >> 11 & 1);
    signed(sign << 19 | j2 << 18 | j1 << 17 | (first & 0x3F) << 11 | second & 0x7FF, 20) * 2
}

/// ThumbExpandImm (A5.3.2).
fn expand(twelve: u32) -> u32 {
    let byte = twelve & 0xFF;
    match twelve >> 8 {
        0 => byte,
        1 => byte << 16 | byte,
        2 => byte << 24 | byte << 8,
        3 => byte << 24 | byte << 16 | byte << 8 | byte,
        _ => (0x80 | twelve & 0x7F).rotate_right(twelve >> 7),
    }
}

#[cfg(test)]
mod tests;
