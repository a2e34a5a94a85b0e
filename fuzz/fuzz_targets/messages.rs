//! Frames from the CAN bus: nothing panics, every command frame gets exactly one answer with its nonce, what the decoder
//! takes for a message is packed into the same message again, and the device stays within its table of transitions.
//!
//! Input: one byte for the identifier within the device's block or beside it, one for the length, then the data bytes;
//! frame after frame. `cargo +nightly fuzz run messages`
#![no_main]

use glenoid::can::{BaseId, Frame, Message};
use glenoid::device::{Action, Config, Device, Event, MAX_FRAMES};
use glenoid::rig::{ASSUMED_BASE_RADIUS_MM, Rig};
use libfuzzer_sys::fuzz_target;

const BASE: BaseId = BaseId::DEFAULT;

fuzz_target!(|bytes: &[u8]| {
    let Ok(rig) = Rig::shoulder(ASSUMED_BASE_RADIUS_MM as f32) else { return };
    let mut device = Device::new(&Config::for_rig(rig));
    let mut now_ms = 0u32;
    let mut rest = bytes;
    while let [selector, length, data @ ..] = rest {
        let length = usize::from(*length % 9).min(data.len());
        let (data, after) = data.split_at(length);
        rest = after;
        let frame =
            Frame::new(0x2F8 + u16::from(*selector % 0x30), data).expect("a standard identifier, at most 8 bytes");
        round_trip(&frame);
        now_ms = now_ms.wrapping_add(u32::from(*selector));
        obey(&mut device, now_ms, frame);
        device.handle(now_ms, Event::Tick, &mut |_| {});
    }
});

/// A message that the decoder takes is the same after packing, but for bits that no field uses. A wide field's very
/// last values round up to its end when they become a single; those do not pack again.
fn round_trip(frame: &Frame) {
    let Ok(message) = Message::unpack(frame, BASE) else { return };
    if let Ok(again) = message.pack(BASE) {
        assert_eq!(Message::unpack(&again, BASE), Ok(message));
    } else {
        let wide = matches!(
            message,
            Message::RawLength(_)
                | Message::CandidateCentre(_)
                | Message::CandidateRadius(_)
                | Message::LiveCentre(_)
                | Message::LiveRadius(_)
                | Message::CandidateZero(_)
                | Message::LiveZero(_)
        );
        assert!(wide, "{message:?} does not pack again");
    }
}

/// One answer to a command frame, none to others.
fn obey(device: &mut Device, now_ms: u32, frame: Frame) {
    let (mut answers, mut frames) = (0, 0);
    device.handle(now_ms, Event::Can(frame), &mut |action| {
        let Action::Send(sent) = action else { return };
        frames += 1;
        if let Ok(Message::Answer(answer)) = Message::unpack(&sent, BASE) {
            answers += 1;
            let byte = |index: usize| frame.data().get(index).copied().unwrap_or(0);
            assert_eq!((answer.opcode, answer.nonce), (byte(0), u16::from_le_bytes([byte(2), byte(3)])));
        }
    });
    let is_command = frame.raw_id() == BASE.command().as_raw();
    assert_eq!(answers, usize::from(is_command));
    assert!(frames <= MAX_FRAMES);
}
