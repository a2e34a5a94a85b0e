//! A sound image, made up by hand, and one thing after another wrong with it.

use super::*;

fn section(name: &str, address: u64, size_bytes: u64, in_flash: bool, in_ram: bool) -> Section {
    Section { name: name.to_owned(), address, size_bytes, in_flash, in_ram }
}

fn segment(address: u64, size_bytes: u64, stored_at: u64, stored_bytes: u64, writable: bool) -> Segment {
    Segment { address, size_bytes, stored_at, stored_bytes, writable }
}

fn sound() -> Facts {
    let mut vectors = vec![0x0800_0201; 118];
    vectors[0] = 0x2001_8000;
    vectors[2] = 0x0800_0301;
    vectors[3] = 0x0800_0401;
    vectors[7] = 0;
    vectors[15] = 0x0800_0501;
    vectors[37] = 0x0800_0601;
    Facts {
        entry: 0x0800_0201,
        sections: vec![
            section(".vector_table", 0x0800_0000, 0x1D8, true, false),
            section(".text", 0x0800_0200, 0x10000, true, false),
            section(".ccm_code", 0x1000_0000, 0x2000, true, false),
            section(".data", 0x2000_0000, 0x100, true, true),
            section(".bss", 0x2000_0100, 0x3000, false, true),
            section(".uninit", 0x2000_3100, 0x400, false, true),
        ],
        segments: vec![
            segment(0x0800_0000, 0x10200, 0x0800_0000, 0x10200, false),
            segment(0x1000_0000, 0x2000, 0x0801_0200, 0x2000, false),
            segment(0x2000_0000, 0x100, 0x0801_2200, 0x100, true),
            segment(0x2000_0100, 0x3400, 0x2000_0100, 0, true),
        ],
        vectors,
        handlers: [0x0800_0200, 0x0800_0300, 0x0800_0400, 0x0800_0500, 0x0800_0600],
        code: Range { from: 0x0800_0200, end: 0x0801_0200 },
        stack: Range { from: 0x2000_3500, end: 0x2001_8000 },
        record: Range { from: 0x0807_D000, end: 0x0808_0000 },
        left_alone: Range { from: 0x2000_3100, end: 0x2000_3500 },
        crash_record: 0x2000_3110,
    }
}

/// What is found when `spoil` is done to the sound image.
fn found(spoil: impl FnOnce(&mut Facts)) -> Vec<Fault> {
    let mut facts = sound();
    spoil(&mut facts);
    facts.faults()
}

#[test]
fn a_sound_image_has_no_fault() {
    assert_eq!(sound().faults(), []);
    assert_eq!((sound().flash_bytes(), sound().static_bytes()), (0x12300, 0x3500));
}

#[test]
fn a_wrong_start_is_found() {
    assert_eq!(found(|f| f.entry = 0x0800_0200), [Fault::Entry(0x0800_0200)]);
    assert_eq!(found(|f| f.vectors[0] = 0x2002_0000), [Fault::StackPointer(0x2002_0000)]);
    assert_eq!(found(|f| f.stack.end = 0x2000_8000), [Fault::StackPointer(0x2001_8000)]);
    assert_eq!(found(|f| f.sections[0].address = 0x0800_0400), [Fault::VectorTable]);
    assert_eq!(found(|f| f.vectors.truncate(100)), [Fault::VectorTable]);
}

#[test]
fn a_wrong_vector_is_found() {
    for (index, name) in OWN_VECTORS {
        // a handler that exists, but not this one's
        assert_eq!(found(|f| f.vectors[index] = 0x0800_0701), [Fault::Handler(name)]);
    }
    // an even address, one past the code, one in the RAM
    for stray in [0x0800_0600, 0x0801_0201, 0x2000_0001] {
        assert_eq!(found(|f| f.vectors[50] = stray), [Fault::StrayVector(50)], "{stray:#x}");
    }
}

#[test]
fn misplaced_memory_is_found() {
    // stored behind the first bank, or into the record
    for stored_at in [0x0803_FFF0, 0x0807_F000] {
        assert_eq!(found(|f| f.segments[2].stored_at = stored_at), [Fault::Misplaced(0x2000_0000)]);
    }
    // variables in the memory for code, code in the one for variables
    assert_eq!(found(|f| f.segments[1].writable = true), [Fault::Misplaced(0x1000_0000)]);
    assert_eq!(found(|f| f.segments[1].address = 0x2001_0000), [Fault::Misplaced(0x2001_0000)]);
    // an image linked for the emulated board
    assert_eq!(found(|f| f.segments[0].address = 0), [Fault::Misplaced(0)]);
    assert_eq!(found(|f| f.segments[3].size_bytes = 0x20000), [Fault::Misplaced(0x2000_0100)]);
    assert_eq!(found(|f| f.sections[5].address = 0x2000_30FF), [Fault::Overlap(".uninit".to_owned())]);
    assert_eq!(found(|f| f.stack.from = 0x2000_34FC), [Fault::Overlap("stack".to_owned())]);
    assert_eq!(found(|f| f.record.from = 0x0807_E000), [Fault::Record]);
    assert_eq!(found(|f| f.crash_record = 0x2000_3000), [Fault::CrashRecord(0x2000_3000)]);
}

#[test]
fn an_image_that_is_too_large_is_found() {
    let too_much_flash = MOST_FLASH_BYTES - 0x2100 + 1;
    assert_eq!(found(|f| f.segments[0].stored_bytes = too_much_flash), [Fault::Flash(MOST_FLASH_BYTES + 1)]);
    assert_eq!(found(|f| f.segments[0].stored_bytes = too_much_flash - 1), []);
    let at_limit = MOST_STATIC_BYTES - 0x500;
    let spoil = |f: &mut Facts, size_bytes| {
        f.sections[4].size_bytes = size_bytes;
        f.sections[5].address = 0x2000_0100 + size_bytes;
        f.stack.from = 0x2000_0500 + size_bytes;
    };
    assert_eq!(found(|f| spoil(f, at_limit + 4)), [Fault::StaticRam(MOST_STATIC_BYTES + 4)]);
    assert_eq!(found(|f| spoil(f, at_limit)), []);
}
