//! What an instruction does to the stack pointer and to the flow of control; everything else it does is of no interest.
//!
//! Encodings: ARMv7-M Architecture Reference Manual (DDI 0403), A7.7.

/// Number of the stack pointer among the registers.
const SP: u16 = 13;
/// Number of the program counter.
const PC: u16 = 15;

/// An instruction's effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Effect {
    /// None that matters.
    None,
    /// The stack grows by so many bytes; shrinks when negative.
    Grow(i64),
    /// The stack pointer is set from a register: how far is not known here.
    UnknownStack,
    /// Goes on at the address; when conditional, or behind it.
    Branch(u64, bool),
    /// Calls the function at the address.
    Call(u64),
    /// Calls a function by a pointer.
    IndirectCall,
    /// Goes on somewhere by a pointer: a call whose caller is left for good.
    IndirectJump,
    /// Goes on at one of the places that the table behind the instruction lists; bytes or halfwords.
    Table(u8),
    /// The function ends here.
    Return,
    /// The next so many instructions are conditional.
    Conditional(u8),
}

/// Decodes the instruction of two halfwords (the second counts only if the instruction has it) at an address. Gives its
/// length in bytes and its effect.
pub fn decode(first: u16, second: u16, address: u64) -> (u64, Effect) {
    if first >> 11 >= 0b11101 { (4, wide(first, second, address)) } else { (2, narrow(first, address)) }
}

fn narrow(op: u16, address: u64) -> Effect {
    let words = |mask: u16| i64::from(mask.count_ones()) * 4;
    // the program counter reads as four bytes ahead
    let ahead = |offset: i64| address.wrapping_add_signed(offset + 4);
    match op {
        // PUSH T1, POP T1
        _ if op & 0xFE00 == 0xB400 => Effect::Grow(words(op & 0x1FF)),
        _ if op & 0xFF00 == 0xBD00 => Effect::Return,
        _ if op & 0xFE00 == 0xBC00 => Effect::Grow(-words(op & 0x1FF)),
        // SUB and ADD (SP plus or minus immediate)
        _ if op & 0xFF80 == 0xB080 => Effect::Grow(i64::from(op & 0x7F) * 4),
        _ if op & 0xFF80 == 0xB000 => Effect::Grow(-i64::from(op & 0x7F) * 4),
        // UDF, then B T1
        _ if op & 0xFF00 == 0xDE00 => Effect::Return,
        _ if op & 0xF000 == 0xD000 && op & 0xFF00 != 0xDF00 => {
            Effect::Branch(ahead(signed(u32::from(op & 0xFF), 8) * 2), true)
        }
        _ if op & 0xF800 == 0xE000 => Effect::Branch(ahead(signed(u32::from(op & 0x7FF), 11) * 2), false),
        // CBZ, CBNZ
        _ if op & 0xF500 == 0xB100 => Effect::Branch(ahead(i64::from((op >> 3 & 0x40) | (op >> 2 & 0x3E))), true),
        // BX, BLX
        _ if op & 0xFF87 == 0x4700 => {
            if op >> 3 & 0xF == 14 {
                Effect::Return
            } else {
                Effect::IndirectJump
            }
        }
        _ if op & 0xFF87 == 0x4780 => Effect::IndirectCall,
        // IT: as many as the lowest bit that is set tells
        _ if op & 0xFF00 == 0xBF00 && op & 0xF != 0 => Effect::Conditional(4 - (op & 0xF).trailing_zeros() as u8),
        // MOV and ADD of high registers
        _ if op & 0xFD00 == 0x4400 => match (op >> 4 & 8) | (op & 7) {
            SP => Effect::UnknownStack,
            PC => Effect::IndirectJump,
            _ => Effect::None,
        },
        _ => Effect::None,
    }
}

