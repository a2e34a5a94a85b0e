//! Runs a firmware image in QEMU as the emulated drive board.

mod error;
mod log;
mod record_file;
mod watcher;

pub use error::EmulatorError;

use crate::monitor;
use crate::packages::{self, Consent};
use log::{Log, follow};
use record_file::RecordFile;
use std::io;
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};
use watcher::Watcher;

/// The emulator's program.
const PROGRAM: &str = "qemu-system-arm";

/// Debian's package that holds it.
const PACKAGE: &str = "qemu-system-arm";

/// The firmware's first line; once it is there, both serial lines are served.
const READY: &str = "board: ready";

/// Booting takes a tenth of a second; a machine under load gets much more.
const BOOT_LIMIT: Duration = Duration::from_secs(60);

/// Tries to find ports, should another program take one between the search and the start.
const PORT_TRIES: usize = 3;

/// How a board is started.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// TCP port of the CAN line (SLCAN); any free one if None.
    pub can_port: Option<u16>,
    /// TCP port of the rig link; any free one if None.
    pub rig_port: Option<u16>,
    /// File that stands for the flash that the record lies in; one of this board's own, gone with it, if None.
    pub record: Option<PathBuf>,
    /// Serial number of the board; 0: it has none.
    pub serial: u32,
    /// Serve a debugger, which may change registers (see [`crate::debugger`]).
    pub debugger: bool,
    /// Serve a monitor, which may reset the board (see [`Emulator::reset`]).
    pub monitor: bool,
    /// Repeat each line of the log on the error output.
    pub show_log: bool,
}

/// Makes sure that the emulator is installed.
///
/// # Errors
/// [`EmulatorError::Missing`].
pub fn ensure_installed(consent: Consent) -> Result<(), EmulatorError> {
    if packages::find_program(PROGRAM).is_some() {
        return Ok(());
    }
    packages::ensure(&[PACKAGE], "emulating the drive board", consent).map_err(EmulatorError::Missing)
}

/// The emulator with the board's machine and nothing around it.
pub fn command() -> Command {
    let mut command = Command::new(PROGRAM);
    command.args(["-M", "mps2-an386", "-display", "none", "-monitor", "none"]);
    command
}

/// A running board. Dropping it ends it.
#[derive(Debug)]
pub struct Emulator {
    image: PathBuf,
    options: Options,
    child: Child,
    /// Until the emulator has ended.
    watcher: Option<Watcher>,
    can: SocketAddr,
    rig: SocketAddr,
    debugger: Option<SocketAddr>,
    monitor: Option<SocketAddr>,
    log: Arc<Log>,
    readers: Vec<JoinHandle<()>>,
    record: RecordFile,
}

impl Emulator {
    /// Boots the image and waits until its serial lines are served.
    ///
    /// # Errors
    /// [`EmulatorError`].
    pub fn start(image: &Path, options: &Options) -> Result<Self, EmulatorError> {
        let mut tries = 1;
        loop {
            match Self::start_once(image, options) {
                Err(EmulatorError::Ended { complaint, .. })
                    if complaint.contains("Address already in use") && tries < PORT_TRIES =>
                {
                    tries += 1;
                }
                result => return result,
            }
        }
    }

    fn start_once(image: &Path, options: &Options) -> Result<Self, EmulatorError> {
        let can = local_address(options.can_port).map_err(EmulatorError::Start)?;
        let rig = local_address(options.rig_port).map_err(EmulatorError::Start)?;
        let mut command = command();
        let record = RecordFile::at(options.record.as_deref())?;
        command.arg("-semihosting-config").arg(record.semihosting(options.serial));
        for line in [can, rig] {
            // the UART sends single bytes; without "nodelay" each answer would wait 40 ms for the client's acknowledgement
            command.arg("-serial").arg(format!("tcp:{line},server=on,wait=off,nodelay=on"));
        }
        let debugger = options.debugger.then(|| local_address(None)).transpose().map_err(EmulatorError::Start)?;
        if let Some(address) = debugger {
            command.arg("-gdb").arg(format!("tcp:{address}"));
        }
        let monitor = options.monitor.then(|| local_address(None)).transpose().map_err(EmulatorError::Start)?;
        if let Some(address) = monitor {
            command.arg("-qmp").arg(format!("tcp:{address},server=on,wait=off"));
        }
        command.arg("-kernel").arg(image);
        let mut child = command
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(EmulatorError::Start)?;
        let watcher = Watcher::over(&child).ok();
        let log = Arc::new(Log::default());
        let readers = [
            child.stdout.take().map(|out: ChildStdout| follow(out, Arc::clone(&log), options.show_log)),
            child.stderr.take().map(|err: ChildStderr| follow(err, Arc::clone(&log), options.show_log)),
        ];
        let readers = readers.into_iter().flatten().collect();
        let (image, options) = (image.to_owned(), options.clone());
        let mut emulator = Self { image, options, child, watcher, can, rig, debugger, monitor, log, readers, record };
        emulator.wait_for_log(READY, BOOT_LIMIT)?;
        Ok(emulator)
    }

