//! A client's end of the shared bus: an SLCAN adapter of its own on any line of bytes.

use super::{Port, SharedBus};
use crate::slcan_client::nothing_came;
use glenoid::slcan::Adapter;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::thread;
use std::time::{Duration, Instant};

/// Longest wait for bytes of the client before frames for it are looked for.
const TURN: Duration = Duration::from_millis(2);

/// A client that takes nothing for so long is gone.
const WRITE_LIMIT: Duration = Duration::from_secs(30);

/// A line of bytes to a client.
pub trait Line {
    /// The bytes that came within a few milliseconds, perhaps none.
    ///
    /// # Errors
    /// When the line is gone.
    fn read(&mut self) -> io::Result<Vec<u8>>;

    /// Sends bytes.
    ///
    /// # Errors
    /// When the line is gone.
    fn write(&mut self, bytes: &[u8]) -> io::Result<()>;
}

/// A TCP line without a protocol around the bytes.
struct Plain(TcpStream);

impl Line for Plain {
    fn read(&mut self) -> io::Result<Vec<u8>> {
        let mut bytes = [0; 4096];
        match self.0.read(&mut bytes) {
            Ok(0) => Err(ErrorKind::UnexpectedEof.into()),
            Ok(len) => Ok(bytes[..len].to_vec()),
            Err(error) if nothing_came(&error) => Ok(Vec::new()),
            Err(error) => Err(error),
        }
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.0.write_all(bytes)
    }
}

/// Serves SLCAN clients over TCP until the process ends, each in a thread of its own.
pub fn serve_slcan(bus: SharedBus, listener: TcpListener) {
    thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            let bus = bus.clone();
            thread::spawn(move || {
                let set = stream
                    .set_nodelay(true)
                    .and_then(|()| stream.set_read_timeout(Some(TURN)))
                    .and_then(|()| stream.set_write_timeout(Some(WRITE_LIMIT)));
                if set.is_ok() {
                    let _ = serve_line(&bus.attach(), &mut Plain(stream));
                }
            });
        }
    });
}

/// Serves one client until its line is gone.
///
/// # Errors
/// Why the line is gone.
pub fn serve_line(port: &Port, line: &mut dyn Line) -> io::Result<()> {
    let (mut adapter, begin) = (Adapter::new(), Instant::now());
    loop {
        let mut out = Vec::new();
        for byte in line.read()? {
            if let Some(answer) = adapter.receive(byte) {
                out.extend_from_slice(answer.reply);
                if let Some(frame) = answer.frame {
                    port.send(frame);
                }
            }
        }
        // The adapter's clock is a wrapping count of milliseconds.
        let now_ms = begin.elapsed().as_millis() as u32;
        while let Some(frame) = port.try_receive() {
            if let Some(text) = adapter.forward(&frame, now_ms) {
                out.extend_from_slice(&text);
            }
        }
        if !out.is_empty() {
            line.write(&out)?;
        }
    }
}
