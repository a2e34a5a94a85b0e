//! Lines of an SLCAN adapter to messages, and commands to lines.

use super::json;
use glenoid::can::identity::{Naming, checksum};
use glenoid::can::message::{BLOCK, PROTOCOL};
use glenoid::can::set::{Received, Receiver};
use glenoid::can::telemetry::{TELEMETRY_ID, TELEMETRY_LEN};
use glenoid::can::{BaseId, Frame, Message, Opcode, Operation, ParameterAnswer, Request, Telemetry};
use glenoid::line::LineBuffer;
use glenoid::procedure::elbow::SHOWN_NUMBERS;
use glenoid::procedure::{Guidance, Reason, StateName};
use glenoid::slcan::{self, Command};

/// What came from the board, as far as later messages hang on it.
#[derive(Debug)]
pub struct Codec {
    /// The line from the adapter, as far as it has come.
    line: LineBuffer<64, b'\r'>,
    telemetry: Receiver<TELEMETRY_LEN>,
    candidate: Shown,
    live: Shown,
}

impl Default for Codec {
    fn default() -> Self {
        Self {
            line: LineBuffer::new(),
            telemetry: Receiver::new(TELEMETRY_ID),
            candidate: Shown::default(),
            live: Shown::default(),
        }
    }
}

impl Codec {
    /// A JSON list of the messages in these bytes. Answers of the adapter and foreign frames are passed over.
    pub fn receive(&mut self, bytes: &[u8]) -> String {
        let mut messages = Vec::new();
        for byte in bytes.iter().filter(|byte| **byte != 0x07) {
            if let Some(Ok(line)) = self.line.push(*byte)
                && let Ok(Command::Transmit(frame)) = slcan::parse(line)
            {
                messages.extend(self.message(&frame));
            }
        }
        json::join(messages)
    }

    /// The message in an identifier (2 bytes, little-endian) and its data.
    pub fn decode(&mut self, bytes: &[u8]) -> Option<String> {
        let (id, data) = bytes.split_first_chunk::<2>()?;
        self.message(&Frame::new(u16::from_le_bytes(*id), data).ok()?)
    }

    fn message(&mut self, frame: &Frame) -> Option<String> {
        let message = Message::unpack(frame, BaseId::DEFAULT).ok()?;
        match message {
            Message::CandidateNaming(naming) => self.candidate.naming = Some(naming),
            Message::LiveNaming(naming) => self.live.naming = Some(naming),
            Message::CandidateCentre(value) => self.candidate.put(value.index.into(), frame),
            Message::LiveCentre(value) => self.live.put(value.index.into(), frame),
            Message::CandidateRadius(value) => self.candidate.put(3 + usize::from(value.index), frame),
            Message::LiveRadius(value) => self.live.put(3 + usize::from(value.index), frame),
            Message::CandidateZero(zero) => self.candidate.put(5 + usize::from(zero.cable), frame),
            Message::LiveZero(zero) => self.live.put(5 + usize::from(zero.cable), frame),
            Message::CandidateMotion(part) => self.candidate.put(12 + usize::from(part.part), frame),
            Message::LiveMotion(part) => self.live.put(12 + usize::from(part.part), frame),
            Message::CandidateHingeAxis(part) => self.candidate.put(hinge_place(part.index, true), frame),
            Message::CandidateHingePlace(part) => self.candidate.put(hinge_place(part.index, false), frame),
            Message::LiveHingeAxis(part) => self.live.put(hinge_place(part.index, true), frame),
            Message::LiveHingePlace(part) => self.live.put(hinge_place(part.index, false), frame),
            _ => {}
        }
        if let Message::Telemetry(piece) = message {
            return match self.telemetry.take(piece) {
                Received::Set { data, .. } => Telemetry::unpack(&data).map(|telemetry| telemetry_json(&telemetry)),
                // A board that was reset counts from the beginning again.
                Received::Repeated => {
                    self.telemetry.restart();
                    None
                }
                Received::Nothing | Received::Refused(_) => None,
            };
        }
        if let Message::Parameter(answer) = message {
            return Some(parameter_json(&answer));
        }
        let (name, fields) = vocabulary::fields(&message);
        let mut text = format!("{{\"name\":\"{name}\"");
        for (field, value) in fields {
            text += &format!(",\"{field}\":{}", json::number(value));
        }
        Some(text + "}")
    }

