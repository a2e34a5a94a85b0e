//! Encodings as LLVM's assembler gives them (`llvm-mc -triple=thumbv7em -show-encoding`), each with what the manual says
//! of the instruction.

use super::*;

/// At address 0x1000, from the bytes as the assembler prints them.
fn decoded(bytes: &[u8]) -> Instruction {
    let half = |at: usize| bytes.get(at..at + 2).map_or(0, |half| u16::from_le_bytes([half[0], half[1]]));
    assert_eq!(len(half(0)), bytes.len() as u64);
    decode(0x1000, half(0), half(2))
}

#[test]
fn what_is_taken_off_the_stack_pointer() {
    let cases: [(&str, &[u8], u64); 14] = [
        ("push {r4, r5, r7, lr}", &[0xb0, 0xb5], 16),
        ("push {r0}", &[0x01, 0xb4], 4),
        ("sub sp, #24", &[0x86, 0xb0], 24),
        ("sub sp, #508", &[0xff, 0xb0], 508),
        ("push.w {r8, r9, r10}", &[0x2d, 0xe9, 0x00, 0x07], 12),
        ("str r8, [sp, #-4]!", &[0x4d, 0xf8, 0x04, 0x8d], 4),
        ("str r1, [sp, #-12]!", &[0x4d, 0xf8, 0x0c, 0x1d], 12),
        ("strd r0, r1, [sp, #-16]!", &[0x6d, 0xe9, 0x04, 0x01], 16),
        ("vpush {d8, d9}", &[0x2d, 0xed, 0x04, 0x8b], 16),
        ("vpush {s16}", &[0x2d, 0xed, 0x01, 0x8a], 4),
        ("sub.w sp, sp, #512", &[0xad, 0xf5, 0x00, 0x7d], 512),
        ("sub.w sp, sp, #1024", &[0xad, 0xf5, 0x80, 0x6d], 1024),
        ("sub.w sp, sp, #4080", &[0xad, 0xf5, 0x7f, 0x6d], 4080),
        ("subw sp, sp, #1236", &[0xad, 0xf2, 0xd4, 0x4d], 1236),
    ];
    for (text, bytes, taken) in cases {
        assert_eq!(decoded(bytes), Instruction::Takes(taken), "{text}");
    }
}

#[test]
fn where_it_goes() {
    let cases: [(&str, &[u8], i64); 8] = [
        ("bl #4096", &[0x01, 0xf0, 0x00, 0xf8], 4096),
        ("bl #-4096", &[0xff, 0xf7, 0x00, 0xf8], -4096),
        ("b.w #1048576", &[0x00, 0xf1, 0x00, 0xb8], 1_048_576),
        ("beq.w #2048", &[0x00, 0xf0, 0x00, 0x84], 2048),
        ("bne.w #-2048", &[0x7f, 0xf4, 0x00, 0xac], -2048),
        ("b #-256", &[0x80, 0xe7], -256),
        ("beq #64", &[0x20, 0xd0], 64),
        ("bl #0", &[0x00, 0xf0, 0x00, 0xf8], 0),
    ];
    for (text, bytes, offset) in cases {
        assert_eq!(decoded(bytes), Instruction::GoesTo(0x1004_u64.wrapping_add_signed(offset)), "{text}");
    }
    let anywhere: [(&str, &[u8]); 4] = [
        ("blx r3", &[0x98, 0x47]),
        ("bx r12", &[0x60, 0x47]),
        ("mov pc, r2", &[0x97, 0x46]),
        ("ldr.w pc, [r0, #4]", &[0xd0, 0xf8, 0x04, 0xf0]),
    ];
    for (text, bytes) in anywhere {
        assert_eq!(decoded(bytes), Instruction::GoesAnywhere, "{text}");
    }
}

#[test]
fn constants_in_halves() {
    let lower = Instruction::LowerHalf { register: 3, value: 0x1234 };
    assert_eq!(decoded(&[0x41, 0xf2, 0x34, 0x23]), lower, "movw r3, #4660");
    let upper = Instruction::UpperHalf { register: 11, value: 0x2000 };
    assert_eq!(decoded(&[0xc2, 0xf2, 0x00, 0x0b]), upper, "movt r11, #8192");
}

#[test]
fn a_computed_stack_pointer_is_seen() {
    assert_eq!(decoded(&[0xa5, 0x46]), Instruction::ComputesStackPointer, "mov sp, r4");
    assert_eq!(decoded(&[0xad, 0xeb, 0x01, 0x0d]), Instruction::ComputesStackPointer, "sub.w sp, sp, r1");
}

#[test]
fn the_rest_is_left_alone() {
    let cases: [(&str, &[u8]); 18] = [
        ("add sp, #24", &[0x06, 0xb0]),
        ("add.w sp, sp, #1024", &[0x0d, 0xf5, 0x80, 0x6d]),
        ("addw sp, sp, #1236", &[0x0d, 0xf2, 0xd4, 0x4d]),
        ("bx lr", &[0x70, 0x47]),
        ("pop {r4, pc}", &[0x10, 0xbd]),
        ("ldr pc, [sp], #4", &[0x5d, 0xf8, 0x04, 0xfb]),
        ("tbb [pc, r2]", &[0xdf, 0xe8, 0x02, 0xf0]),
        ("cmp.w r0, #256", &[0xb0, 0xf5, 0x80, 0x7f]),
        ("tst.w r0, #13", &[0x10, 0xf0, 0x0d, 0x0f]),
        ("cmp sp, r1", &[0x8d, 0x45]),
        ("ldr.w r1, [sp, #40]", &[0xdd, 0xf8, 0x28, 0x10]),
        ("mrs r0, msp", &[0xef, 0xf3, 0x08, 0x80]),
        ("pop.w {r4, r8}", &[0xbd, 0xe8, 0x10, 0x01]),
        ("udf #1", &[0x01, 0xde]),
        ("svc #3", &[0x03, 0xdf]),
        ("bfc r4, #0, #3", &[0x6f, 0xf3, 0x02, 0x04]),
        ("cmp.w sp, #512", &[0xbd, 0xf5, 0x00, 0x7f]),
        ("add sp, #24", &[0x06, 0xb0]),
    ];
    for (text, bytes) in cases {
        assert_eq!(decoded(bytes), Instruction::Other, "{text}");
    }
}
