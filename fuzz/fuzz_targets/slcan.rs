//! Bytes from the CAN line: nothing panics, every line is answered once, and each frame that is accepted survives
//! being written and read again.
//!
//! `cargo +nightly fuzz run slcan`
#![no_main]

use glenoid::slcan::{self, Adapter, Command};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let mut adapter = Adapter::new();
    let mut answers = 0;
    for &byte in bytes {
        let Some(answer) = adapter.receive(byte) else { continue };
        answers += 1;
        assert_eq!(answer.refusal.is_some(), answer.reply == b"\x07");
        if let Some(frame) = answer.frame {
            let line = slcan::encode(&frame, None);
            let (end, line) = line.split_last().expect("a line has an end");
            assert_eq!(*end, b'\r');
            assert_eq!(slcan::parse(line), Ok(Command::Transmit(frame)));
        }
    }
    assert_eq!(answers, bytes.iter().filter(|&&byte| byte == b'\r').count());
});
