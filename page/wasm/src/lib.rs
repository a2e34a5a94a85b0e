//! The library for the page.
//!
//! The page is a client like any other: bytes of an SLCAN line go in, messages come out, commands go out as lines. The
//! mathematics is the firmware's own in its own precision, so what the page shows is what the board computes, to the bit.
//!
//! JavaScript writes into [`input`], calls a function with the length, and reads so many bytes from [`output`]: JSON, or
//! bytes for the line. Kept is only what later messages hang on: a line that has begun, and what a new
//! centre was shown as.

#![allow(unsafe_code, reason = "functions exported to WebAssembly keep their names")]

mod codec;
mod elbow;
mod json;
pub mod mathematics;
pub mod parameters;

use elbow::Elbow;
use glenoid::procedure::ModuleRig;
use glenoid::rig::Rig;
use std::cell::RefCell;

/// The largest input: a recording is passed in parts.
const INPUT_BYTES: usize = 1 << 18;

struct Exchange {
    input: Vec<u8>,
    output: Vec<u8>,
    codec: codec::Codec,
    /// The machine that the board is; until it has said so, the one of the defaults.
    machine: Option<Machine>,
}

/// The machine that a board is.
enum Machine {
    Ball(Box<Rig<f32>>),
    Hinge(Box<Elbow>),
}

impl Machine {
    fn of(rig: &ModuleRig) -> Self {
        match rig {
            ModuleRig::Ball(rig) => Self::Ball(Box::new(*rig)),
            ModuleRig::Hinge(rig) => Self::Hinge(Box::new(Elbow::new(rig))),
        }
    }
}

thread_local! {
    static EXCHANGE: RefCell<Exchange> = RefCell::new(Exchange {
        input: vec![0; INPUT_BYTES],
        output: Vec::new(),
        codec: codec::Codec::default(),
        machine: parameters::rig_of(&[]).ok().as_ref().map(Machine::of),
    });
}

/// Runs a function on the input's first `len` bytes; its result becomes the output. Returns the output's length.
fn exchange(len: usize, run: impl FnOnce(&[u8], &mut codec::Codec) -> Vec<u8>) -> usize {
    EXCHANGE.with_borrow_mut(|Exchange { input, output, codec, .. }| {
        *output = run(&input[..len.min(INPUT_BYTES)], codec);
        output.len()
    })
}

/// Runs the mathematics of the machine on the input's first `len` bytes.
fn compute(
    len: usize,
    of_ball: impl FnOnce(&Rig<f32>, &[u8]) -> String,
    of_hinge: impl FnOnce(&mut Elbow, &[u8]) -> String,
) -> usize {
    EXCHANGE.with_borrow_mut(|Exchange { input, output, machine, .. }| {
        let input = &input[..len.min(INPUT_BYTES)];
        let text = match machine {
            Some(Machine::Ball(rig)) => of_ball(rig, input),
            Some(Machine::Hinge(elbow)) => of_hinge(elbow, input),
            None => "null".to_owned(),
        };
        *output = text.into_bytes();
        output.len()
    })
}

/// Where JavaScript writes.
#[unsafe(no_mangle)]
pub extern "C" fn input() -> *mut u8 {
    EXCHANGE.with_borrow_mut(|exchange| exchange.input.as_mut_ptr())
}

/// How many bytes may be written there.
#[unsafe(no_mangle)]
pub extern "C" fn input_size() -> usize {
    INPUT_BYTES
}

/// Where JavaScript reads.
#[unsafe(no_mangle)]
pub extern "C" fn output() -> *const u8 {
    EXCHANGE.with_borrow(|exchange| exchange.output.as_ptr())
}

/// Bytes of an SLCAN line to a JSON list of the device's messages in them.
#[unsafe(no_mangle)]
pub extern "C" fn receive(len: usize) -> usize {
    exchange(len, |bytes, codec| codec.receive(bytes).into_bytes())
}

