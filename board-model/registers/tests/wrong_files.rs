//! What is said of a wrong file: its name, the line, and what is wrong there.

use registers::{known, touched, vendor};

#[test]
fn a_wrong_line_of_the_touched_registers_is_named() {
    for (text, said) in [
        ("# a comment\n\nRCC.CR\nRCC\n", "touched.txt, line 4: `RCC` is not PERIPHERAL.REGISTER"),
        ("RCC.\n", "touched.txt, line 1: `RCC.` is not PERIPHERAL.REGISTER"),
        ("RCC.CR\nRRC.CR\n", "touched.txt, line 2: no peripheral RRC is known"),
        ("RCC.CR\nRCC.CFGR\nRCC.CR\n", "touched.txt, line 3: the same as line 1"),
    ] {
        assert_eq!(touched::parse("touched.txt", text).unwrap_err(), said);
    }
    let read = touched::parse("touched.txt", "# a comment\n\nRCC.CR\n").unwrap();
    assert_eq!(read.into_iter().collect::<Vec<_>>(), [("RCC.CR".to_owned(), 3)]);
}

#[test]
fn a_difference_without_a_reason_is_named() {
    for (text, said) in [
        ("\nP.R.A: only the vendor has bit 1\n", "differences.txt, line 2: no reason behind ` # `"),
        ("P.R.A: only the vendor has bit 1 # \n", "differences.txt, line 1: no reason behind ` # `"),
        ("P.R.A: x # one\nP.R.A: x # other\n", "differences.txt, line 2: the same as line 1"),
    ] {
        assert_eq!(known::parse("differences.txt", text).unwrap_err(), said);
    }
}

#[test]
fn a_line_that_the_vendor_does_not_write_is_named() {
    for (text, said) in [
        ("pub type R = u32;\n    ///Bits 3:1 - A\n", "line 2: no bits of a register: ///Bits 3:1 - A"),
        ("///Bit 32 - A\n", "line 1: no bits of a register: ///Bit 32 - A"),
        ("///Bit x - A\n", "line 1: no bits of a register: ///Bit x - A"),
        ("\n\n    const RESET_VALUE: u32 = 0xnone;\n", "line 3: no reset value: const RESET_VALUE: u32 = 0xnone;"),
    ] {
        assert_eq!(vendor::register(text).unwrap_err(), said);
    }
    let folder = vendor::folder().unwrap();
    let error = vendor::block(&folder, "no_such_block").unwrap_err().to_string();
    assert!(error.contains("no_such_block.rs: "), "{error}");
}

/// Both lists are as they should be.
#[test]
fn the_lists_can_be_read() {
    assert!(!touched::list().unwrap().is_empty());
    assert!(!known::list().unwrap().is_empty());
}
