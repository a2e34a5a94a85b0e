//! Lines of an SLCAN adapter to messages, and commands to lines.

use super::json;
use glenoid::can::message::PROTOCOL;
use glenoid::can::{BaseId, Frame, Message, Opcode, Request};
use glenoid::line::LineBuffer;
use glenoid::procedure::{Guidance, Reason, StateName};
use glenoid::slcan::{self, Command};

/// The line from the adapter, as far as it has come.
#[derive(Debug)]
pub struct Line(LineBuffer<64, b'\r'>);

impl Default for Line {
    fn default() -> Self {
        Self(LineBuffer::new())
    }
}

impl Line {
    /// A JSON list of the messages in these bytes. Answers of the adapter and foreign frames are passed over.
    pub fn receive(&mut self, bytes: &[u8]) -> String {
        let mut messages = Vec::new();
        for byte in bytes.iter().filter(|byte| **byte != 0x07) {
            if let Some(Ok(line)) = self.0.push(*byte)
                && let Ok(Command::Transmit(frame)) = slcan::parse(line)
            {
                messages.extend(message(&frame));
            }
        }
        json::join(messages)
    }
}

/// The message in an identifier (2 bytes, little-endian) and its data.
pub fn decode(bytes: &[u8]) -> Option<String> {
    let (id, data) = bytes.split_first_chunk::<2>()?;
    message(&Frame::new(u16::from_le_bytes(*id), data).ok()?)
}

fn message(frame: &Frame) -> Option<String> {
    let message = Message::unpack(frame, BaseId::DEFAULT).ok()?;
    let (name, fields) = vocabulary::fields(&message);
    let mut text = format!("{{\"name\":\"{name}\"");
    for (field, value) in fields {
        text += &format!(",\"{field}\":{}", json::number(value));
    }
    Some(text + "}")
}

/// A command as a line of SLCAN.
pub fn command(opcode: u32, run: u32, argument: u32, nonce: u32) -> Option<Vec<u8>> {
    let opcode = Opcode::from_code(u8::try_from(opcode).ok()?)? as u8;
    let [run, argument, nonce] = [run, argument, nonce].map(|number| u16::try_from(number).ok());
    let request = Request { opcode, nonce: nonce?, run_id: run?, argument: argument? };
    Some(slcan::encode(&request.pack(BaseId::DEFAULT.command()), None).to_vec())
}

/// Codes and their words.
pub fn words() -> String {
    let reasons = Reason::ALL.iter().map(|reason| {
        let (code, name, text, remedy) = (reason.code(), reason.name(), reason.text(), reason.remedy());
        format!("[{code},{},{},{}]", json::text(name), json::text(text), json::text(remedy))
    });
    let guidance = Guidance::ALL.iter().map(|advice| format!("[{},{}]", advice.code(), json::text(advice.text())));
    let states = StateName::ALL.iter().map(|state| format!("[{},{}]", state.code(), json::text(&format!("{state:?}"))));
    let opcodes =
        Opcode::ALL.iter().map(|opcode| format!("[{},{}]", *opcode as u8, json::text(&format!("{opcode:?}"))));
    format!(
        "{{\"protocol\":{PROTOCOL},\"reasons\":{},\"guidance\":{},\"states\":{},\"opcodes\":{}}}",
        json::join(reasons),
        json::join(guidance),
        json::join(states),
        json::join(opcodes)
    )
}