fn wide(first: u16, second: u16, address: u64) -> Effect {
    let (high, low) = (u32::from(first), u32::from(second));
    let byte_words = i64::from(second & 0xFF) * 4;
    let registers = i64::from(second.count_ones()) * 4;
    let ahead = |offset: i64| address.wrapping_add_signed(offset + 4);
    let sign = high >> 10 & 1;
    let (j1, j2) = (low >> 13 & 1, low >> 11 & 1);
    // BL, and B T4: 24 bits
    let far = {
        let (i1, i2) = (!(j1 ^ sign) & 1, !(j2 ^ sign) & 1);
        signed(sign << 23 | i1 << 22 | i2 << 21 | (high & 0x3FF) << 11 | low & 0x7FF, 24) * 2
    };
    // B T3: 20 bits
    let near = signed(sign << 19 | j2 << 18 | j1 << 17 | (high & 0x3F) << 11 | low & 0x7FF, 20) * 2;
    let writes_sp = second >> 8 & 0xF == SP;
    match first {
        // UDF.W
        _ if first & 0xFFF0 == 0xF7F0 && second & 0xF000 == 0xA000 => Effect::Return,
        _ if first & 0xF800 == 0xF000 && second & 0xD000 == 0xD000 => Effect::Call(ahead(far)),
        _ if first & 0xF800 == 0xF000 && second & 0xD000 == 0x9000 => Effect::Branch(ahead(far), false),
        // conditions 14 and 15 make other instructions of it
        _ if first & 0xF800 == 0xF000 && second & 0xD000 == 0x8000 && first >> 6 & 0xF < 14 => {
            Effect::Branch(ahead(near), true)
        }
        // STMDB SP!, LDMIA SP!
        0xE92D => Effect::Grow(registers),
        0xE8BD if second & 0x8000 != 0 => Effect::Return,
        0xE8BD => Effect::Grow(-registers),
        // STR [SP, #-n]!, LDR [SP], #n
        0xF84D if second & 0x0F00 == 0x0D00 => Effect::Grow(i64::from(second & 0xFF)),
        0xF85D if second & 0x0F00 == 0x0B00 && second >> 12 == PC => Effect::Return,
        0xF85D if second & 0x0F00 == 0x0B00 => Effect::Grow(-i64::from(second & 0xFF)),
        // STRD [SP, #-n]!, LDRD [SP], #n
        0xE96D => Effect::Grow(byte_words),
        0xE8FD => Effect::Grow(-byte_words),
        // VPUSH, VPOP
        _ if first & 0xFFBF == 0xED2D && second & 0x0E00 == 0x0A00 => Effect::Grow(byte_words),
        _ if first & 0xFFBF == 0xECBD && second & 0x0E00 == 0x0A00 => Effect::Grow(-byte_words),
        // SUB and ADD (SP plus or minus immediate), modified and plain
        _ if first & 0xFBEF == 0xF1AD && writes_sp => Effect::Grow(modified(high, low)),
        _ if first & 0xFBEF == 0xF10D && writes_sp => Effect::Grow(-modified(high, low)),
        _ if first & 0xFBFF == 0xF2AD && writes_sp => Effect::Grow(plain(high, low)),
        _ if first & 0xFBFF == 0xF20D && writes_sp => Effect::Grow(-plain(high, low)),
        // any other arithmetic into SP
        _ if first & 0xF800 == 0xF000 && second & 0x8000 == 0 && writes_sp => Effect::UnknownStack,
        _ if first & 0xFE00 == 0xEA00 && writes_sp => Effect::UnknownStack,
        // TBB, TBH
        _ if first & 0xFFF0 == 0xE8D0 && second & 0xFFE0 == 0xF000 => Effect::Table(1 + (second >> 4 & 1) as u8),
        // LDR PC
        _ if first & 0xFF70 == 0xF850 && second >> 12 == PC => Effect::IndirectJump,
        _ => Effect::None,
    }
}

/// The lowest bits of a value as a signed number.
fn signed(value: u32, bits: u32) -> i64 {
    let unused = 32 - bits;
    i64::from((value << unused) as i32 >> unused)
}

/// The immediate of twelve bits as it stands: i, imm3, imm8.
fn plain(high: u32, low: u32) -> i64 {
    i64::from((high >> 10 & 1) << 11 | (low >> 12 & 7) << 8 | low & 0xFF)
}

/// ThumbExpandImm (DDI 0403, A5.3.2).
fn modified(high: u32, low: u32) -> i64 {
    let packed = plain(high, low) as u32;
    let byte = packed & 0xFF;
    i64::from(match packed >> 8 {
        0 => byte,
        1 => byte * 0x0001_0001,
        2 => byte * 0x0100_0100,
        3 => byte * 0x0101_0101,
        _ => (0x80 | packed & 0x7F).rotate_right(packed >> 7),
    })
}