    /// A command as a line of SLCAN.
    pub fn command(&self, opcode: u32, run: u32, argument: u32, nonce: u32) -> Option<Vec<u8>> {
        let opcode = Opcode::from_code(u8::try_from(opcode).ok()?)?;
        let [run_id, argument, nonce] = [run, argument, nonce].map(|number| u16::try_from(number).ok());
        let (run_id, argument, nonce) = (run_id?, argument?, nonce?);
        // Named by what was shown here: what was not shown cannot be accepted.
        let request = match opcode {
            Opcode::Accept => Request::naming(opcode, nonce, &self.candidate.naming(run_id)?),
            Opcode::Confirm => Request::naming(opcode, nonce, &self.live.naming(run_id)?),
            _ => Request { opcode: opcode as u8, boot: 0, nonce, run_id, argument },
        };
        Some(slcan::encode(&request.pack(BaseId::DEFAULT.command()), None).to_vec())
    }
}

/// Where the frames of a hinge begin, behind those of a ball and its motion.
const HINGE: usize = 20;
/// Frames of a ball without its motion.
const OF_BALL: usize = 12;

/// Where a frame of a hinge stands: axis and foot point in the base, three frames each, then in the platform, then the offset.
fn hinge_place(index: u8, is_axis: bool) -> usize {
    let (body, component) = (usize::from(index) / 3, usize::from(index) % 3);
    HINGE + 6 * body + component + if is_axis || body == 2 { 0 } else { 3 }
}

/// The frames that showed a centre or a hinge, a new one or the one in use.
#[derive(Debug, Default)]
struct Shown {
    frames: [Option<[u8; 8]>; 20],
    hinge: [Option<[u8; 8]>; SHOWN_NUMBERS],
    naming: Option<Naming>,
}

impl Shown {
    fn put(&mut self, place: usize, frame: &Frame) {
        if let Some(shown) = self.frames.iter_mut().chain(&mut self.hinge).nth(place) {
            *shown = frame.data().try_into().ok();
        }
    }

    /// What names the value of this run: None unless all of it was shown.
    fn naming(&self, run_id: u16) -> Option<Naming> {
        let Naming { boot, wearer, .. } = self.naming.filter(|naming| naming.run_id == run_id)?;
        // those of an earlier run are not meant
        let of_run = |frame: &&[u8; 8]| frame.starts_with(&run_id.to_le_bytes());
        let frames = if self.hinge.iter().flatten().any(|frame| of_run(&frame)) {
            self.hinge.iter().copied().collect::<Option<Vec<_>>>()?
        } else {
            let (of_ball, motion) = self.frames.split_at(OF_BALL);
            let mut frames = of_ball.iter().copied().collect::<Option<Vec<_>>>()?;
            // Of a ball there are none.
            frames.extend(motion.iter().flatten().filter(of_run));
            frames
        };
        Some(Naming { run_id, boot, wearer, checksum: checksum(boot, wearer, frames.into_iter()) })
    }
}

/// The value as its bits: what they mean depends on the index.
fn parameter_json(answer: &ParameterAnswer) -> String {
    let ParameterAnswer { operation, index, nonce, code, value } = answer;
    format!(
        "{{\"name\":\"Parameter\",\"operation\":{operation},\"parameter\":{index},\"nonce\":{nonce},\"code\":{},\"bits\":{value}}}",
        code.code()
    )
}

fn telemetry_json(telemetry: &Telemetry) -> String {
    let (centre, sigma) = telemetry.centre.map_or(("null".to_owned(), f32::NAN), |(c, s)| (json::list(&c), s));
    format!(
        "{{\"name\":\"Telemetry\",\"lengths\":{},\"centre\":{centre},\"sigma\":{},\"slack\":{},\"still\":{}}}",
        json::list(&telemetry.lengths_mm),
        json::number(sigma.into()),
        telemetry.slack,
        u8::from(telemetry.still)
    )
}

/// Codes and their words.
pub fn words() -> String {
    let reasons = Reason::ALL.iter().map(|reason| {
        let (code, name, text, remedy) = (reason.code(), reason.name(), reason.text(), reason.remedy());
        format!("[{code},{},{},{}]", json::text(name), json::text(text), json::text(remedy))
    });
    let guidance = Guidance::ALL.iter().map(|advice| {
        format!("[{},{},{}]", advice.code(), json::text(advice.text()), json::text(&format!("{advice:?}")))
    });
    let states = StateName::ALL.iter().map(|state| format!("[{},{}]", state.code(), json::text(&format!("{state:?}"))));
    let opcodes =
        Opcode::ALL.iter().map(|opcode| format!("[{},{}]", *opcode as u8, json::text(&format!("{opcode:?}"))));
    let operations = Operation::ALL
        .iter()
        .map(|operation| format!("[{},{}]", *operation as u8, json::text(&format!("{operation:?}"))));
    let base = BaseId::DEFAULT.command().as_raw();
    format!(
        "{{\"protocol\":{PROTOCOL},\"base\":{base},\"block\":{BLOCK},\"reasons\":{},\"guidance\":{},\"states\":{},\"opcodes\":{},\"operations\":{}}}",
        json::join(reasons),
        json::join(guidance),
        json::join(states),
        json::join(opcodes),
        json::join(operations)
    )
}
