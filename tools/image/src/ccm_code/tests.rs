//! A sound image, made up by hand, and one thing after another wrong with it.

use super::*;
use crate::stack_bound::Function;

fn function(name: &str, address: u64, size_bytes: u64) -> Symbol {
    Symbol { name: name.to_owned(), linker_name: name.to_owned(), address, size_bytes }
}

fn segment(address: u64, size_bytes: u64, stored_at: u64) -> Segment {
    Segment { address, size_bytes, stored_at, stored_bytes: size_bytes, writable: false }
}

fn sound() -> CcmCode {
    CcmCode {
        functions: vec![function("solve", 0x1000_0000, 0x800), function("add", 0x1000_0800, 0x1F8)],
        code: Range { from: 0x1000_0000, end: 0x1000_0A00 },
        segments: vec![
            segment(0x0800_0000, 0x1D8, 0x0800_0000),
            segment(0x0800_01D8, 0x10000, 0x0800_01D8),
            segment(0x1000_0000, 0xA00, 0x0801_01D8),
            segment(0x2000_0000, 0xA0, 0x0801_0BD8),
            Segment { stored_bytes: 0, ..segment(0x2000_00A0, 0x3000, 0x2000_00A0) },
        ],
        filled: Range { from: 0x1000_0000, end: 0x1000_0A00 },
        copied_from: 0x0801_01D8,
        called_by_exceptions: BTreeSet::from([0x0800_0300, 0x0800_0400]),
    }
}

/// What is found when `spoil` is done to the sound image.
fn found(spoil: impl FnOnce(&mut CcmCode)) -> Vec<Fault> {
    let mut image = sound();
    spoil(&mut image);
    image.faults(Memory::DRIVE_BOARD)
}

#[test]
fn a_sound_image_has_no_fault() {
    assert_eq!(found(|_| {}), []);
    assert_eq!(sound().bytes(), 0xA00);
}

#[test]
fn an_image_compiled_without_it_is_found() {
    let without = |image: &mut CcmCode| {
        image.functions.clear();
        image.code.end = image.code.from;
        image.filled = image.code;
        image.segments.remove(2);
    };
    assert_eq!(found(without), [Fault::Empty, Fault::CopiedFrom(0x0801_01D8)]);
}

#[test]
fn code_in_another_memory_is_found() {
    assert_eq!(sound().faults(Memory::EMULATED), [Fault::Misplaced(0x1000_0000), Fault::Stored(0x0801_01D8)]);
    let too_much = |image: &mut CcmCode| {
        image.code.end = 0x1000_8008;
        image.filled.end = 0x1000_8008;
        image.segments[2].size_bytes = 0x8008;
        image.segments[2].stored_bytes = 0x8008;
        image.segments[3].stored_at = 0x0802_0000;
    };
    assert_eq!(found(too_much), [Fault::Misplaced(0x1000_0000)]);
}

#[test]
fn a_copy_of_something_else_is_found() {
    let short = Range { from: 0x1000_0000, end: 0x1000_0900 };
    assert_eq!(found(|image| image.filled = short), [Fault::Filled(short)]);
    // eight bytes further on: no segment begins there, and the next one is met
    let further = 0x0801_01E0;
    assert_eq!(found(|image| image.copied_from = further), [Fault::CopiedFrom(further), Fault::Stored(further)]);
}

#[test]
fn an_overwritten_store_is_found() {
    // the initial values of the variables over its end, the code of the flash over its beginning
    assert_eq!(found(|image| image.segments[3].stored_at -= 8), [Fault::Stored(0x0801_01D8)]);
    assert_eq!(found(|image| image.segments[1].stored_bytes += 8), [Fault::Stored(0x0801_01D8)]);
    let in_the_other_bank = |image: &mut CcmCode| {
        image.copied_from = 0x0804_0000;
        image.segments[2].stored_at = 0x0804_0000;
    };
    assert_eq!(found(in_the_other_bank), [Fault::Stored(0x0804_0000)]);
}

#[test]
fn code_that_an_exception_may_call_is_found() {
    let called = |at: u64| found(|image| image.called_by_exceptions = BTreeSet::from([0x0800_0300, at]));
    assert_eq!(called(0x1000_0800), [Fault::CalledByException(0x1000_0800)]);
    assert_eq!(called(0x1000_0A00), []);
}

#[test]
fn what_exceptions_call_is_followed() {
    let function = |calls: &[u64], calls_anywhere| Function {
        name: String::new(),
        frame_bytes: 0,
        calls: calls.iter().copied().collect(),
        calls_anywhere,
        masks_first: false,
    };
    // 1 is the start, 2 and 3 are handlers; 3 calls through a pointer, 5 and 6 call each other, 8 is the start's alone
    let functions = [
        (1, function(&[8], false)),
        (2, function(&[4], false)),
        (3, function(&[], true)),
        (4, function(&[], false)),
        (5, function(&[6], false)),
        (6, function(&[5], false)),
        (8, function(&[], false)),
    ];
    let graph = CallGraph { functions: functions.into(), pointed_to: BTreeSet::from([5]), handlers: vec![1, 2, 3] };
    assert_eq!(called_by_exceptions(&graph), BTreeSet::from([2, 3, 4, 5, 6]));
}
