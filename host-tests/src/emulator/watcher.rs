//! Ends the emulator when its owner is gone, even if that was killed and could do nothing more.

use std::io;
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, Stdio};

/// Waits for the end of its input, which comes when nobody holds the other end any more.
const SCRIPT: &str = r#"read -r nothing; kill -9 "$1""#;

/// A shell whose input this process alone holds. Dropping it ends the shell and leaves the emulator alone: do so before
/// the emulator's number may become another program's.
#[derive(Debug)]
pub struct Watcher(Child);

impl Watcher {
    /// Watches over this emulator from now on.
    ///
    /// # Errors
    /// When there is no shell.
    pub fn over(emulator: &Child) -> io::Result<Self> {
        let mut shell = Command::new("sh");
        shell.args(["-c", SCRIPT, "watcher"]).arg(emulator.id().to_string());
        // of a group of its own: what ends the owner's group must not end it first
        shell.process_group(0).stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::null());
        shell.spawn().map(Self)
    }
}

impl Drop for Watcher {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