#[cfg(test)]
mod tests {
    use super::{Effect, decode};

    /// Halfwords and meaning as an assembler has them (llvm-mc, thumbv7em), at the address 0x1000.
    #[test]
    fn instructions_as_an_assembler_writes_them() {
        use Effect::*;
        for (first, second, length, effect, text) in [
            (0xB5F0, 0, 2, Grow(20), "push {r4-r7, lr}"),
            (0xBDF0, 0, 2, Return, "pop {r4-r7, pc}"),
            (0xBC30, 0, 2, Grow(-8), "pop {r4, r5}"),
            (0xB081, 0, 2, Grow(4), "sub sp, #4"),
            (0xB07F, 0, 2, Grow(-508), "add sp, #508"),
            (0xE92D, 0x0F00, 4, Grow(16), "push.w {r8-r11}"),
            (0xE8BD, 0x0F00, 4, Grow(-16), "pop.w {r8-r11}"),
            (0xE8BD, 0x8FF0, 4, Return, "pop.w {r4-r11, pc}"),
            (0xED2D, 0x8B04, 4, Grow(16), "vpush {d8, d9}"),
            (0xECBD, 0x8B04, 4, Grow(-16), "vpop {d8, d9}"),
            (0xED2D, 0x8A01, 4, Grow(4), "vpush {s16}"),
            (0xF5AD, 0x7D06, 4, Grow(0x218), "sub.w sp, sp, #0x218"),
            (0xF2AD, 0x4D04, 4, Grow(0x404), "subw sp, sp, #0x404"),
            (0xF50D, 0x7D06, 4, Grow(-0x218), "add.w sp, sp, #0x218"),
            (0xF84D, 0xBD04, 4, Grow(4), "str r11, [sp, #-4]!"),
            (0xF85D, 0xBB04, 4, Grow(-4), "ldr r11, [sp], #4"),
            (0xF85D, 0xFB04, 4, Return, "ldr pc, [sp], #4"),
            (0xE96D, 0x4502, 4, Grow(8), "strd r4, r5, [sp, #-8]!"),
            (0x46BD, 0, 2, UnknownStack, "mov sp, r7"),
            (0xF1A7, 0x0D0C, 4, UnknownStack, "sub.w sp, r7, #12"),
            (0xF000, 0xF802, 4, Call(0x1008), "bl #4"),
            (0xF7FF, 0xFFFE, 4, Call(0x1000), "bl #-4"),
            (0xF000, 0xB802, 4, Branch(0x1008, false), "b.w #4"),
            (0xF000, 0x8002, 4, Branch(0x1008, true), "beq.w #4"),
            (0xD0FE, 0, 2, Branch(0x1000, true), "beq #-4"),
            (0xE7FE, 0, 2, Branch(0x1000, false), "b #-4"),
            (0xB108, 0, 2, Branch(0x1006, true), "cbz r0, #2"),
            (0xBBC8, 0, 2, Branch(0x1076, true), "cbnz r0, #0x72"),
            (0x4770, 0, 2, Return, "bx lr"),
            (0x4718, 0, 2, IndirectJump, "bx r3"),
            (0x4788, 0, 2, IndirectCall, "blx r1"),
            (0xBF18, 0, 2, Conditional(1), "it ne"),
            (0xBF08, 0, 2, Conditional(1), "it eq"),
            (0xBF14, 0, 2, Conditional(2), "ite ne"),
            (0xBF00, 0, 2, None, "nop"),
            (0xE8DF, 0xF000, 4, Table(1), "tbb [pc, r0]"),
            (0xE8DF, 0xF010, 4, Table(2), "tbh [pc, r0, lsl #1]"),
            (0xDEFE, 0, 2, Return, "udf #0xfe"),
            (0xF3BF, 0x8F4F, 4, None, "dsb sy"),
            (0xF3EF, 0x8010, 4, None, "mrs r0, primask"),
            (0xF04F, 0x30FF, 4, None, "mov.w r0, #-1"),
            (0xF8D0, 0xF000, 4, IndirectJump, "ldr.w pc, [r0]"),
            (0xAF03, 0, 2, None, "add r7, sp, #12"),
            (0xF20D, 0x507C, 4, None, "addw r0, sp, #0x57c"),
        ] {
            assert_eq!(decode(first, second, 0x1000), (length, effect), "{text}");
        }
    }
}
