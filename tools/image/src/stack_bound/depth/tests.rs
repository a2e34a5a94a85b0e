use super::*;
use crate::stack_bound::Function;
use std::collections::BTreeSet;

/// Functions by address: frame, callees, whether they call through pointers.
fn graph(functions: &[(u64, u64, &[u64], bool)], pointed_to: &[u64], handlers: &[u64]) -> CallGraph {
    let function = |(address, frame_bytes, calls, calls_anywhere): &(u64, u64, &[u64], bool)| {
        let calls: BTreeSet<u64> = calls.iter().copied().collect();
        let name = format!("f{address}");
        (
            *address,
            Function { name, frame_bytes: *frame_bytes, calls, calls_anywhere: *calls_anywhere, masks_first: false },
        )
    };
    CallGraph {
        functions: functions.iter().map(function).collect(),
        pointed_to: pointed_to.iter().copied().collect(),
        handlers: handlers.to_vec(),
    }
}

#[test]
fn the_deepest_way_counts() {
    let graph =
        graph(&[(1, 8, &[2, 3], false), (2, 100, &[], false), (3, 40, &[4], false), (4, 50, &[], false)], &[], &[1]);
    let bounds = bounds(&graph).unwrap();
    assert_eq!(bounds[0].bytes, 8 + 100);
    assert_eq!(bounds[0].way, [("f1".to_owned(), 8), ("f2".to_owned(), 100)]);
}

#[test]
fn a_pointer_may_lead_to_whatever_is_pointed_to() {
    let graph = graph(&[(1, 8, &[], true), (2, 100, &[], false), (3, 400, &[], false)], &[2], &[1]);
    assert_eq!(bounds(&graph).unwrap()[0].bytes, 108);
}

#[test]
fn a_circle_is_gone_round_a_few_times() {
    // 2 and 3 call each other, 4 calls itself
    let graph =
        graph(&[(1, 8, &[2], false), (2, 10, &[3], false), (3, 20, &[2, 4], false), (4, 5, &[4], false)], &[], &[1]);
    assert_eq!(bounds(&graph).unwrap()[0].bytes, 8 + MOST_ROUNDS * (10 + 20 + 5));
}

#[test]
fn an_exception_brings_its_own_frame() {
    let graph = graph(&[(1, 8, &[], false), (2, 16, &[], false)], &[], &[1, 2]);
    let bounds = bounds(&graph).unwrap();
    assert_eq!((bounds[0].root, bounds[0].bytes), (Root::Main, 8));
    assert_eq!((bounds[1].root, bounds[1].bytes), (Root::Exception, 16 + 108));
}

#[test]
fn an_ending_is_counted_apart_from_those_who_call_it() {
    // 2, the ending, writes text and may panic, which is the ending again
    let mut whole =
        graph(&[(1, 8, &[2, 4], false), (2, 16, &[3], false), (3, 100, &[2], false), (4, 30, &[], false)], &[], &[1]);
    assert_eq!(whole.ending(), None);
    let ending = whole.functions.get_mut(&2).unwrap();
    ending.name = "board::cortex::faults::stop".to_owned();
    assert_eq!(whole.ending(), None, "interrupts still come in");
    whole.functions.get_mut(&2).unwrap().masks_first = true;
    assert_eq!(whole.ending(), Some(2));
    assert_eq!(bounds(&whole.without_callees_of(2)).unwrap()[0].bytes, 8 + 30);
    assert_eq!(depth(&whole, 2).0, MOST_ROUNDS * (16 + 100));
}
