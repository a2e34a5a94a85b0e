//! The emulator's own controls.
//!
//! Source: "QEMU Machine Protocol", one JSON object a line each way.

use std::io::{self, BufRead, BufReader, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::Duration;

/// Longest wait for an answer; on a busy host the emulator may stand still for seconds.
const PATIENCE: Duration = Duration::from_secs(60);

/// Resets the emulated machine.
pub fn reset(address: SocketAddr) -> io::Result<()> {
    let mut stream = TcpStream::connect(address)?;
    stream.set_read_timeout(Some(PATIENCE))?;
    let mut lines = BufReader::new(stream.try_clone()?).lines();
    // a greeting, an answer to each command, events in between
    for command in ["qmp_capabilities", "system_reset"] {
        writeln!(stream, r#"{{"execute":"{command}"}}"#)?;
        loop {
            let line = lines.next().ok_or(io::ErrorKind::UnexpectedEof)??;
            if line.starts_with(r#"{"error""#) {
                return Err(io::Error::other(line));
            } else if line.starts_with(r#"{"return""#) {
                break;
            }
        }
    }
    Ok(())
}