/// One frame (2 bytes of identifier, little-endian, then the data) to the device's message in it as JSON, or nothing.
#[unsafe(no_mangle)]
pub extern "C" fn decode(len: usize) -> usize {
    exchange(len, |bytes, codec| codec.decode(bytes).unwrap_or_default().into_bytes())
}

/// A command as a line of SLCAN; nothing for an unknown opcode, or for the accept of a centre that was not shown whole.
#[unsafe(no_mangle)]
pub extern "C" fn command(opcode: u32, run: u32, argument: u32, nonce: u32) -> usize {
    exchange(0, |_, codec| codec.command(opcode, run, argument, nonce).unwrap_or_default())
}

/// Forgets what was heard: another board, or another moment of a recording.
#[unsafe(no_mangle)]
pub extern "C" fn forget() -> usize {
    exchange(0, |_, codec| {
        *codec = codec::Codec::default();
        Vec::new()
    })
}

/// All codes of the vocabulary with their names, texts and remedies as JSON, and the vocabulary's number.
#[unsafe(no_mangle)]
pub extern "C" fn words() -> usize {
    exchange(0, |_, _| codec::words().into_bytes())
}

/// All parameters as the library's table has them, as JSON: index, name, unit, 1 for a single, default, smallest and
/// largest value, 1 if the lock guards it, what it is.
#[unsafe(no_mangle)]
pub extern "C" fn parameters() -> usize {
    exchange(0, |_, _| parameters::table().into_bytes())
}

/// A request about parameters as a line of SLCAN; nothing for an operation that is not known.
#[unsafe(no_mangle)]
pub extern "C" fn parameter_request(operation: u32, index: u32, nonce: u32, value: u32) -> usize {
    exchange(0, |_, _| parameters::request(operation, index, nonce, value).unwrap_or_default())
}

/// Takes the machine from parameters that the board has sent: index and bits of each, two words of 32 bits, little-endian.
/// The answer is empty, or names what contradicts itself; the machine stays as it was then.
#[unsafe(no_mangle)]
pub extern "C" fn configure(len: usize) -> usize {
    EXCHANGE.with_borrow_mut(|Exchange { input, output, machine, .. }| {
        output.clear();
        match parameters::rig_of(&input[..len.min(INPUT_BYTES)]) {
            Ok(found) => *machine = Some(Machine::of(&found)),
            Err(complaint) => output.extend_from_slice(complaint.as_bytes()),
        }
        output.len()
    })
}

/// The machine as JSON: where each cable begins and ends, the platform's three end-points, the nominal centre, the platform
/// at home. Of a hinge the axis as well.
#[unsafe(no_mangle)]
pub extern "C" fn machine() -> usize {
    compute(0, |rig, _| mathematics::machine(rig), |elbow, _| elbow.machine())
}

/// Six lengths (of a hinge as many as it has cables) as 32-bit floats, little-endian, to where the platform stands, as JSON.
#[unsafe(no_mangle)]
pub extern "C" fn place(len: usize) -> usize {
    compute(len, mathematics::place, |elbow, lengths| elbow.place(lengths))
}

/// The lengths of many poses to the centre, its covariance, what each pose and cable leaves, and where to go next, as
/// JSON. Null for a hinge: the board's own numbers are shown.
#[unsafe(no_mangle)]
pub extern "C" fn identify(len: usize) -> usize {
    compute(len, mathematics::identify, |_, _| "null".to_owned())
}

/// The thirteen numbers of a hinge that the board has shown, as 32-bit floats, little-endian: the forearm turns about it from
/// now on. The answer is the machine as JSON; null for a ball.
#[unsafe(no_mangle)]
pub extern "C" fn hinge(len: usize) -> usize {
    compute(
        len,
        |_, _| "null".to_owned(),
        |elbow, numbers| {
            elbow.take_hinge(numbers);
            elbow.machine()
        },
    )
}
