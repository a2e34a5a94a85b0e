//! One function: how deep its own frame gets, and how deep the stack is at each of its calls.

use std::collections::BTreeMap;

use super::thumb::{Effect, decode};

/// Deeper than any frame: something went round and round.
const ABSURD_BYTES: i64 = 1 << 20;

/// What a function does to the stack.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Frame {
    /// The deepest that its own frame gets, bytes.
    pub own_bytes: i64,
    /// Functions that it calls or leaves for, with the depth at that moment.
    pub calls: Vec<(u64, i64)>,
    /// Depth at each call by a pointer.
    pub indirect: Vec<i64>,
    /// The stack pointer is set to what the instructions do not tell, or the walk was lost.
    pub unknown: bool,
}

/// Code by its address.
pub trait Code {
    /// The halfword at the address; None where there is no code, but data or nothing.
    fn halfword(&self, address: u64) -> Option<u16>;
    /// Length of the data that begin at the address, bytes.
    fn data_len(&self, address: u64) -> u64;
    /// The byte at the address, code or data.
    fn byte(&self, address: u64) -> Option<u8>;
}

/// Where the walk stands.
#[derive(Debug, Clone, Copy)]
struct Here {
    address: u64,
    depth: i64,
    /// Instructions ahead that are conditional.
    conditional: u8,
}

/// Walks through the function from `from` to `end`, both ways at every branch.
pub fn walk(code: &impl Code, from: u64, end: u64) -> Frame {
    let mut frame = Frame::default();
    let mut seen: BTreeMap<u64, i64> = BTreeMap::new();
    let mut open = vec![Here { address: from, depth: 0, conditional: 0 }];
    while let Some(here) = open.pop() {
        let Here { address, depth, conditional } = here;
        if seen.get(&address).is_some_and(|deepest| *deepest >= depth) {
            continue;
        }
        seen.insert(address, depth);
        if depth > ABSURD_BYTES {
            frame.unknown = true;
            return frame;
        }
        let Some(first) = (from..end).contains(&address).then(|| code.halfword(address)).flatten() else {
            // behind a call that never returns there is no code of this function
            continue;
        };
        let (len, effect) = decode(first, code.halfword(address + 2).unwrap_or_default(), address);
        let next = Here { address: address + len, depth, conditional: conditional.saturating_sub(1) };
        let may_be_skipped = conditional != 0;
        let mut go = |target: u64| match (from..end).contains(&target) {
            true => open.push(Here { address: target, depth, conditional: 0 }),
            false => frame.calls.push((target, depth)),
        };
        match effect {
            Effect::None => open.push(next),
            Effect::Conditional(count) => open.push(Here { conditional: count, ..next }),
            Effect::Grow(bytes) => {
                frame.own_bytes = frame.own_bytes.max(depth + bytes);
                open.push(Here { depth: depth + bytes, ..next });
                if may_be_skipped {
                    open.push(next);
                }
            }
            Effect::UnknownStack => frame.unknown = true,
            Effect::Branch(target, only_if) => {
                go(target);
                if only_if || may_be_skipped {
                    open.push(next);
                }
            }
            Effect::Call(target) => {
                frame.calls.push((target, depth));
                open.push(next);
            }
            Effect::IndirectCall => {
                frame.indirect.push(depth);
                open.push(next);
            }
            Effect::IndirectJump => {
                frame.indirect.push(depth);
                if may_be_skipped {
                    open.push(next);
                }
            }
            Effect::Return if may_be_skipped => open.push(next),
            Effect::Return => {}
            Effect::Table(width) => table(code, address + len, width).into_iter().for_each(&mut go),
        }
    }
    frame.calls.sort_unstable();
    frame.calls.dedup();
    frame
}

/// The targets of a branch by a table: twice each entry, ahead of the table.
fn table(code: &impl Code, at: u64, width: u8) -> Vec<u64> {
    let entries = code.data_len(at) / u64::from(width);
    let entry = |index: u64| {
        let bytes = (0..u64::from(width)).map(|byte| code.byte(at + index * u64::from(width) + byte));
        bytes.rev().try_fold(0, |value, byte| Some(value << 8 | u64::from(byte?)))
    };
    // bytes that only fill up to a halfword lead to the table itself
    (0..entries).filter_map(entry).filter(|entry| *entry != 0).map(|entry| at + 2 * entry).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Halfwords from address 0 on, and which of them are data.
    struct Listing(&'static [u16], std::ops::Range<u64>);

    impl Code for Listing {
        fn halfword(&self, address: u64) -> Option<u16> {
            (!self.1.contains(&address)).then(|| self.0.get(address as usize / 2).copied()).flatten()
        }
        fn data_len(&self, address: u64) -> u64 {
            if self.1.start == address { self.1.end - self.1.start } else { 0 }
        }
        fn byte(&self, address: u64) -> Option<u8> {
            self.0.get(address as usize / 2).map(|halfword| halfword.to_le_bytes()[address as usize % 2])
        }
    }

    fn walked(code: &'static [u16], data: std::ops::Range<u64>) -> Frame {
        walk(&Listing(code, data), 0, code.len() as u64 * 2)
    }

    #[test]
    fn the_deepest_of_two_ways_counts() {
        // push {r4, lr}; cbz r0, 1f; sub sp, #16; bl +4 (to 0x100C+..); add sp, #16; 1: pop {r4, pc}
        let frame = walked(&[0xB510, 0xB118, 0xB084, 0xF000, 0xF9FA, 0xB004, 0xBD10], 0..0);
        assert_eq!(frame, Frame { own_bytes: 24, calls: vec![(0x3FE, 24)], indirect: vec![], unknown: false });
    }

    #[test]
    fn a_conditional_return_does_not_end_the_walk() {
        // push {r4, lr}; it ne; popne {r4, pc}; sub sp, #32; udf
        let frame = walked(&[0xB510, 0xBF18, 0xBD10, 0xB088, 0xDEFE], 0..0);
        assert_eq!(frame.own_bytes, 40);
    }

    #[test]
    fn a_jump_by_a_table_goes_to_every_entry() {
        // tbb [pc, r0]; table 2, 4 (at 4); sub sp, #8 (at 8); bx lr; push {r4-r7, lr} (at 12); blx r1; bx lr
        let frame = walked(&[0xE8DF, 0xF000, 0x0402, 0xBF00, 0xB082, 0x4770, 0xB5F0, 0x4788, 0x4770], 4..6);
        assert_eq!(frame, Frame { own_bytes: 20, calls: vec![], indirect: vec![20], unknown: false });
    }

    #[test]
    fn a_jump_out_is_a_call_and_a_set_stack_is_unknown() {
        // sub sp, #4; b.w far away
        assert_eq!(walked(&[0xB081, 0xF000, 0xB9FE], 0..0).calls, [(0x402, 4)]);
        assert!(walked(&[0x46BD, 0x4770], 0..0).unknown);
    }
}
