//! A sound image, made up by hand, and one thing after another wrong with it.

use super::*;
use crate::stack_bound::Function;

fn function(name: &str, address: u64, size_bytes: u64) -> Symbol {
    Symbol { name: name.to_owned(), linker_name: name.to_owned(), address, size_bytes }
}

fn segment(address: u64, size_bytes: u64, stored_at: u64) -> Segment {
    Segment { address, size_bytes, stored_at, stored_bytes: size_bytes, writable: false }
}

fn sound() -> HotCode {
    let line = |pattern: &str, functions| Line { pattern: pattern.to_owned(), functions };
    HotCode {
        lines: vec![
            line("solve*", vec![function("solve", 0x1000_0000, 0x800)]),
            line("add*", vec![function("add_one", 0x1000_0800, 0x100), function("add_all", 0x1000_0900, 0xF8)]),
        ],
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
fn found(spoil: impl FnOnce(&mut HotCode)) -> Vec<Fault> {
    let mut hot = sound();
    spoil(&mut hot);
    hot.faults(Memory::DRIVE_BOARD)
}

#[test]
fn a_sound_image_has_no_fault() {
    assert_eq!(found(|_| {}), []);
    assert_eq!(sound().bytes(), 0xA00);
}

#[test]
fn a_line_without_a_function_is_found() {
    assert_eq!(found(|hot| hot.lines[0].functions.clear()), [Fault::NoFunction("solve*".to_owned())]);
}

#[test]
fn a_function_that_was_left_behind_is_found() {
    // in the flash; with its last bytes behind the code
    for address in [0x0800_0400, 0x1000_0990] {
        let elsewhere = Fault::Elsewhere("add_all".to_owned(), address);
        assert_eq!(found(|hot| hot.lines[1].functions[1].address = address), [elsewhere]);
    }
    let all_behind = |hot: &mut HotCode| {
        hot.code.end = hot.code.from;
        hot.filled = hot.code;
        hot.segments.remove(2);
    };
    let names = ["solve", "add_one", "add_all"];
    let faults = found(all_behind);
    assert!(names.iter().all(|name| faults.iter().any(|fault| matches!(fault, Fault::Elsewhere(n, _) if n == name))));
    assert!(faults.contains(&Fault::CopiedFrom(0x0801_01D8)));
}

#[test]
fn code_in_another_memory_is_found() {
    assert_eq!(sound().faults(Memory::EMULATED), [Fault::Misplaced(0x1000_0000), Fault::Stored(0x0801_01D8)]);
    let too_much = |hot: &mut HotCode| {
        hot.code.end = 0x1000_8008;
        hot.filled.end = 0x1000_8008;
        hot.segments[2].size_bytes = 0x8008;
        hot.segments[2].stored_bytes = 0x8008;
        hot.segments[3].stored_at = 0x0802_0000;
    };
    assert_eq!(found(too_much), [Fault::Misplaced(0x1000_0000)]);
}

#[test]
fn a_copy_of_something_else_is_found() {
    let short = Range { from: 0x1000_0000, end: 0x1000_0900 };
    assert_eq!(found(|hot| hot.filled = short), [Fault::Filled(short)]);
    // eight bytes further on: no segment begins there, and the next one is met
    let further = 0x0801_01E0;
    assert_eq!(found(|hot| hot.copied_from = further), [Fault::CopiedFrom(further), Fault::Stored(further)]);
}

#[test]
fn an_overwritten_store_is_found() {
    // the initial values of the variables over its end, the code of the flash over its beginning
    assert_eq!(found(|hot| hot.segments[3].stored_at -= 8), [Fault::Stored(0x0801_01D8)]);
    assert_eq!(found(|hot| hot.segments[1].stored_bytes += 8), [Fault::Stored(0x0801_01D8)]);
    let in_the_other_bank = |hot: &mut HotCode| {
        hot.copied_from = 0x0804_0000;
        hot.segments[2].stored_at = 0x0804_0000;
    };
    assert_eq!(found(in_the_other_bank), [Fault::Stored(0x0804_0000)]);
}

#[test]
fn code_that_an_exception_may_call_is_found() {
    let called = |at: u64| found(|hot| hot.called_by_exceptions = BTreeSet::from([0x0800_0300, at]));
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

/// The names are those that both mangling schemes give the same functions, from images of rustc 1.95 and 1.96.
#[test]
fn the_list_knows_both_mangling_schemes() {
    let sections = [
        ".text._ZN7glenoid10kinematics14stewart_gough27ForwardKinematics$LT$T$GT$5solve17h4656f48f915fac2fE",
        ".text._RNvMNtNtCsbLFLnxsIJIF_7glenoid10kinematics14stewart_goughINtB2_17ForwardKinematicsfE5solveB6_",
        ".text._ZN7glenoid14identification6blocks23BlockEquations$LT$T$GT$8add_pose17h021c707509db292dE",
        ".text._RNvMs2_NtNtCsbLFLnxsIJIF_7glenoid14identification6blocksINtB5_14BlockEquationsfE8add_poseB7_",
    ];
    for section in sections {
        assert_eq!(patterns().filter(|pattern| matches(pattern, section)).count(), 1, "{section}");
    }
    // called once a pass; another crate's; no function's own section
    let others = [
        ".text._ZN7glenoid14identification6solver12accumulation16PassSum$LT$T$GT$14add_own_centre17hbff96783e6bf3419E",
        ".text._ZN4libm4math5atanf5atanf17he68f16e5aae2d36bE",
        ".text",
    ];
    assert!(others.iter().all(|other| patterns().all(|pattern| !matches(pattern, other))));
}

#[test]
fn an_asterisk_is_anything() {
    for (pattern, name, expected) in [
        ("ab", "ab", true),
        ("ab", "abc", false),
        ("a*", "a", true),
        ("a*", "ba", false),
        ("*b*", "abc", true),
        ("a*b*c", "a-b-b-c", true),
        ("a*b*c", "a-c-b", false),
        ("*aab", "aaab", true),
    ] {
        assert_eq!(matches(pattern, name), expected, "{pattern} {name}");
    }
}