    /// Where an SLCAN client connects.
    pub fn can_address(&self) -> SocketAddr {
        self.can
    }

    /// Where the rig connects.
    pub fn rig_address(&self) -> SocketAddr {
        self.rig
    }

    /// The file that stands for the flash that the record lies in.
    pub fn record(&self) -> &Path {
        self.record.path()
    }

    /// Where a debugger connects, if the board serves one.
    pub fn debugger_address(&self) -> Option<SocketAddr> {
        self.debugger
    }

    /// Resets the board as its reset pin would. RAM and the record's flash keep their content.
    ///
    /// # Errors
    /// [`EmulatorError::Connect`] when the emulator serves no monitor.
    pub fn reset(&self) -> Result<(), EmulatorError> {
        let address = self.monitor.ok_or_else(|| io::Error::other("the emulator was started without a monitor"));
        address.and_then(monitor::reset).map_err(EmulatorError::Connect)
    }

    /// Takes the supply away and gives it back: RAM is lost, the record's flash keeps its content, the log begins anew.
    /// Ports that were free ones are other ones now.
    ///
    /// # Errors
    /// [`EmulatorError`]; the board is then off.
    pub fn power_cycle(&mut self) -> Result<(), EmulatorError> {
        self.end();
        let same_flash = Options { record: Some(self.record().to_owned()), ..self.options.clone() };
        let mut next = Self::start(&self.image, &same_flash)?;
        // the file goes with the board that made it
        std::mem::swap(&mut next.record, &mut self.record);
        next.options = self.options.clone();
        *self = next;
        Ok(())
    }

    /// The rig link, connected.
    ///
    /// # Errors
    /// [`EmulatorError::Connect`].
    pub fn connect_rig(&self) -> Result<TcpStream, EmulatorError> {
        let stream = TcpStream::connect(self.rig).map_err(EmulatorError::Connect)?;
        stream.set_nodelay(true).map_err(EmulatorError::Connect)?;
        Ok(stream)
    }

    /// Everything that the board has logged so far.
    pub fn log(&self) -> Vec<String> {
        self.log.lines().clone()
    }

    /// Waits until a line of the log contains `text`, and gives that line. Lines from before the call count too.
    ///
    /// # Errors
    /// [`EmulatorError::Silent`] after `limit`, [`EmulatorError::Ended`] if the board ended without such a line.
    pub fn wait_for_log(&mut self, text: &str, limit: Duration) -> Result<String, EmulatorError> {
        self.wait_for_log_times(text, 1, limit)
    }

    /// Waits until so many lines of the log contain `text`, and gives the last of these.
    ///
    /// # Errors
    /// As [`Emulator::wait_for_log`].
    pub fn wait_for_log_times(&mut self, text: &str, times: usize, limit: Duration) -> Result<String, EmulatorError> {
        let deadline = Instant::now() + limit;
        loop {
            // The state first: a line that came between the two looks is then still seen.
            let ended = self.exit_status();
            if ended.is_some() {
                self.finish_reading();
            }
            if let Some(line) = self.log.find(text, times, Duration::from_millis(20)) {
                return Ok(line);
            }
            if let Some(status) = ended {
                return Err(EmulatorError::Ended { status, complaint: self.log().join("\n") });
            }
            if Instant::now() >= deadline {
                return Err(EmulatorError::Silent(text.to_owned()));
            }
        }
    }

    /// Waits until the emulator ends.
    ///
    /// # Errors
    /// [`EmulatorError::StillRunning`] after `limit`.
    pub fn wait_for_end(&mut self, limit: Duration) -> Result<ExitStatus, EmulatorError> {
        let deadline = Instant::now() + limit;
        loop {
            if let Some(status) = self.exit_status() {
                self.finish_reading();
                return Ok(status);
            }
            if Instant::now() >= deadline {
                return Err(EmulatorError::StillRunning);
            }
            thread::sleep(Duration::from_millis(5));
        }
    }

    /// How the emulator ended, if it has.
    pub fn exit_status(&mut self) -> Option<ExitStatus> {
        let ended = self.child.try_wait().ok().flatten();
        if ended.is_some() {
            self.watcher = None;
        }
        ended
    }

    /// Ends the emulator.
    fn end(&mut self) {
        self.watcher = None;
        let _ = self.child.kill();
        let _ = self.child.wait();
        self.finish_reading();
    }

    fn finish_reading(&mut self) {
        for reader in self.readers.drain(..) {
            let _ = reader.join();
        }
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        self.end();
    }
}

/// The given port on this machine alone, or one that is free at this moment.
fn local_address(port: Option<u16>) -> io::Result<SocketAddr> {
    match port {
        Some(port) => Ok(SocketAddr::from((Ipv4Addr::LOCALHOST, port))),
        None => TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?.local_addr(),
    }
}
