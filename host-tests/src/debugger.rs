//! Reaches into a running board: registers and memory, over the emulator's debugger port.
//!
//! Faults that no client can cause are injected this way. Source: "The GDB Remote Serial Protocol", packets `P`, `m`,
//! `M`, `Z0`, `c` and `D`; register numbers of QEMU's Arm target.

use std::fmt;
use std::io::{self, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::Duration;

/// Most bytes of memory in one packet, which the emulator limits to 4 KiB.
const MAX_BYTES: usize = 1024;

/// Longest wait for an answer; on a busy host the emulator may stand still for seconds.
const PATIENCE: Duration = Duration::from_secs(60);

/// A register of the core that may be changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Register {
    /// The stack pointer in use.
    StackPointer = 13,
    /// Address of the next instruction.
    ProgramCounter = 15,
}

/// Why the debugger cannot go on.
#[derive(Debug)]
pub enum DebuggerError {
    /// The connection failed.
    Line(io::Error),
    /// The emulator gave another answer than success.
    Refused(String),
}

impl fmt::Display for DebuggerError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(error) => write!(f, "the debugger's line failed: {error}"),
            Self::Refused(answer) => write!(f, "the emulator refused a debugger's packet: {answer}"),
        }
    }
}

impl std::error::Error for DebuggerError {}

impl From<io::Error> for DebuggerError {
    fn from(error: io::Error) -> Self {
        Self::Line(error)
    }
}

/// A board that stands still.
#[derive(Debug)]
pub struct Debugger {
    stream: TcpStream,
}

impl Debugger {
    /// Connects, which halts the board.
    ///
    /// # Errors
    /// [`DebuggerError`].
    pub fn halt(address: SocketAddr) -> Result<Self, DebuggerError> {
        let stream = TcpStream::connect(address)?;
        stream.set_read_timeout(Some(PATIENCE))?;
        let mut debugger = Self { stream };
        // QEMU takes single registers only from a debugger that has asked for their description
        debugger.request("qXfer:features:read:target.xml:0,1", |answer| answer.starts_with(['m', 'l']))?;
        Ok(debugger)
    }

    /// Writes a register.
    ///
    /// # Errors
    /// [`DebuggerError`].
    pub fn set(&mut self, register: Register, value: u32) -> Result<(), DebuggerError> {
        // registers travel in the target's byte order
        let bytes: String = value.to_le_bytes().iter().map(|byte| format!("{byte:02x}")).collect();
        self.request(&format!("P{:x}={bytes}", register as u8), |answer| answer == "OK").map(drop)
    }

    /// Reads memory.
    ///
    /// # Errors
    /// [`DebuggerError`].
    pub fn read(&mut self, address: u32, len: usize) -> Result<Vec<u8>, DebuggerError> {
        let mut bytes = Vec::new();
        while bytes.len() < len {
            let part = (len - bytes.len()).min(MAX_BYTES);
            let is_data = |answer: &str| answer.len() == 2 * part;
            let answer = self.request(&format!("m{:x},{part:x}", address as usize + bytes.len()), is_data)?;
            let byte = |pair: &[u8]| u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok();
            let read: Option<Vec<u8>> = answer.as_bytes().chunks(2).map(byte).collect();
            bytes.extend(read.ok_or(DebuggerError::Refused(answer))?);
        }
        Ok(bytes)
    }

    /// Writes memory, be it what the firmware takes for flash.
    ///
    /// # Errors
    /// [`DebuggerError`].
    pub fn write(&mut self, address: u32, bytes: &[u8]) -> Result<(), DebuggerError> {
        let digits: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        self.request(&format!("M{address:x},{:x}:{digits}", bytes.len()), |answer| answer == "OK").map(drop)
    }

    /// Lets the board run until it is about to execute the instruction at `address`; meanwhile `stir` gives it something
    /// to do.
    ///
    /// # Errors
    /// [`DebuggerError`]; [`DebuggerError::Line`] also when the board does not come by in time.
    pub fn run_to(&mut self, address: u32, stir: impl FnOnce()) -> Result<(), DebuggerError> {
        // 2: an instruction of two bytes, which every instruction of this core begins with
        self.request(&format!("Z0,{address:x},2"), |answer| answer == "OK")?;
        self.send("c")?;
        stir();
        while !self.answer()?.starts_with('T') {}
        self.stream.write_all(b"+")?;
        self.request(&format!("z0,{address:x},2"), |answer| answer == "OK").map(drop)
    }

    /// Lets the board run on.
    ///
    /// # Errors
    /// [`DebuggerError`].
    pub fn resume(mut self) -> Result<(), DebuggerError> {
        self.request("D", |answer| answer == "OK").map(drop)
    }

    fn request(&mut self, packet: &str, is_success: impl Fn(&str) -> bool) -> Result<String, DebuggerError> {
        self.send(packet)?;
        loop {
            let answer = self.answer()?;
            self.stream.write_all(b"+")?;
            // the emulator tells by itself, and at any time, that the board has halted
            if is_success(&answer) {
                return Ok(answer);
            } else if !answer.starts_with(['T', 'S']) {
                return Err(DebuggerError::Refused(answer));
            }
        }
    }

    fn send(&mut self, packet: &str) -> io::Result<()> {
        let checksum = packet.bytes().fold(0_u8, u8::wrapping_add);
        write!(self.stream, "${packet}#{checksum:02x}")
    }

    /// The next answer, `$text#checksum`, without its frame. TCP has already checked the sum.
    fn answer(&mut self) -> Result<String, DebuggerError> {
        let mut text = String::new();
        while self.byte()? != b'$' {}
        loop {
            match self.byte()? {
                b'#' => break,
                byte => text.push(char::from(byte)),
            }
        }
        self.byte()?;
        self.byte()?;
        Ok(text)
    }

    fn byte(&mut self) -> io::Result<u8> {
        let mut byte = [0];
        self.stream.read_exact(&mut byte)?;
        Ok(byte[0])
    }
}
