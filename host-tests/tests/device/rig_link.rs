//! The rig link under arbitrary input. Lines are written here by `format!`.

use glenoid::rig_link::{RigLink, RigLinkError, Signal};
use proptest::collection::vec;
use proptest::prelude::*;

fn hear(bytes: &[u8]) -> Vec<Result<Signal, RigLinkError>> {
    let mut link = RigLink::new();
    let heard: Vec<_> = bytes.iter().filter_map(|&byte| link.push(byte)).collect();
    assert_eq!(link.refused() as usize, heard.iter().filter(|signal| signal.is_err()).count());
    heard
}

proptest! {
    #[test]
    fn counts_and_button_arrive(counts in any::<[i32; 6]>(), down in any::<bool>()) {
        let [c1, c2, c3, c4, c5, c6] = counts;
        let bytes = format!("e {c1} {c2} {c3} {c4} {c5} {c6}\nb {}\n", u8::from(down));
        prop_assert_eq!(hear(bytes.as_bytes()), [Ok(Signal::Counts(counts)), Ok(Signal::Button { down })]);
    }

    /// Bytes of any kind: one result a line, no panic, and the line after them is read cleanly.
    #[test]
    fn noise_spoils_only_its_own_line(noise in vec(any::<u8>(), 0..500)) {
        let mut bytes = noise;
        bytes.extend(b"\nb 1\n");
        let heard = hear(&bytes);
        prop_assert_eq!(heard.len(), bytes.iter().filter(|&&byte| byte == b'\n').count());
        prop_assert_eq!(heard.last(), Some(&Ok(Signal::Button { down: true })));
    }
}
