//! Whole conversations, byte for byte.

extern crate std;

use super::*;
use std::vec::Vec;

/// Plays a client's bytes; gives all replies in one string, the frames, and the refusals.
fn talk(adapter: &mut Adapter, input: &[u8]) -> (Vec<u8>, Vec<Frame>, Vec<SlcanError>) {
    let answers: Vec<_> = input.iter().filter_map(|&b| adapter.receive(b)).collect();
    (
        answers.iter().flat_map(|a| a.reply).copied().collect(),
        answers.iter().filter_map(|a| a.frame).collect(),
        answers.iter().filter_map(|a| a.refusal).collect(),
    )
}

fn frame(id: u16, data: &[u8]) -> Frame {
    Frame::new(id, data).unwrap()
}

#[test]
fn the_bytes_of_python_can() {
    let mut adapter = Adapter::new();
    let (replies, frames, refusals) = talk(&mut adapter, b"C\rS6\r\rO\rO\rt1003010203\rT000001230\rr1230\rV\rN\rC\r");
    assert_eq!(replies, b"\r\r\r\r\rz\rZ\rz\rV0101\rN0001\r\r");
    assert_eq!(frames, [frame(0x100, &[1, 2, 3])]);
    assert!(refusals.is_empty());
    assert_eq!(adapter.counters(), Counters { accepted: 1, foreign: 2, refused: 0, overruns: 0 });
}

#[test]
fn nothing_passes_a_closed_channel() {
    let mut adapter = Adapter::new();
    assert_eq!(adapter.forward(&frame(1, &[]), 0), None);
    let (replies, frames, refusals) = talk(&mut adapter, b"t1230\rT000001230\rr1230\r");
    assert_eq!(replies, b"\x07\x07\x07");
    assert!(frames.is_empty());
    assert_eq!(refusals, [SlcanError::ChannelClosed; 3]);
    assert_eq!(adapter.counters().refused, 3);
    talk(&mut adapter, b"O\r");
    assert!(adapter.is_open());
    assert!(adapter.forward(&frame(1, &[]), 0).is_some());
    talk(&mut adapter, b"C\r");
    assert!(!adapter.is_open());
    assert_eq!(adapter.forward(&frame(1, &[]), 0), None);
}

#[test]
fn a_listener_hears_and_stays_silent() {
    let mut adapter = Adapter::new();
    let (replies, frames, refusals) = talk(&mut adapter, b"L\rt1230\r");
    assert_eq!((&replies[..], frames.len()), (&b"\r\x07"[..], 0));
    assert_eq!(refusals, [SlcanError::ListenOnly]);
    assert!(adapter.forward(&frame(1, &[]), 0).is_some());
}

#[test]
fn settings_only_while_closed() {
    let mut adapter = Adapter::new();
    let (replies, _, refusals) = talk(&mut adapter, b"O\rS6\rs031C\rZ1\rC\rS6\rs031C\rZ1\r");
    assert_eq!(replies, b"\r\x07\x07\x07\r\r\r\r");
    assert_eq!(refusals, [SlcanError::ChannelOpen; 3]);
}

#[test]
fn time_stamps_wrap_each_minute() {
    let mut adapter = Adapter::new();
    talk(&mut adapter, b"Z1\rO\r");
    let line = |now_ms| adapter.forward(&frame(0x100, &[]), now_ms).unwrap();
    assert_eq!(line(0), b"t10000000\r");
    assert_eq!(line(59_999), b"t1000EA5F\r");
    assert_eq!(line(60_001), b"t10000001\r");
    // 2^32 - 1 = 71 582 minutes and 47 295 ms
    assert_eq!(line(u32::MAX), b"t1000B8BF\r");
}

#[test]
fn an_overrun_is_told_once() {
    let mut adapter = Adapter::new();
    adapter.note_overrun();
    assert_eq!(talk(&mut adapter, b"F\rF\r").0, b"F08\rF00\r");
    assert_eq!(adapter.counters().overruns, 1);
}
