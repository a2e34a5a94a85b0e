//! Bytes from the rig link: nothing panics, every line gives one result, and counts survive being written again.
//!
//! `cargo +nightly fuzz run rig_link`
#![no_main]

use glenoid::rig_link::{self, RigLink, Signal};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let mut link = RigLink::new();
    let mut results = 0;
    for &byte in bytes {
        let Some(result) = link.push(byte) else { continue };
        results += 1;
        if let Ok(Signal::Counts(counts)) = result {
            let [c1, c2, c3, c4, c5, c6] = counts;
            let line = format!("e {c1} {c2} {c3} {c4} {c5} {c6}");
            assert_eq!(rig_link::parse(line.as_bytes()), Ok(Signal::Counts(counts)));
        }
    }
    assert_eq!(results, bytes.iter().filter(|&&byte| byte == b'\n').count());
});
